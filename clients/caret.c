/* The pointer is followed in the text as it was sent; columns count characters, as editors do. */
#include "caret.h"

#include <stdlib.h>
#include <string.h>

#include "json_string.h"

/* One reference token of the pointer (RFC 6901), of which *p is the first byte behind the slash. */
static void take_token(const char **p, struct sga_buf *token)
{
    sga_buf_clear(token);
    sga_buf_puts(token, "");
    for (; **p && **p != '/'; ++*p) {
        bool escape = **p == '~' && ((*p)[1] == '0' || (*p)[1] == '1');
        char c = !escape ? **p : *++*p == '0' ? '~' : '/';
        sga_buf_put(token, &c, 1);
    }
}

static struct slice element(struct slice array, const char *token)
{
    const char *cursor = NULL;
    struct slice v = scan_next(array, &cursor);
    for (long k = strtol(token, NULL, 10); k > 0 && v.at; k--)
        v = scan_next(array, &cursor);
    return v;
}

static struct slice follow(struct slice value, const char *pointer)
{
    struct sga_buf token = { 0 };
    while (*pointer == '/' && value.at) {
        pointer++;
        take_token(&pointer, &token);
        value = *value.at == '[' ? element(value, token.data) : *value.at == '{' ? scan_member(value, token.data) : (struct slice){ NULL, 0 };
    }
    sga_buf_free(&token);
    return value;
}

/* The n-th line (from 1) of a text; NULL: it has fewer. */
static const char *line_of(const char *text, int n)
{
    for (; n > 1 && text; n--)
        text = (text = strchr(text, '\n')) ? text + 1 : NULL;
    return text;
}

static bool inside_character(char c)
{
    return ((unsigned char)c & 0xC0) == 0x80;
}

/* Of a long line what is around the column. */
static void put_marked(struct sga_buf *out, const char *line, int column)
{
    enum { BEFORE = 60, SHOWN = 120 };
    size_t n = strcspn(line, "\r\n"), at = 0, from = 0;
    for (int k = 1; at < n && k < column; k++)
        for (at++; at < n && inside_character(line[at]); at++)
            ;
    for (int k = 0; n > SHOWN && at > BEFORE && from < at - BEFORE; k++)
        for (from++, column--; from < at && inside_character(line[from]); from++)
            ;
    line += from;
    n -= from;
    size_t shown = n < SHOWN ? n : SHOWN;
    while (shown < n && inside_character(line[shown]))
        shown++;
    sga_buf_printf(out, "    %s%.*s%s\n    %s", from ? "..." : "", (int)shown, line, shown < n ? "..." : "", from ? "   " : "");
    for (size_t i = 0; i < n && column > 1; i++) {
        if (inside_character(line[i]))
            continue;
        sga_buf_put(out, line[i] == '\t' ? "\t" : " ", 1);
        column--;
    }
    sga_buf_puts(out, "^\n");
}

void caret_put(struct sga_buf *out, struct slice problem, struct slice request)
{
    int line = (int)scan_number(scan_member(problem, "line"), 0), column = (int)scan_number(scan_member(problem, "column"), 0);
    char *pointer = string_take(scan_member(problem, "pointer"));
    struct sga_buf text = { 0 };
    struct slice value = pointer && *pointer ? follow(scan_value(request.at, request.at + request.len), pointer) : (struct slice){ NULL, 0 };
    if (value.at && *value.at == '"')
        string_put(&text, value);
    else if (!pointer || !*pointer)
        sga_buf_put(&text, request.at, request.len);
    const char *found = line > 0 && column > 0 && text.data ? line_of(text.data, line) : NULL;
    if (found)
        put_marked(out, found, column);
    sga_buf_free(&text);
    free(pointer);
}
