/* A loop over the nodes, children first, that makes each node's text of its children's. A node that several use, and one whose text has
 * grown long, becomes a name; so no text is longer than a pattern and two long ones, and the whole stays linear. */
#include "lines.h"

#include "buf.h"
#include "dialect.h"
#include "error.h"
#include "number.h"
#include "operators.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

struct piece {
    const char *text;
    int binds;
};

struct writer {
    struct export_model *m;
    const struct export_dialect *dialect;
    struct sga_arena mem;
    struct expr_cone cone;
    struct piece *piece;          /* by place in the cone */
    int *uses;
    struct sga_buf *out;
};

static const struct piece *child(const struct writer *w, expr_id e, int k)
{
    const struct piece *p = &w->piece[w->cone.place[expr_child(&w->m->store, e, k)]];
    assert(p->text);                 /* children come first */
    return p;
}

static void put_argument(const struct writer *w, struct sga_buf *b, const struct piece *p, int least)
{
    bool brackets = p->binds < least;
    sga_buf_printf(b, "%s%s%s", brackets ? w->dialect->open : "", p->text, brackets ? w->dialect->close : "");
}

/* In TeX numbers side by side would be read as one. */
static const char *times(const struct piece *second)
{
    return second->binds >= BINDS_PRODUCT && *second->text >= '0' && *second->text <= '9' ? "\\cdot " : "\\, ";
}

static void put_pattern(const struct writer *w, expr_id e, struct export_pattern p, struct sga_buf *b)
{
    for (const char *c = p.text; *c; c++) {
        if (*c != '$') {
            sga_buf_put(b, c, 1);
            continue;
        }
        switch (*++c) {
        case 'a': put_argument(w, b, child(w, e, 0), p.binds); break;
        case 'A': put_argument(w, b, child(w, e, 0), p.binds + 1); break;
        case 'b': put_argument(w, b, child(w, e, 1), p.binds + 1); break;
        case 'c': put_argument(w, b, child(w, e, 1), p.binds); break;
        case 'x': put_argument(w, b, child(w, e, 0), 0); break;
        case 'y': put_argument(w, b, child(w, e, 1), 0); break;
        case '*': sga_buf_puts(b, times(child(w, e, 1))); break;
        case 'n': sga_buf_printf(b, "%d", w->m->store.node[e].b); break;
        }
    }
}

static bool put_number(const struct writer *w, const fmpq_t q, struct sga_buf *b, int *binds)
{
    if (export_is_print(w->m->language)) {
        export_print_number(q, w->m->language, b, binds);
        return true;
    }
    bool ok = export_number(q, b, binds);
    if (*binds == BINDS_SIGN)
        *binds = export_pattern(w->m->language, EXPR_NEG).binds;
    return ok;
}

/* What stands for a node; false: a number outside of the doubles, or a node that no text of an answer gives. */
static bool spell(struct writer *w, expr_id e, struct sga_buf *b, int *binds)
{
    const struct expr_store *st = &w->m->store;
    enum expr_op op = expr_op_of(st, e);
    struct export_pattern p = export_pattern(w->m->language, op);
    *binds = op == EXPR_SYM ? BINDS_ALL : p.binds;
    if (op == EXPR_CONST)
        return put_number(w, expr_const_value(st, e), b, binds);
    if (op == EXPR_SYM)
        sga_buf_puts(b, w->m->symbol[st->node[e].a]);
    else if (p.text)
        put_pattern(w, e, p, b);
    return op == EXPR_SYM || p.text;
}

static const char *keep(struct writer *w, const char *text)
{
    size_t n = strlen(text) + 1;
    return memcpy(sga_take(&w->mem, n), text, n);
}

static void put_name(struct writer *w, struct piece *p, const char *text)
{
    char name[80];
    snprintf(name, sizeof name, w->dialect->part, ++w->m->parts);
    sga_buf_printf(w->out, w->dialect->named, name, text);
    *p = (struct piece){ keep(w, name), BINDS_ALL };
}

