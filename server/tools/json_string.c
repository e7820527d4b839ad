/* JSON strings as text: escapes are undone, \u as UTF-8. */
#include "json_string.h"

#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "json_scan.h"

static void put_code(struct sga_buf *out, unsigned c)
{
    char u[4];
    size_t n = 0;
    if (c < 0x80) {
        u[n++] = (char)c;
    } else if (c < 0x800) {
        u[n++] = (char)(0xc0 | c >> 6);
    } else if (c < 0x10000) {
        u[n++] = (char)(0xe0 | c >> 12);
        u[n++] = (char)(0x80 | (c >> 6 & 0x3f));
    } else {
        u[n++] = (char)(0xf0 | c >> 18);
        u[n++] = (char)(0x80 | (c >> 12 & 0x3f));
        u[n++] = (char)(0x80 | (c >> 6 & 0x3f));
    }
    if (c >= 0x80)
        u[n++] = (char)(0x80 | (c & 0x3f));
    sga_buf_put(out, u, n);
}

static unsigned hex4(const char *s)
{
    char digits[5] = { s[0], s[1], s[2], s[3], 0 };
    return (unsigned)strtoul(digits, NULL, 16);
}

/* s is past `\u`; returns past what was used. */
static const char *put_unicode(struct sga_buf *out, const char *s, const char *end)
{
    if (end - s < 4)
        return end;
    unsigned c = hex4(s);
    s += 4;
    if (c >= 0xd800 && c < 0xdc00 && end - s >= 6 && s[0] == '\\' && s[1] == 'u') {
        c = 0x10000 + ((c - 0xd800) << 10) + (hex4(s + 2) - 0xdc00);
        s += 6;
    }
    put_code(out, c);
    return s;
}

void string_put(struct sga_buf *out, struct slice value)
{
    static const char from[] = "bfnrt", to[] = "\b\f\n\r\t";
    if (!value.at || *value.at != '"') {
        sga_buf_put(out, value.at, value.len);
        return;
    }
    for (const char *s = value.at + 1, *end = value.at + value.len - 1; s < end;) {
        if (*s != '\\' || s + 1 >= end) {
            sga_buf_put(out, s++, 1);
            continue;
        }
        const char *known = strchr(from, s[1]);
        if (s[1] == 'u') {
            s = put_unicode(out, s + 2, end);
            continue;
        }
        sga_buf_put(out, known ? to + (known - from) : s + 1, 1);
        s += 2;
    }
}

char *string_take(struct slice value)
{
    struct sga_buf b = { 0 };
    string_put(&b, value);
    return sga_buf_take(&b);
}
