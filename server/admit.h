/* Which requests are let in: what the HTTP library would accept although two readers of the
 * same bytes could disagree about it, and who may ask. */
#ifndef SERVER_ADMIT_H
#define SERVER_ADMIT_H

#include "error.h"
#include "exchange.h"

/* Looks at the request line and the headers, before any of the body is read. False with
 * err filled; then the connection should be closed. */
bool admit(struct exchange *e, struct sga_error *err);
/* For requests with a body that is a job: type and announced size. */
bool admit_body(struct exchange *e, struct sga_error *err);

#endif
