#include "code_want.h"
#include "json_scan.h"

#include <string.h>

static const char *const NEEDED[] = { "\"constraints\"", "\"vector_field\"", "\"gauge\"" };

static bool holds(struct slice s, const char *word)
{
    size_t n = strlen(word);
    for (size_t i = 0; i + n <= s.len; i++)
        if (memcmp(s.at + i, word, n) == 0)
            return true;
    return false;
}

void code_want(const char *request, size_t length, bool start, struct sga_buf *out)
{
    struct slice whole = scan_value(request, request + length), want = scan_member(whole, "want");
    bool list = want.at && *want.at == '[', word = want.at && *want.at == '"';
    if (!list && !word) {
        sga_buf_put(out, request, length);
        return;
    }
    const char *end = want.at + want.len;
    sga_buf_put(out, request, (size_t)(want.at - request));
    sga_buf_put(out, "[", 1);
    for (size_t i = 0; i < sizeof NEEDED / sizeof *NEEDED; i++)
        if (!holds(want, NEEDED[i]))
            sga_buf_puts(out, NEEDED[i]), sga_buf_puts(out, ", ");
    if (start && scan_member(whole, "trajectory").at && !holds(want, "\"trajectory\"") && !holds(want, "\"consistent_initial\""))
        sga_buf_puts(out, "\"consistent_initial\", ");
    sga_buf_put(out, want.at + list, (size_t)(end - want.at - list));
    sga_buf_puts(out, word ? "]" : "");
    sga_buf_put(out, end, (size_t)(request + length - end));
}
