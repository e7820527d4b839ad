/* Open connections, each with an absolute deadline for what it is doing: the HTTP library's
 * own timeout is for silence only, and never ends a client that drips a byte a second. */
#ifndef SERVER_CONNS_H
#define SERVER_CONNS_H

#include <stdbool.h>

struct conns;
struct conn;
struct front;

struct conns *conns_new(void);
void conns_free(struct conns *cs);
/* NULL when memory ends. The descriptor must stay open until conn_remove. secure: TLS is spoken. */
struct conn *conn_add(struct conns *cs, int fd, bool secure, double deadline);
void conn_remove(struct conns *cs, struct conn *c);
/* What reads its bytes; NULL where the connection is. */
struct front *conn_front(struct conn *c);
/* sga_now() value after which the connection is cut; 0: never. NULL is allowed. */
void conn_deadline(struct conn *c, double deadline);
/* Has a request been begun (true), or the last one been answered? One that was never asked anything does not rest. */
void conn_busy(struct conn *c, bool busy);
/* Cuts those that rest; how many. */
int conns_cut_resting(struct conns *cs);
/* Cuts whose deadline has passed (all: every one); how many. */
int conns_reap(struct conns *cs, double now, int all);
unsigned long conns_count(struct conns *cs);

#endif
