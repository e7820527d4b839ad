/* Who is at the other end. */
#ifndef SERVER_PEER_H
#define SERVER_PEER_H

#include <sys/socket.h>

enum { PEER_TEXT = 46 };

/* An address, or "unix" for a socket of this machine. Behind a proxy, the proxy. NULL: not known. */
const char *peer_text(const struct sockaddr *a, char text[PEER_TEXT]);

#endif
