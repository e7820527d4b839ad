/* Whole-number expressions, and texts with names in place of numbers. */
#include "index.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "error.h"
#include "expr.h"
#include "index_read.h"

int index_find(const struct index_scope *scope, const char *text, size_t length)
{
    for (int i = scope->names - 1; i >= 0; i--)
        if (scope->name[i].length == length && memcmp(scope->name[i].text, text, length) == 0)
            return i;
    return -1;
}

void index_start(struct index_reader *r, const char *text, size_t at, const struct index_scope *scope, struct sga_error *err)
{
    assert(scope->sizes <= scope->names && scope->names <= INDEX_SIZES + INDEX_LOOPS);
    *r = (struct index_reader){ .text = text, .scope = scope, .err = err, .tok = lex_next(text, at) };
}

void index_advance(struct index_reader *r)
{
    r->tok = lex_next(r->text, r->tok.start + r->tok.length);
}

bool index_is(const struct index_reader *r, char c)
{
    return r->tok.length == 1 && r->text[r->tok.start] == c;
}

bool index_fail(struct index_reader *r, size_t at, enum sga_code code, const char *what)
{
    if (r->err->code == SGA_E_OK)
        lex_place(r->text, at, &r->err->line, &r->err->column);
    return sga_fail(r->err, code, "%s", what);
}

static bool expected(struct index_reader *r)
{
    char shown[LEX_SHOWN], what[160];
    lex_show(r->text, r->tok, shown);
    bool name = r->tok.kind == LEX_NAME, sum = name && strstr(r->text, "sum(");
    snprintf(what, sizeof what, name ? "%s is no loop name and no size of system.sizes%s" : "found %s where a whole number, a loop name or a size is expected%s",
             shown, sum ? "; a sum is written sum(i = 1:3, x[i])" : "");
    return index_fail(r, r->tok.start, name ? SGA_E_EXPR_NAME : SGA_E_EXPR_SYNTAX, what);
}

static bool keep(struct index_reader *r, size_t at, bool overflow, long v)
{
    if (!overflow && v <= INDEX_MOST && v >= -INDEX_MOST)
        return true;
    char what[96];
    snprintf(what, sizeof what, "a whole number passes the limit of %d for indices, bounds and sizes", INDEX_MOST);
    return index_fail(r, at, SGA_E_LIMIT_VARIABLES, what);
}

static bool number(struct index_reader *r, long *out)
{
    long v = 0;
    for (size_t i = 0; i < r->tok.length; i++) {
        char c = r->text[r->tok.start + i];
        if (c < '0' || c > '9')
            return index_fail(r, r->tok.start, SGA_E_EXPR_SYNTAX, "indices, bounds and sizes are whole numbers, in digits");
        v = v * 10 + (c - '0');
        if (!keep(r, r->tok.start, false, v))
            return false;
    }
    *out = v;
    index_advance(r);
    return true;
}

static bool operand(struct index_reader *r, int depth, long *out)
{
    bool minus = false;
    for (; r->tok.kind == LEX_PLUS || r->tok.kind == LEX_MINUS; index_advance(r))
        minus ^= r->tok.kind == LEX_MINUS;
    if (r->tok.kind == LEX_NUMBER) {
        if (!number(r, out))
            return false;
    } else if (r->tok.kind == LEX_NAME) {
        int k = index_find(r->scope, r->text + r->tok.start, r->tok.length);
        if (k < 0)
            return expected(r);
        r->varies |= k >= r->scope->sizes;
        *out = r->scope->name[k].value;
        index_advance(r);
    } else if (r->tok.kind == LEX_OPEN) {
        if (depth == INDEX_NESTED)
            return index_fail(r, r->tok.start, SGA_E_EXPR_DEPTH, "parentheses in an index are nested deeper than the limit of 32");
        index_advance(r);
        if (!index_expression(r, depth + 1, out))
            return false;
        if (r->tok.kind != LEX_CLOSE)
            return index_fail(r, r->tok.start, SGA_E_EXPR_SYNTAX, "a ) is missing in an index; whole numbers are joined by + - * /");
        index_advance(r);
    } else {
        return expected(r);
    }
    if (minus)
        *out = -*out;
    return true;
}

static bool product(struct index_reader *r, int depth, long *out)
{
    if (!operand(r, depth, out))
        return false;
    while (r->tok.kind == LEX_TIMES || r->tok.kind == LEX_OVER) {
        bool over = r->tok.kind == LEX_OVER;
        size_t at = r->tok.start;
        long b, v = 0;
        index_advance(r);
        if (!operand(r, depth, &b))
            return false;
        if (over && (b == 0 || *out % b != 0))
            return index_fail(r, at, SGA_E_EXPR_UNDEFINED, b ? "this quotient is no whole number; choose bounds for which it is" : "division by 0 in an index; choose other bounds");
        bool overflow = !over && __builtin_mul_overflow(*out, b, &v);
        if (over)
            v = *out / b;
        if (!keep(r, at, overflow, v))
            return false;
        *out = v;
    }
    return true;
}

bool index_expression(struct index_reader *r, int depth, long *out)
{
    if (!product(r, depth, out))
        return false;
    while (r->tok.kind == LEX_PLUS || r->tok.kind == LEX_MINUS) {
        bool minus = r->tok.kind == LEX_MINUS;
        size_t at = r->tok.start;
        long b;
        index_advance(r);
        if (!product(r, depth, &b))
            return false;
        assert(labs(*out) <= INDEX_MOST && labs(b) <= INDEX_MOST);
        *out += minus ? -b : b;
        if (!keep(r, at, false, *out))
            return false;
    }
    return true;
}

