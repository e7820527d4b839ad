/* A loop over the nodes, children first, that makes each node's text of its children's. A node that several use, and one whose text has
 * grown long, becomes a name; so no text is longer than a pattern and two long ones, and the whole stays linear. */
#include "lines.h"

#include "number.h"
#include "operators.h"

#include <stdio.h>
#include <string.h>

enum { LONG_LINE = 90 };          /* characters after which a part gets a name, for readers' sake */

struct piece {
    const char *text;
    int binds;
};

struct writer {
    struct export_model *m;
    enum export_language language;
    struct sga_arena mem;
    struct expr_cone cone;
    struct piece *piece;          /* by place in the cone */
    int *uses;
    int names;
    struct sga_buf *out;
};

static const struct piece *child(const struct writer *w, expr_id e, int k)
{
    return &w->piece[w->cone.place[expr_child(&w->m->store, e, k)]];
}

static void put_argument(struct sga_buf *b, const struct piece *p, int least)
{
    bool brackets = p->binds < least;
    sga_buf_printf(b, "%s%s%s", brackets ? "(" : "", p->text, brackets ? ")" : "");
}

static void put_pattern(const struct writer *w, expr_id e, struct export_pattern p, struct sga_buf *b)
{
    for (const char *c = p.text; *c; c++) {
        if (*c != '$') {
            sga_buf_put(b, c, 1);
            continue;
        }
        switch (*++c) {
        case 'a': put_argument(b, child(w, e, 0), p.binds); break;
        case 'A': put_argument(b, child(w, e, 0), p.binds + 1); break;
        case 'b': put_argument(b, child(w, e, 1), p.binds + 1); break;
        case 'x': put_argument(b, child(w, e, 0), 0); break;
        case 'y': put_argument(b, child(w, e, 1), 0); break;
        case 'n': sga_buf_printf(b, "%d", w->m->store.node[e].b); break;
        }
    }
}

/* What stands for a node; false: a number outside of the doubles, or a node that no text of an answer gives. */
static bool spell(struct writer *w, expr_id e, struct sga_buf *b, int *binds)
{
    const struct expr_store *st = &w->m->store;
    enum expr_op op = expr_op_of(st, e);
    struct export_pattern p = export_pattern(w->language, op);
    *binds = op == EXPR_SYM ? BINDS_ALL : p.binds;
    if (op == EXPR_CONST)
        return export_number(expr_const_value(st, e), b, binds);
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
    char name[24];
    snprintf(name, sizeof name, "w%d", ++w->names);
    if (w->language == EXPORT_C)
        sga_buf_printf(w->out, "    const double %s = %s;\n", name, text);
    else
        sga_buf_printf(w->out, "    %s = %s\n", name, text);
    *p = (struct piece){ keep(w, name), BINDS_ALL };
}

static bool put_node(struct writer *w, int i)
{
    const struct expr_store *st = &w->m->store;
    expr_id e = w->cone.list[i];
    struct sga_buf b = { 0 };
    bool leaf = expr_children(st, e) == 0, ok = spell(w, e, &b, &w->piece[i].binds);
    if (ok && !leaf && (w->uses[i] > 1 || b.len > LONG_LINE))
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

bool export_lines(struct export_model *m, enum export_language l, const struct export_place *place, int places, struct sga_buf *out, struct sga_error *err)
{
    struct writer w = { .m = m, .language = l, .out = out };
    expr_id *root = sga_take(&w.mem, (size_t)places * sizeof *root);
    for (int i = 0; i < places; i++)
        root[i] = place[i].value;
    writer_init(&w, root, places);
    bool ok = put_nodes(&w, err);
    for (int i = 0; i < places && ok; i++)
        sga_buf_printf(out, "    %s[%d] = %s%s\n", place[i].array, place[i].index, w.piece[w.cone.place[root[i]]].text, l == EXPORT_C ? ";" : "");
    writer_end(&w);
    return ok;
}

bool export_value(struct export_model *m, enum export_language l, expr_id value, struct sga_buf *out, struct sga_error *err)
{
    struct sga_buf b = { 0 };
    struct export_place place = { "value", 0, value };
    bool ok = export_lines(m, l, &place, 1, &b, err);
    const char *only = ok ? strstr(b.data, " = ") : NULL;
    if (ok && !strncmp(b.data, "    value", 9))
        sga_buf_put(out, only + 3, strcspn(only + 3, ";\n"));
    else if (ok)
        ok = sga_fail(err, SGA_E_NO_CODE, "The value of a parameter is too long for an export.");
    sga_buf_free(&b);
    return ok;
}
