/* POST /v1/check: all that there is to say of a request, which is read and not run. A child reads it, as one that is posted to run:
 * no HTTP thread does. What is no JSON, or no request, has an answer too: 200, with problems. */
#include "check_threads.h"
#include "error.h"
#include "handlers.h"
#include "memory_room.h"
#include "reply.h"
#include "service.h"

enum { BUSY_SECONDS = 5 };

static enum MHD_Result busy(struct exchange *e, const char *why)
{
    reply_header(e, "Retry-After", "%d", BUSY_SECONDS);
    return reply_error(e, SGA_E_BUSY, "%s Try again soon.", why);
}

/* The child has answered, or could not. */
static enum MHD_Result checked(struct exchange *e)
{
    struct sga_buf said = e->check.canonical;
    e->check.canonical = (struct sga_buf){ 0 };
    if (!e->check.ok) {
        sga_buf_free(&said);
        if (e->check.err.code == SGA_E_DRAINING || e->check.err.code == SGA_E_BUSY)
            reply_header(e, "Retry-After", "%d", BUSY_SECONDS);
        return reply_problem(e, &e->check.err);
    }
    reply_header(e, "Cache-Control", "no-store");
    return reply_buf(e, 200, TYPE_JSON, &said);
}

enum MHD_Result handle_check(struct exchange *e)
{
    if (e->check.done)
        return checked(e);            /* resumed */
    e->check.review = true;
    if (!room_for_reading(e->length))
        return busy(e, "There is not enough memory to read a request at this moment.");
    return check_threads_submit(e->service->check_threads, e) ? MHD_YES : busy(e, "Many requests wait to be read already.");
}
