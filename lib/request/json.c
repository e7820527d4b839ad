/* Text to JSON. A scan before the library's parser refuses, with a better message or at
 * all, what it would take silently: numbers that underflow to 0, NaN spellings, depth. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "reader.h"
#include "watch.h"

struct scan {
    const char *text;
    size_t length, at;
    struct sga_error *err;
};

/* Line and column (in characters) of a byte of a text that may hold zeros. */
static void place(const char *text, size_t at, struct sga_error *err)
{
    err->line = err->column = 1;
    for (size_t i = 0; i < at; i++) {
        if (text[i] == '\n') {
            err->line++;
            err->column = 1;
        } else if (((unsigned char)text[i] & 0xC0) != 0x80) {
            err->column++;
        }
    }
}

static bool fail(struct scan *s, size_t at, enum sga_code code, const char *detail)
{
    if (s->err->code != SGA_E_OK)
        return false;
    place(s->text, at, s->err);
    return sga_fail(s->err, code, "%s (line %d, column %d of the body)", detail, s->err->line, s->err->column);
}

static bool is_number_byte(char c)
{
    return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.' || c == 'e' || c == 'E';
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static void skip_string(struct scan *s)
{
    for (s->at++; s->at < s->length && s->text[s->at] != '"'; s->at++)
        if (s->text[s->at] == '\\')
            s->at++;
    s->at++;
}

/* A word outside strings: true, false and null are left to the parser. */
static bool check_word(struct scan *s)
{
    size_t start = s->at, n;
    while (s->at < s->length && is_letter(s->text[s->at]))
        s->at++;
    n = s->at - start;
    const char *word = s->text + start;
    if ((n == 3 && strncasecmp(word, "nan", 3) == 0)
       || (n == 3 && strncasecmp(word, "inf", 3) == 0) || (n == 8 && strncasecmp(word, "infinity", 8) == 0))
        return fail(s, start, SGA_E_JSON_SYNTAX, "JSON has no NaN and no infinity; leave the member out, use null "
                                                 "where it is allowed, or send an expression as a string");
    return true;
}

/* What the number token is as a double: too small and too large are refused here. */
static bool check_number(struct scan *s)
{
    size_t start = s->at, n;
    bool real = false, nonzero = false, exponent = false;
    for (; s->at < s->length && is_number_byte(s->text[s->at]); s->at++) {
        char c = s->text[s->at];
        real = real || c == '.' || c == 'e' || c == 'E';
        exponent = exponent || c == 'e' || c == 'E';
        nonzero = nonzero || (!exponent && c >= '1' && c <= '9');
    }
    n = s->at - start;
    if (s->at < s->length && is_letter(s->text[s->at]))
        return check_word(s);           /* -Infinity; anything else is the parser's to refuse */
    SGA_FREED char *copy = sga_malloc(n + 1);
    memcpy(copy, s->text + start, n);
    copy[n] = 0;
    double v = strtod(copy, NULL);
    bool long_integer = !real && n >= 19 && fabs(v) >= 9223372036854775808.0 && strcmp(copy, "-9223372036854775808") != 0;
    if (nonzero && v == 0)
        return fail(s, start, SGA_E_JSON_NUMBER, "a number is so small that a double holds it as 0; send it as a "
                                                 "string: strings are exact");
    if (isinf(v))
        return fail(s, start, SGA_E_JSON_NUMBER, "a number is too large for a double; send it as a string: strings "
                                                 "are exact");
    if (long_integer)
        return fail(s, start, SGA_E_JSON_NUMBER, "an integer does not fit 64 bits; send it as a string: strings are "
                                                 "exact");
    return true;
}

static bool scan(struct scan *s)
{
    int depth = 0;
    while (s->at < s->length) {
        char c = s->text[s->at];
        if (c == '"') {
            skip_string(s);
        } else if (is_number_byte(c) && c != 'e' && c != 'E') {
            if (!check_number(s))
                return false;
        } else if (is_letter(c)) {
            if (!check_word(s))
                return false;
        } else {
            depth += (c == '{' || c == '[') - (c == '}' || c == ']');
            if (depth > REQUEST_MAX_DEPTH)
                return fail(s, s->at, SGA_E_JSON_DEPTH, "the JSON is nested deeper than the limit of 64");
            s->at++;
        }
    }
    return true;
}

/* The library's text begins with what is wrong and ends with "near '...'". */
static void explain(const json_error_t *e, struct sga_error *err)
{
    enum sga_code code = SGA_E_JSON_SYNTAX;
    const char *more = "";
    switch (json_error_code(e)) {
    case json_error_duplicate_key:
        code = SGA_E_DUPLICATE_NAME;
        more = "; each member of an object may be given once";
        break;
    case json_error_numeric_overflow:
        code = SGA_E_JSON_NUMBER;
        more = "; send it as a string: strings are exact";
        break;
    case json_error_stack_overflow:
        code = SGA_E_JSON_DEPTH;
        break;
    case json_error_invalid_utf8:
        more = "; the body must be UTF-8";
        break;
    case json_error_null_character:
        more = "; a text must not hold the character U+0000";
        break;
    default:
        break;
    }
    sga_fail(err, code, "%s (line %d, column %d of the body)%s", e->text, e->line, e->column, more);
    err->line = e->line > 0 ? e->line : 0;
    err->column = e->column > 0 ? e->column : 0;
}

/* Bytes of the well-formed UTF-8 character at s, 0 if there is none. */
static int character(const unsigned char *s)
{
    int n = s[0] < 0x80 ? 1 : s[0] >= 0xF0 && s[0] < 0xF5 ? 4 : s[0] >= 0xE0 && s[0] < 0xF0 ? 3 : s[0] >= 0xC2 && s[0] < 0xE0 ? 2 : 0;
    for (int i = 1; i < n; i++)
        if ((s[i] & 0xC0) != 0x80)
            return 0;
    return n;
}

void make_utf8(char *text)
{
    unsigned char *s = (unsigned char *)text;
    while (*s) {
        int n = character(s);
        if (!n)
            *s = '?';
        s += n ? n : 1;
    }
}

json_t *load_json(const char *text, size_t length, struct sga_error *err)
{
    struct sga_error own = { 0 };
    struct scan s = { .text = text, .length = length, .err = err ? err : &own };
    if (s.err->code != SGA_E_OK || !scan(&s))
        return NULL;
    size_t blank = 0;
    while (blank < length && strchr(" \t\r\n", text[blank]) && text[blank])
        blank++;
    if (blank == length) {
        fail(&s, 0, SGA_E_JSON_SYNTAX, "the body is empty; a request is a JSON object");
        return NULL;
    }
    json_error_t e;
    sga_watch_refused();
    json_t *v = json_loadb(text, length, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &e);
    /* Where memory ends, the library says that the text is wrong. */
    if (sga_watch_refused()) {
        json_decref(v);
        sga_fail(s.err, SGA_E_LIMIT_MEMORY, "no memory is left to read the request; send a smaller one, or try again later");
        return NULL;
    }
    if (!v) {
        explain(&e, s.err);
        make_utf8(s.err->detail);
    }
    return v;
}

void request_init(void)
{
    json_set_alloc_funcs(sga_try_malloc, free);
}
