/* The tradeoff of a result into files: the same texts that the daemon sends. */
#include "save.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "buf.h"
#include "tradeoff_view.h"

static bool save(const char *name, struct sga_buf *text)
{
    FILE *f = fopen(name, "we");
    bool ok = f && fwrite(text->data, 1, text->len, f) == text->len;
    ok = f && fclose(f) == 0 && ok;
    if (!ok)
        fprintf(stderr, "sga: cannot write %s: %s\n", name, strerror(errno));
    sga_buf_free(text);
    return ok;
}

bool save_tradeoff(struct slice result, const char *csv, const char *svg)
{
    struct slice t = scan_member(result, "tradeoff");
    struct sga_buf out = { 0 };
    if (!t.at) {
        fprintf(stderr, "sga: the result has no tradeoff: add \"tradeoff\" to \"want\"\n");
        return false;
    }
    if (csv) {
        tradeoff_csv(t, &out);
        if (!save(csv, &out))
            return false;
    }
    if (!svg)
        return true;
    tradeoff_svg(t, &out);
    return save(svg, &out);
}
