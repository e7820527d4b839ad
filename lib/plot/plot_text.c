/* Text in XML. */
#include "plot_text.h"

#include "buf.h"

/* The length of the UTF-8 character at s, 0 where there is none that XML allows. */
static int character(const unsigned char *s)
{
    if (*s < 0x80)
        return *s >= 0x20 || *s == '\t' || *s == '\n' || *s == '\r';
    int more = *s >= 0xc2 && *s <= 0xdf ? 1 : *s >= 0xe0 && *s <= 0xef ? 2 : *s >= 0xf0 && *s <= 0xf4 ? 3 : 0;
    unsigned long code = more ? *s & (0x3fu >> more) : 0;
    for (int k = 1; k <= more; k++) {
        if ((s[k] & 0xc0) != 0x80)
            return 0;
        code = code << 6 | (s[k] & 0x3f);
    }
    static const unsigned long least[] = { 0, 0x80, 0x800, 0x10000 };
    bool allowed = more && code >= least[more] && code <= 0x10ffff && !(code >= 0xd800 && code <= 0xdfff) && code != 0xfffe && code != 0xffff;
    return allowed ? more + 1 : 0;
}

void plot_escape(const char *text, struct sga_buf *out)
{
    for (const unsigned char *s = (const unsigned char *)text; *s;) {
        int n = character(s);
        if (*s == '&')
            sga_buf_puts(out, "&amp;");
        else if (*s == '<')
            sga_buf_puts(out, "&lt;");
        else if (*s == '>')
            sga_buf_puts(out, "&gt;");
        else if (*s == '"')
            sga_buf_puts(out, "&quot;");
        else if (n)
            sga_buf_put(out, (const char *)s, (size_t)n);
        s += n ? n : 1;
    }
}