static bool put_node(struct writer *w, int i)
{
    const struct expr_store *st = &w->m->store;
    expr_id e = w->cone.list[i];
    struct sga_buf b = { 0 };
    assert(w->uses[i] > 0);
    bool leaf = expr_children(st, e) == 0, ok = spell(w, e, &b, &w->piece[i].binds);
    if (ok && !leaf && b.len > (w->uses[i] > 1 ? w->dialect->shared : w->dialect->most))
        put_name(w, &w->piece[i], b.data);
    else if (ok)
        w->piece[i].text = keep(w, b.data);
    sga_buf_free(&b);
    return ok;
}

static void writer_init(struct writer *w, const expr_id *root, int roots)
{
    const struct expr_store *st = &w->m->store;
    expr_cone_init(&w->cone);
    expr_cone_of(st, &w->cone, root, roots);
    expr_cone_index(&w->cone);
    w->piece = sga_zeros(&w->mem, (size_t)w->cone.count, sizeof *w->piece);
    w->uses = sga_zeros(&w->mem, (size_t)w->cone.count, sizeof *w->uses);
    for (int i = 0; i < w->cone.count; i++)
        for (int k = 0; k < expr_children(st, w->cone.list[i]); k++)
            w->uses[w->cone.place[expr_child(st, w->cone.list[i], k)]]++;
    for (int i = 0; i < roots; i++)
        w->uses[w->cone.place[root[i]]]++;
}

static bool put_nodes(struct writer *w, struct sga_error *err)
{
    for (int i = 0; i < w->cone.count; i++)
        if (!put_node(w, i))
            return sga_fail(err, SGA_E_NO_CODE, "A number of the answer lies outside of the doubles, or a part of it has no value.");
    return true;
}

static void writer_end(struct writer *w)
{
    expr_cone_clear(&w->cone);
    sga_arena_end(&w->mem);
}

static void put_place(struct writer *w, const struct export_place *p, const char *value)
{
    const struct export_dialect *d = w->dialect;
    char left[80];
    int columns = d->grid ? 0 : w->m->source->variables;      /* without a grid by rows */
    assert(p->row >= 0 && p->column < w->m->source->variables);
    if (!d->list)
        sga_buf_printf(w->out, d->assigned, p->array, value);
    else if (p->column >= 0 && d->grid) {
        snprintf(left, sizeof left, d->grid, p->array, p->row + d->first, p->column + d->first);
        sga_buf_printf(w->out, d->assigned, left, value);
    } else {
        snprintf(left, sizeof left, d->list, p->array, (p->column < 0 ? p->row : p->row * columns + p->column) + d->first);
        sga_buf_printf(w->out, d->assigned, left, value);
    }
}

/* The pieces of the places' values, in w. */
static bool write_pieces(struct writer *w, const struct export_place *place, int places, struct sga_error *err)
{
    expr_id *root = sga_take(&w->mem, (size_t)places * sizeof *root);
    for (int i = 0; i < places; i++)
        root[i] = place[i].value;
    w->m->parts = 0;
    writer_init(w, root, places);
    return put_nodes(w, err);
}

bool export_lines(struct export_model *m, const struct export_place *place, int places, struct sga_buf *out, struct sga_error *err)
{
    struct writer w = { .m = m, .dialect = export_dialect(m->language), .out = out };
    bool ok = write_pieces(&w, place, places, err);
    for (int i = 0; i < places && ok; i++)
        put_place(&w, &place[i], w.piece[w.cone.place[place[i].value]].text);
    writer_end(&w);
    return ok;
}

bool export_value(struct export_model *m, expr_id value, struct sga_buf *out, struct sga_error *err)
{
    struct sga_buf parts = { 0 };
    struct writer w = { .m = m, .dialect = export_dialect(m->language), .out = &parts };
    struct export_place place = { "value", 0, -1, value };
    bool ok = write_pieces(&w, &place, 1, err);
    if (ok && m->parts == 0)
        sga_buf_puts(out, w.piece[w.cone.place[value]].text);
    else if (ok)
        ok = sga_fail(err, SGA_E_NO_CODE, "The value of a parameter is too long for an export.");
    writer_end(&w);
    sga_buf_free(&parts);
    return ok;
}
