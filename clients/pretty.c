/* Indented JSON from compact JSON, token by token; no recursion, no tree. */
#include "pretty.h"

#include <stdbool.h>
#include <string.h>

/* Does the list or object at s close before another one opens? Its length then, or 0. */
static size_t flat_length(const char *s, const char *end)
{
    bool quoted = false;
    for (const char *p = s + 1; p < end; p++) {
        if (quoted && *p == '\\')
            p++;
        else if (*p == '"')
            quoted = !quoted;
        else if (!quoted && (*p == '[' || *p == '{'))
            return 0;
        else if (!quoted && (*p == ']' || *p == '}'))
            return (size_t)(p - s) + 1;
    }
    return 0;
}

static void newline(struct sga_buf *out, int depth)
{
    sga_buf_puts(out, "\n");
    for (int i = 0; i < depth; i++)
        sga_buf_puts(out, "  ");
}

/* One line: a blank after each comma and colon outside strings. */
static void put_flat(struct sga_buf *out, const char *s, size_t n)
{
    bool quoted = false;
    for (size_t i = 0; i < n; i++) {
        sga_buf_put(out, s + i, 1);
        if (quoted && s[i] == '\\')
            sga_buf_put(out, s + ++i, 1);
        else if (s[i] == '"')
            quoted = !quoted;
        else if (!quoted && (s[i] == ',' || s[i] == ':'))
            sga_buf_puts(out, " ");
    }
}

void pretty_json(struct slice value, struct sga_buf *out)
{
    const char *s = value.at, *end = s + value.len;
    int depth = 0;
    while (s < end) {
        if (*s == '"') {
            struct slice text = scan_value(s, end);
            sga_buf_put(out, text.at, text.len);
            s += text.len;
            continue;
        }
        size_t flat = *s == '[' || (*s == '{' && depth) ? flat_length(s, end) : 0;
        if (flat && (*s == '[' || flat <= 100)) {
            put_flat(out, s, flat);
            s += flat;
            continue;
        }
        if (*s == '}' || *s == ']')
            newline(out, --depth);
        sga_buf_put(out, s, 1);
        if (*s == '{' || *s == '[')
            newline(out, ++depth);
        else if (*s == ',')
            newline(out, depth);
        else if (*s == ':')
            sga_buf_puts(out, " ");
        s++;
    }
    sga_buf_puts(out, "\n");
}
