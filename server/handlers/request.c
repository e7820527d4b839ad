/* GET /v1/jobs/ID/request: the request of a job, whether it has ended or not, as it is kept: canonical, so that it can be posted again
 * and is the same job. It never changes, so its entity tag is the job's id. */
#include "handlers.h"
#include "lookup.h"
#include "reply.h"
#include "service.h"
#include "store.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum MHD_Result handle_request(struct exchange *e)
{
    struct sga_buf b = { 0 };
    char etag[ID_LENGTH + 16], *text = NULL;
    size_t length = 0;
    if (!digest_is_id(e->segment, strlen(e->segment)) || !exchange_sees(e))
        return reply_lookup(e, LOOKUP_NONE);
    enum store_answer found = store_request(e->service->store, e->segment, &text, &length);
    if (found != STORE_FOUND)
        return reply_lookup(e, found == STORE_NONE ? LOOKUP_NONE : LOOKUP_BROKEN);
    snprintf(etag, sizeof etag, "\"%s-request\"", e->segment);
    reply_header(e, "Cache-Control", "no-cache");
    if (reply_tag(e, etag, length, "")) {
        free(text);
        return reply_empty(e, 304);
    }
    b = (struct sga_buf){ .data = text, .len = length, .cap = length + 1 };
    return reply_buf(e, 200, TYPE_JSON, &b);
}
