/* GET / and /page/NAME: the page for browsers, as it was built in. It is the same for everyone and needs no token; what it asks of the
 * service does. Nothing but this server's own files runs in it, or is asked by it. */
#include "config.h"
#include "handlers.h"
#include "page_files.h"
#include "prefer.h"
#include "reply.h"
#include "service.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"

#define POLICY "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; base-uri 'none'; " \
               "form-action 'none'; frame-ancestors 'none'"
_Static_assert(sizeof POLICY <= sizeof ((struct exchange *)0)->header->value, "a header has room for it");

static const struct page_file *find(const char *name)
{
    for (const struct page_file *f = page_files; f->name; f++)
        if (strcmp(f->name, name) == 0)
            return f;
    return NULL;
}

static const char *type_of(const char *name)
{
    static const struct { const char *end, *type; } types[] = {
        { ".html", "text/html; charset=utf-8" }, { ".css", "text/css; charset=utf-8" }, { ".js", "text/javascript; charset=utf-8" },
        { ".svg", "image/svg+xml" }, { ".json", TYPE_JSON },
    };
    const char *end = strrchr(name, '.');
    for (size_t i = 0; end && i < sizeof types / sizeof *types; i++)
        if (strcmp(end, types[i].end) == 0)
            return types[i].type;
    return "application/octet-stream";
}

enum MHD_Result handle_page(struct exchange *e)
{
    const struct page_file *f = strcmp(e->service->config->ui, "no") == 0 ? NULL : find(*e->segment ? e->segment : "index.html");
    if (!f)
        return reply_error(e, SGA_E_NOT_FOUND, "There is nothing at this path. /openapi.json lists what there is.");
    bool packed = prefer_gzip(exchange_header(e, "Accept-Encoding"));
    unsigned char sum[DIGEST_BYTES];
    char etag[2 * 8 + 5];
    digest(sum, f->text, f->length);
    snprintf(etag, sizeof etag, "\"%02x%02x%02x%02x%02x%02x%02x%02x%s\"", sum[0], sum[1], sum[2], sum[3], sum[4], sum[5], sum[6], sum[7], packed ? "-z" : "");
    reply_header(e, "ETag", "%s", etag);
    reply_header(e, "Cache-Control", "no-cache");
    reply_header(e, "Vary", "Accept-Encoding");
    reply_header(e, "Content-Security-Policy", "%s", POLICY);
    reply_header(e, "Referrer-Policy", "no-referrer");
    if (reply_matches(e, etag))
        return reply_empty(e, 304);
    if (packed)
        reply_header(e, "Content-Encoding", "gzip");
    return reply_static(e, 200, type_of(f->name), (const char *)(packed ? f->packed : f->text), packed ? f->packed_length : f->length);
}
