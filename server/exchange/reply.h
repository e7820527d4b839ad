/* Replies. Every handler ends in one of these; each queues one response and notes its
 * status. Extra headers are given before. */
#ifndef SERVER_REPLY_H
#define SERVER_REPLY_H

#include "error.h"
#include "exchange.h"

struct finished;
struct job_look;

#define TYPE_JSON "application/json"

void reply_header(struct exchange *e, const char *name, const char *fmt, ...) __attribute__((format(printf, 3, 4)));
/* A response made elsewhere; it is consumed. NULL: the connection is closed. */
enum MHD_Result reply_response(struct exchange *e, int status, const char *type, struct MHD_Response *response);
/* The buffer's memory is taken over. */
enum MHD_Result reply_buf(struct exchange *e, int status, const char *type, struct sga_buf *b);
/* Text that lives as long as the program. */
enum MHD_Result reply_static(struct exchange *e, int status, const char *type, const char *text, size_t length);
enum MHD_Result reply_empty(struct exchange *e, int status);
/* Problem details with the status of the code. */
enum MHD_Result reply_problem(struct exchange *e, const struct sga_error *err);
enum MHD_Result reply_error(struct exchange *e, enum sga_code code, const char *fmt, ...) __attribute__((format(printf, 3, 4)));
/* A finished job as a whole; the reference is consumed. */
enum MHD_Result reply_finished(struct exchange *e, int status, struct finished *f, bool cached);
/* A job that has not ended: its present state. */
enum MHD_Result reply_job(struct exchange *e, int status, const struct job_look *look);
/* May the caller know of the job of the path? Where jobs are each token's own, of those only that it
 * asked for, or as an administrator. */
bool exchange_sees(struct exchange *e);
/* The job of the path: made again where its result is gone, for who may submit. */
enum lookup exchange_lookup(struct exchange *e, struct finished **f);
/* A job that was looked up and cannot be given. */
enum MHD_Result reply_lookup(struct exchange *e, enum lookup outcome);
/* Chooses between the body as it is and gzip, by Accept-Encoding and its length (SIZE_MAX: not known), and gives the reply the
 * tag of that one: each has its own, for they differ by the byte. vary: what else the choice depends on, as "Accept, ", or "".
 * Does If-None-Match name that tag? */
bool reply_tag(struct exchange *e, const char *etag, size_t length, const char *vary);
/* A body in at most three pieces, packed where that was chosen. release(cls) once it is sent or given up. */
enum MHD_Result reply_pieces(struct exchange *e, int status, const char *type, const struct MHD_IoVec *part, int count,
                             MHD_ContentReaderFreeCallback release, void *cls);
/* A body that is made while it is sent. */
enum MHD_Result reply_stream(struct exchange *e, int status, const char *type, MHD_ContentReaderCallback read,
                             MHD_ContentReaderFreeCallback release, void *cls);
/* Does If-None-Match name this tag? */
bool reply_matches(struct exchange *e, const char *etag);

#endif
