/* A JSON scanner: brackets are counted, strings are skipped, nothing is built. */
#include "json_scan.h"
#include "spool.h"

#include <stdlib.h>
#include <string.h>

/* What each byte is to the scanner. */
enum { PLAIN = 0, ENDS = 1, NESTS = 2, OPENS = 4 };     /* ends a number or a word; a bracket or a quote; one that opens */
static const unsigned char class[256] = {
    [','] = ENDS, [']'] = ENDS | NESTS, ['}'] = ENDS | NESTS, [' '] = ENDS, ['\t'] = ENDS, ['\r'] = ENDS, ['\n'] = ENDS,
    [':'] = ENDS, [0] = ENDS, ['['] = NESTS | OPENS, ['{'] = NESTS | OPENS, ['"'] = NESTS,
};

/* The first byte from s on that is one of a kind. */
static const char *find(const char *s, const char *end, unsigned kind)
{
    while (s < end && !(class[(unsigned char)*s] & kind))
        s++;
    return s;
}

static const char *blank(const char *s, const char *end)
{
    while (s < end && (*s == ' ' || *s == '\t' || *s == '\n' || *s == '\r'))
        s++;
    return s;
}

/* Past the closing quote; s is at the opening one. */
static const char *skip_string(const char *s, const char *end)
{
    for (s++; s < end && *s != '"'; s++)
        if (*s == '\\')
            s++;
    return s < end ? s + 1 : end;
}

struct slice scan_value(const char *s, const char *end)
{
    s = blank(s, end);
    const char *start = s, *rested = s;
    int depth = 0;
    while (s < end) {
        if (s - rested >= SPOOL_STEP) {
            spool_rest(rested, (size_t)(s - rested));
            rested = s;
        }
        if (depth) {
            const char *stop = end - s > SPOOL_STEP ? s + SPOOL_STEP : end;
            s = find(s, stop, NESTS);
            if (s == stop && stop < end)
                continue;
        }
        if (s >= end)
            break;
        if (*s == '"') {
            s = skip_string(s, end);
        } else if (class[(unsigned char)*s] & OPENS) {
            depth++;
            s++;
        } else if (class[(unsigned char)*s] & NESTS) {
            depth--;
            s++;
        } else {
            s = find(s, end, ENDS);
            break;
        }
        if (depth <= 0)
            break;
    }
    return (struct slice){ s > start ? start : NULL, (size_t)(s - start) };
}

struct slice scan_member(struct slice object, const char *key)
{
    struct slice none = { NULL, 0 };
    if (object.len < 2 || *object.at != '{')
        return none;
    const char *end = object.at + object.len - 1, *s = object.at + 1;
    size_t n = strlen(key);
    for (;;) {
        struct slice name = scan_value(s, end);
        if (!name.at || *name.at != '"')
            return none;
        s = blank(name.at + name.len, end);
        if (s >= end || *s != ':')
            return none;
        struct slice value = scan_value(s + 1, end);
        if (!value.at)
            return none;
        if (name.len == n + 2 && memcmp(name.at + 1, key, n) == 0)
            return value;
        s = blank(value.at + value.len, end);
        if (s >= end || *s != ',')
            return none;
        s++;
    }
}

struct slice scan_next(struct slice array, const char **cursor)
{
    struct slice none = { NULL, 0 };
    if (array.len < 2 || *array.at != '[')
        return none;
    const char *end = array.at + array.len - 1;
    const char *s = blank(*cursor ? *cursor : array.at + 1, end);
    if (*cursor && s < end && *s == ',')
        s++;
    struct slice value = scan_value(s, end);
    if (value.at)
        *cursor = value.at + value.len;
    return value;
}

double scan_number(struct slice value, double otherwise)
{
    char text[64];
    if (!value.at || value.len >= sizeof text)
        return otherwise;
    memcpy(text, value.at, value.len);
    text[value.len] = 0;
    char *stop;
    double v = strtod(text, &stop);
    return stop == text || *stop ? otherwise : v;
}
