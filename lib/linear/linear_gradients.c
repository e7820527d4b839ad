/* Gradients as tables. */
#include "linear_gradients.h"

#include <stdlib.h>

#include "derive.h"
#include "linearize.h"
#include "poly.h"
#include "system.h"

void linear_gradients_init(struct linear_gradients *g, struct sga_arena *mem, const struct linear_request *rq)
{
    const struct sys_system *sys = rq->sys;
    struct expr_store *st = sys->store;
    *g = (struct linear_gradients){ .st = st, .cols = sys->variables };
    g->column = sga_take(mem, ((size_t)st->symbols + 1) * sizeof *g->column);
    g->active = sga_zeros(mem, (size_t)st->symbols + 1, 1);
    for (int s = 0; s < st->symbols; s++)
        g->column[s] = -1;
    for (int j = 0; j < sys->variables; j++)
        g->column[sys->variable[j].symbol] = j;
    for (int k = 0; k < rq->inputs; k++)
        if (rq->input[k].signal >= 0)
            g->column[rq->input[k].signal] = g->cols++;
    for (int s = 0; s < st->symbols; s++)
        g->active[s] = g->column[s] >= 0;
}

/* Sums that cancel are to be the constants that they are: what is constant is exact, and what vanishes is nothing. */
static void simplify(struct expr_store *st, expr_id *e, int count)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, NULL);
    for (int i = 0; i < count; i++) {
        expr_id normal;
        if (e[i] && !expr_is_const(st, e[i]) && expr_op_of(st, e[i]) != EXPR_SYM && poly_normal(st, e[i], &limits, &normal))
            e[i] = normal;
        if (e[i] && expr_is_zero(st, e[i]))
            e[i] = EXPR_UNDEF;
    }
}

expr_id *linear_gradients_of(const struct linear_gradients *g, struct sga_arena *mem, const expr_id *e, int count)
{
    expr_id *out = sga_zeros(mem, (size_t)count * (size_t)g->cols + 1, sizeof *out);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone = { 0 };
    struct expr_term *term = NULL;
    size_t cap = 0;
    expr_cone_init(&cone);
    for (int i = 0; i < count; i++) {
        int terms = e[i] ? expr_gradient(g->st, &cone, e[i], g->active, &term, &cap) : 0;
        for (int k = 0; k < terms; k++)
            out[(size_t)i * (size_t)g->cols + (size_t)g->column[term[k].symbol]] = term[k].value;
    }
    free(term);
    simplify(g->st, out, count * g->cols);
    return out;
}

static bool is_rational(enum expr_op op)
{
    return op == EXPR_ADD || op == EXPR_SUB || op == EXPR_MUL || op == EXPR_DIV || op == EXPR_NEG || op == EXPR_POWI;
}

bool linear_gradients_rational(const struct linear_gradients *g, const expr_id *e, int count)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone = { 0 };
    SGA_ARENA(mem);
    unsigned char *depends = sga_zeros(&mem, (size_t)g->st->nodes + 1, 1);
    expr_cone_init(&cone);
    expr_cone_of(g->st, &cone, e, count);
    for (int k = 0; k < cone.count; k++) {
        expr_id node = cone.list[k];
        enum expr_op op = expr_op_of(g->st, node);
        int children = expr_children(g->st, node);
        if (op == EXPR_SYM)
            depends[node] = g->active[g->st->node[node].a];
        for (int c = 0; c < children; c++)
            depends[node] |= depends[expr_child(g->st, node, c)];
        if (depends[node] && op != EXPR_SYM && !is_rational(op))
            return false;
    }
    return true;
}

bool linear_gradients_affine(const struct linear_gradients *g, const expr_id *e, int count, const expr_id *table)
{
    for (int i = 0; i < count * g->cols; i++)
        if (table[i] && !expr_is_const(g->st, table[i]))
            return false;
    return linear_gradients_rational(g, e, count);
}

bool linear_gradients_constant(const struct linear_gradients *g, const expr_id *e, int count, const expr_id *table)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone = { 0 };
    expr_cone_init(&cone);
    for (int i = 0; i < count * g->cols; i++) {
        if (!table[i] || expr_is_const(g->st, table[i]))
            continue;
        expr_cone_of(g->st, &cone, table + i, 1);
        for (int k = 0; k < cone.count; k++)
            if (expr_op_of(g->st, cone.list[k]) == EXPR_SYM)
                return false;
    }
    return linear_gradients_rational(g, e, count);
}

bool linear_gradients_given(const struct linear_gradients *g, const struct linear_request *rq)
{
    const struct sys_system *sys = rq->sys;
    SGA_ARENA(mem);
    int count = 0;
    expr_id *e = sga_take(&mem, ((size_t)sys->rows + (size_t)sys->restrictions + 1) * sizeof *e);
    for (int i = 0; i < sys->rows; i++) {
        e[count++] = sys->row[i].alpha;
        for (int k = 0; k < sys->row[i].entries; k++)
            if (!expr_is_const(sys->store, sys->row[i].entry[k].value))
                return false;
    }
    for (int i = 0; i < sys->restrictions; i++)
        e[count++] = sys->restriction[i];
    return linear_gradients_constant(g, e, count, linear_gradients_of(g, &mem, e, count));
}

const char *linear_gradients_rate(const struct linear_request *rq, const expr_id *e, int count)
{
    const struct expr_store *st = rq->sys->store;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone = { 0 };
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, e, count);
    for (int k = 0; k < cone.count; k++) {
        if (expr_op_of(st, cone.list[k]) != EXPR_SYM)
            continue;
        const struct expr_symbol *s = st->symbol + st->node[cone.list[k]].a;
        for (int i = 0; i < rq->inputs; i++)
            if (rq->input[i].signal >= 0 && s->kind == EXPR_SIGNAL && s->order > 0 && s->table == st->symbol[rq->input[i].signal].table)
                return rq->input[i].name;
    }
    return NULL;
}
