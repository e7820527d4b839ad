/* The front: it reads the bytes of connections in place of the HTTP library, so that framing.h judges them before that sees
 * one, and answers what it refuses by itself, with one status line, once all that came before is answered.
 *
 * How: the library takes bytes by recv() and gnutls_record_recv() alone. This program has functions of these names, which the
 * loader prefers to those of the libraries; for a socket that is none of a connection here they do what these do. No byte is
 * copied or read twice, and what a connection is (its address, TLS, limits, times, waiting) stays the library's matter. The
 * service does not start where the names lead elsewhere, and a request whose head was not seen here is not answered. */
#ifndef SERVER_FRONT_H
#define SERVER_FRONT_H

#include <stdbool.h>
#include <stddef.h>

struct conn;
struct front;
struct sga_error;

/* Writes a whole reply about the refusal, with its head, and notes it. conn: as front_open had it. The length. */
enum { FRONT_REPLY = 4096 };
typedef size_t front_refuse(void *cls, struct conn *conn, int fd, bool head_request, const struct sga_error *err, char reply[FRONT_REPLY]);

/* Once, before any connection; as many as there may be descriptors. False with the reason in why: then nothing may be served. */
bool front_start(front_refuse *refuse, void *cls, char *why, size_t size);

/* A connection, from before its first byte until before its descriptor is closed; all of it on the thread that serves the
 * connection. session: of GnuTLS, NULL where TLS is not spoken. NULL when memory ends: then it is to be cut. */
struct front *front_open(int fd, void *session, struct conn *conn);
void front_close(struct front *f);      /* NULL is allowed */
/* A request begins. False: its head did not come by here. */
bool front_begin(struct front *f);
/* A reply to the request that began last is on its way. */
void front_answered(struct front *f);
/* Has a request been refused here? Then the one that is under way is not to be spoken of any more. */
bool front_refused(const struct front *f);

#endif
