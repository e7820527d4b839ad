/* The one writer of problem details: replies, failed jobs and reviews of requests share it. */
#include "problem.h"

#include <stdio.h>
#include <string.h>

#include "buf.h"
#include "error.h"

/* Length of the UTF-8 character at s, or 0. Overlong forms and surrogates are not told
 * apart: the texts are ours, only cut ends and foreign header bytes are to be mended. */
static size_t character(const unsigned char *s)
{
    size_t n = s[0] < 0x80 ? 1 : s[0] >= 0xc2 && s[0] < 0xe0 ? 2 : s[0] >= 0xe0 && s[0] < 0xf0 ? 3 : s[0] >= 0xf0 && s[0] < 0xf5 ? 4 : 0;
    for (size_t i = 1; i < n; i++)
        if ((s[i] & 0xc0) != 0x80)
            return 0;
    return n;
}

static void mended(struct sga_json *w, const char *key, const char *text)
{
    char copy[sizeof ((struct sga_error *)0)->detail];
    size_t len = 0;
    for (const unsigned char *s = (const unsigned char *)text; *s && len + 5 < sizeof copy;) {
        size_t n = character(s);
        if (n)
            memcpy(copy + len, s, n);
        else
            copy[len] = '?';
        len += n ? n : 1;
        s += n ? n : 1;
    }
    copy[len] = 0;
    sga_json_key(w, key);
    sga_json_string(w, copy);
}

void problem_write(struct sga_json *w, const struct sga_error *err)
{
    char type[96];
    snprintf(type, sizeof type, "/v1/schema/problem#%s", sga_code_text(err->code));
    sga_json_object(w);
    sga_json_key(w, "type"), sga_json_string(w, type);
    sga_json_key(w, "title"), sga_json_string(w, sga_code_title(err->code));
    sga_json_key(w, "status"), sga_json_int(w, sga_code_status(err->code));
    sga_json_key(w, "code"), sga_json_string(w, sga_code_text(err->code));
    mended(w, "detail", *err->detail ? err->detail : sga_code_title(err->code));
    if (*err->pointer || err->line > 0)
        mended(w, "pointer", err->pointer);
    if (err->line > 0 && err->column > 0) {
        sga_json_key(w, "line"), sga_json_int(w, err->line);
        sga_json_key(w, "column"), sga_json_int(w, err->column);
    }
    if (*err->stage)
        mended(w, "stage", err->stage);
    sga_json_end_object(w);
}

char *problem_text(const struct sga_error *err)
{
    struct sga_buf b = { 0 };
    struct sga_json w;
    sga_json_begin(&w, &b);
    problem_write(&w, err);
    return sga_buf_take(&b);
}
