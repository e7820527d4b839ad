/* Which requests are let in: what the HTTP library would accept although two readers of the
 * same bytes could disagree about it, and who may ask. */
#ifndef SERVER_ADMISSION_H
#define SERVER_ADMISSION_H

#include "exchange.h"

/* Looks at the request line and the headers, before any of the body is read. begin: the method,
 * where it came in. False with err filled; then, or where e->last is set, the connection is to
 * be closed after the reply. */
bool admit(struct exchange *e, const char *begin, struct sga_error *err);
enum { ADMIT_DROP_FACTOR = 4 };
/* May the body of a refused request be read and dropped? It may where it is announced to be
 * at most four times the limit and the client does not wait for our leave (Expect). Replying
 * at once costs the connection, and many clients never see such a reply. */
bool admit_drop(struct exchange *e);
/* Has the query only parameters of this list (names with blanks between), each once? What is not
 * known is refused: a misspelt filter would give everything. */
bool admit_query(struct exchange *e, const char *known, struct sga_error *err);
/* For requests with a body that is a job: type, coding and announced size. */
bool admit_body(struct exchange *e, struct sga_error *err);

#endif
