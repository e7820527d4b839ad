/* Open connections, each with an absolute deadline for what it is doing: the HTTP library's
 * own timeout is for silence only, and never ends a client that drips a byte a second.
 *
 * Where as many are open as may be, from one address or at one listening socket (a door), the one that has been open longest of
 * those with no request gives its place to the next: who holds connections keeps nobody out. */
#ifndef SERVER_CONNS_H
#define SERVER_CONNS_H

#include <stdatomic.h>
#include <stdbool.h>
#include <sys/socket.h>

struct conns;
struct conn;
struct front;

struct conns *conns_new(void);
void conns_free(struct conns *cs);
/* How many may be open at a door, and from one address (0: no limit); the numbers may change. Before the first is added. */
void conns_limit(struct conns *cs, const atomic_long *at_door, const atomic_long *from_address);
/* from: the client's address; those of UNIX sockets are not told apart. NULL when memory ends, or all that are open have a
 * request: then it is to be cut. *gave: whether another one gave its place. The descriptor must stay open until conn_remove.
 * session: as front_open has it. Cost: where many are open, a walk over them. */
struct conn *conn_add(struct conns *cs, int fd, void *session, int door, const struct sockaddr *from, double deadline, bool *gave);
void conn_remove(struct conns *cs, struct conn *c);
/* What reads its bytes; NULL where the connection is. */
struct front *conn_front(struct conn *c);
/* sga_now() value after which the connection is cut; 0: never. NULL is allowed. */
void conn_deadline(struct conn *c, double deadline);
/* Has a request been begun (true), or the last one been answered? One that was never asked anything does not rest. */
void conn_busy(struct conn *c, bool busy);
/* Ends those that rest, each once what has come on it is answered; how many. */
int conns_cut_resting(struct conns *cs);
/* Cuts whose deadline has passed (all: every one); how many. */
int conns_reap(struct conns *cs, double now, int all);
unsigned long conns_count(struct conns *cs);

#endif
