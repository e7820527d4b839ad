/* GET /v1/jobs/ID/tradeoff: speed against accuracy as JSON, as a table, or as an image. */
#include "error.h"
#include "finished.h"
#include "handlers.h"
#include "json_scan.h"
#include "result_part.h"
#include "tradeoff_view.h"

enum { AS_JSON, AS_CSV, AS_SVG, FORMATS };

static const struct result_part_format formats[FORMATS] = {
    [AS_JSON] = { "json", TYPE_JSON }, [AS_CSV] = { "csv", "text/csv" }, [AS_SVG] = { "svg", "image/svg+xml" },
};
static const struct result_part_kind kind = { "tradeoff", NULL, formats, FORMATS, "json, csv or svg", SGA_E_NO_TRADEOFF,
                                        "The request of this job asked for no tradeoff." };

enum MHD_Result handle_tradeoff(struct exchange *e)
{
    struct finished *f;
    struct slice tradeoff;
    struct sga_buf out = { 0 };
    enum MHD_Result rc;
    int format;
    if (!result_part_find(e, &kind, &f, &tradeoff, &format, &rc))
        return rc;
    if (format == AS_JSON)
        return result_part_send(e, f, tradeoff);
    if (format == AS_CSV)
        tradeoff_csv(tradeoff, &out);
    else
        tradeoff_svg(tradeoff, &out);
    finished_unref(f);
    return reply_buf(e, 200, format == AS_CSV ? "text/csv; charset=utf-8; header=present" : formats[format].type, &out);
}
