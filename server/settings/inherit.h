/* What a service that takes over from its predecessor is born with: the listening sockets, which go on taking connections meanwhile,
 * and a pipe by which it says that it is ready to. The predecessor names them in SGAD_TAKE_OVER=PID:ADDRESS,ADDRESS; the descriptors
 * begin at INHERIT_FIRST, in that order, and the pipe is the one after them. */
#ifndef SERVER_INHERIT_H
#define SERVER_INHERIT_H

#include <stdbool.h>

#define INHERIT_VARIABLE "SGAD_TAKE_OVER"
enum { INHERIT_FIRST = 3, INHERIT_MOST = 8 };

/* Once, before settings are read. A variable that is not of this process's parent is none. */
void inherit_read(void);
bool inherited(void);
/* Is a socket of this address among them? */
bool inherit_has(const char *address);
/* The socket of this address, the caller's from now on; -1: there is none (any more). */
int inherit_take(const char *address);
/* The settings are good, and every address is listened on: the predecessor may go. Sockets that were not taken are closed. */
void inherit_ready(void);

#endif