bool index_value(const char *text, const struct index_scope *scope, long *out, struct sga_error *err)
{
    struct index_reader r;
    index_start(&r, text, 0, scope, err);
    if (!index_expression(&r, 0, out))
        return false;
    return r.tok.kind == LEX_END || index_fail(&r, r.tok.start, SGA_E_EXPR_SYNTAX, "more follows where a whole number ends; they are joined by + - * /");
}

/* The indices from [ on, worked out; the token is then behind the ]. */
static bool write_indices(struct index_reader *r, struct sga_buf *out)
{
    const char *before = "[";
    do {
        index_advance(r);
        size_t at = r->tok.start;
        long v;
        if (!index_expression(r, 0, &v))
            return false;
        if (index_is(r, ':'))
            return index_fail(r, r->tok.start, SGA_E_EXPR_SYNTAX, "a range stands for many names: it may be an element of a list or the name of a member, not a part of an expression; "
                                                                  "{\"for\": \"i = 1:3\", ...} repeats one, sum(i = 1:3, ...) adds terms up");
        if (v < 0)
            return index_fail(r, at, SGA_E_EXPR_NAME, "an index lies below 0; raise the lower bound of the loop, or shift the index");
        sga_buf_printf(out, "%s%ld", before, v);
        before = ",";
    } while (r->tok.kind == LEX_COMMA);
    if (!index_is(r, ']'))
        return index_fail(r, r->tok.start, SGA_E_EXPR_SYNTAX, "a ] is missing behind an index; whole numbers are joined by + - * /");
    sga_buf_puts(out, "]");
    return true;
}

bool index_joins(char c)
{
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.';
}

/* What is copied from the text next has the byte that is asked about, or is before it. */
static void note_source(struct index_spot *spot, const struct sga_buf *out, size_t copied, size_t most)
{
    size_t written = out->len - spot->from;
    if (spot->at >= written)
        spot->source = copied + (spot->at - written < most ? spot->at - written : most);
}

bool index_write_from(const char *text, const struct index_scope *scope, struct sga_buf *out, struct index_spot *spot, struct sga_error *err)
{
    struct index_reader r;
    size_t copied = 0;
    for (index_start(&r, text, 0, scope, err); r.tok.kind != LEX_END; index_advance(&r)) {
        if (r.tok.kind != LEX_NAME)
            continue;
        size_t start = r.tok.start, end = start + r.tok.length;
        int k = index_find(scope, text + start, r.tok.length);
        struct lex_token next = lex_next(text, end);
        bool indexed = next.kind == LEX_BAD && next.length == 1 && text[next.start] == '[' && text[end - 1] != ']'
            && expr_function(text + start, r.tok.length) == EXPR_UNDEF_OP;
        bool sum = k < 0 && index_is_sum(text, r.tok);
        if (!indexed && !sum && k < 0)
            continue;
        note_source(spot, out, copied, start - copied);
        sga_buf_put(out, text + copied, start - copied);
        if (sum) {
            if (!index_write_sum(&r, out, spot))
                return false;
        } else if (indexed) {
            sga_buf_put(out, text + start, r.tok.length);
            r.tok = next;
            if (!write_indices(&r, out))
                return false;
        } else {
            sga_buf_puts(out, start && index_joins(text[start - 1]) ? " " : "");
            sga_buf_printf(out, scope->name[k].value < 0 ? "(%ld)" : "%ld", scope->name[k].value);
            sga_buf_puts(out, index_joins(text[end]) ? " " : "");
        }
        assert(copied <= start && start < end && end <= r.tok.start + r.tok.length);
        copied = r.tok.start + r.tok.length;
    }
    note_source(spot, out, copied, SIZE_MAX);
    sga_buf_puts(out, text + copied);
    return true;
}

bool index_write(const char *text, const struct index_scope *scope, struct sga_buf *out, struct sga_error *err)
{
    struct index_spot none = { .from = out->len };
    return index_write_from(text, scope, out, &none, err);
}

size_t index_source(const char *text, const struct index_scope *scope, size_t at)
{
    SGA_ENDS(sga_buf_free) struct sga_buf out = { 0 };
    struct sga_error none = { 0 };
    struct index_spot spot = { .at = at };
    size_t length = strlen(text);
    index_write_from(text, scope, &out, &spot, &none);
    return spot.source < length ? spot.source : length;
}

/* All that stands between [ and ] is worked out, as index_write would have it: x[7], u[2,13]. */
static bool worked_out(const char *text)
{
    for (const char *s = strchr(text, '['); s; s = strchr(s, '[')) {
        do {
            size_t n = strspn(++s, "0123456789");
            if (n == 0 || n > 9 || (*s == '0' && n > 1))
                return false;
            s += n;
        } while (*s == ',');
        if (*s != ']')
            return false;
    }
    return true;
}

bool index_touches(const char *text, const struct index_scope *scope)
{
    if (!worked_out(text) || index_has_sum(text))
        return true;
    if (!scope->names)
        return false;
    for (struct lex_token t = lex_next(text, 0); t.kind != LEX_END; t = lex_next(text, t.start + t.length))
        if (t.kind == LEX_NAME && index_find(scope, text + t.start, t.length) >= 0)
            return true;
    return false;
}
