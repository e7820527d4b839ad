/* Sums in a text: sum(i = 1:n, j = 1:i, a[i,j]*x[j]), written out as terms. */
#include <assert.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "index_read.h"

static const char word[] = "sum", form[] = "a sum is written sum(i = 1:3, x[i]), over several names sum(i = 1:3, j = 1:i, a[i,j])";

/* Bytes of a term, and bounds that are worked out, perhaps for nothing, that cost another one. */
enum { READ_AS_TERM = 100, TURNS_AS_TERM = 4 };

/* Whether a loop's name and its = begin at byte `at`. */
static bool starts_loop(const char *text, size_t at)
{
    struct lex_token name = lex_next(text, at), equal = lex_next(text, name.start + name.length);
    return name.kind == LEX_NAME && equal.kind == LEX_EQUAL && equal.length == 1;
}

bool index_is_sum(const char *text, struct lex_token tok)
{
    struct lex_token open = lex_next(text, tok.start + tok.length);
    return tok.kind == LEX_NAME && tok.length == sizeof word - 1 && memcmp(text + tok.start, word, tok.length) == 0 && open.kind == LEX_OPEN
           && starts_loop(text, open.start + 1);
}

bool index_has_sum(const char *text)
{
    for (const char *s = strstr(text, word); s; s = strstr(s + 1, word))
        if ((s == text || !index_joins(s[-1])) && index_is_sum(text, lex_next(text, (size_t)(s - text))))
            return true;
    return false;
}

/* Where the parts of a sum are in the text that it stands in. */
struct parts {
    size_t loop, loop_end, term, term_end;
};

/* The token is the sum's name; afterwards what closes the sum. */
static bool find_parts(struct index_reader *r, struct parts *p)
{
    size_t at = r->tok.start;
    int depth = 0, brackets = 0;
    index_advance(r);
    *p = (struct parts){ .loop = r->tok.start + 1 };
    for (index_advance(r); r->tok.kind != LEX_END; index_advance(r)) {
        if (r->tok.kind == LEX_CLOSE && depth == 0)
            break;
        depth += (r->tok.kind == LEX_OPEN) - (r->tok.kind == LEX_CLOSE);
        brackets += index_is(r, '[') - index_is(r, ']');
        if (r->tok.kind == LEX_COMMA && depth == 0 && brackets == 0 && !p->term && !starts_loop(r->text, r->tok.start + 1)) {
            p->loop_end = r->tok.start;
            p->term = lex_next(r->text, r->tok.start + 1).start;
        }
    }
    if (r->tok.kind == LEX_END)
        return index_fail(r, at, SGA_E_EXPR_SYNTAX, "a ) is missing behind a sum");
    p->term_end = r->tok.start;
    return (p->term && p->term < p->term_end) || index_fail(r, at, SGA_E_EXPR_SYNTAX, form);
}

static char *cut(struct sga_arena *mem, const char *text, size_t from, size_t to)
{
    char *part = sga_take(mem, to - from + 1);
    memcpy(part, text + from, to - from);
    part[to - from] = 0;
    return part;
}

/* An error in a part of the text that begins at byte `from` is one in the text. Columns count characters, as lex_place does. */
static bool moved(const struct index_reader *r, const char *part, size_t from)
{
    struct sga_error *err = r->err;
    size_t at = 0;
    for (int line = 1, column = 1; part[at] && (line < err->line || (line == err->line && column < err->column)); at++) {
        bool ends = part[at] == '\n';
        line += ends;
        column = ends ? 1 : column + (((unsigned char)part[at + 1] & 0xC0) != 0x80);
    }
    if (err->column)
        lex_place(r->text, from + at, &err->line, &err->column);
    return false;
}

/* No name of the loop has another meaning. */
static bool free_names(struct index_reader *r, const struct index_loop *l, size_t from)
{
    const struct index_scope *scope = r->scope;
    for (int i = 0; i < l->dims && scope->taken; i++) {
        char name[48] = "", what[160];
        memcpy(name, l->text + l->dim[i].name_at, l->dim[i].name_length);
        snprintf(what, sizeof what, "\"%s\" is a name of the system; take another for the sum", name);
        if (scope->taken(scope->of, name))
            return index_fail(r, from + l->dim[i].name_at, SGA_E_DUPLICATE_NAME, what);
    }
    return true;
}

/* So many more terms fit. */
static bool pay(struct index_reader *r, const struct sga_buf *out, size_t at, size_t count)
{
    const struct index_scope *scope = r->scope;
    char what[160];
    if (scope->terms && (*scope->terms += (long)count) > scope->most_terms)
        snprintf(what, sizeof what, "sums, ranges and loops make more than the %ld terms and elements that a request may have", scope->most_terms);
    else if (out->len > INDEX_WRITTEN)
        snprintf(what, sizeof what, "written out, the terms pass the limit of %d bytes", INDEX_WRITTEN);
    else
        return true;
    return index_fail(r, at, SGA_E_LIMIT_VARIABLES, what);
}

bool index_write_sum(struct index_reader *r, struct sga_buf *out, struct index_spot *spot)
{
    SGA_ARENA(mem);
    size_t start = r->tok.start;
    struct parts p;
    if (!find_parts(r, &p) || !pay(r, out, start, 0))
        return false;
    const char *loop = cut(&mem, r->text, p.loop, p.loop_end), *term = cut(&mem, r->text, p.term, p.term_end);
    struct index_scope own = *r->scope;
    struct index_loop l;
    if (!index_loop_read(&l, loop, &own, r->err))
        return moved(r, loop, p.loop);
    if (!free_names(r, &l, p.loop))
        return false;
    bool any = false;
    sga_buf_puts(out, "(");
    for (bool more = index_first(&l, r->err); more; more = index_next(&l, r->err), any = true) {
        sga_buf_puts(out, any ? " + (" : "(");
        struct index_spot inner = { .at = spot->at, .from = spot->from, .source = 0 };
        if (!pay(r, out, start, 1 + (p.term_end - p.term) / READ_AS_TERM))
            return false;
        bool past = spot->at >= out->len - spot->from;
        if (!index_write_from(term, &own, out, &inner, r->err))
            return moved(r, term, p.term);
        if (past)
            spot->source = p.term + inner.source;
        sga_buf_puts(out, ")");
    }
    if (r->err->code != SGA_E_OK)
        return moved(r, loop, p.loop);
    if (!pay(r, out, start, (size_t)l.turns / TURNS_AS_TERM))
        return false;
    sga_buf_puts(out, any ? ")" : "0)");
    assert(r->tok.kind == LEX_CLOSE);
    return true;
}
