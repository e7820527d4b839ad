/* Local partial derivatives and the reverse sweep. */
#include "derive.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "expr_rows.h"
#include "mem.h"
#include "op.h"

#define ST struct expr_store *st

static expr_id one_plus(ST, expr_id a) { return expr_add(st, expr_int(st, 1), a); }
static expr_id one_minus(ST, expr_id a) { return expr_sub(st, expr_int(st, 1), a); }
static expr_id inverse(ST, expr_id a) { return expr_div(st, expr_int(st, 1), a); }

/* The derivative at x of a function whose value there is u. */
static expr_id slope(ST, const struct expr_slope *s, expr_id x, expr_id u)
{
    expr_id r;
    if (s->of == EXPR_OF_NOTHING)
        return expr_int(st, 0);
    if (s->of == EXPR_OF_FUNCTION) {
        r = expr_fun(st, s->function, x);
    } else {
        r = s->of == EXPR_OF_VALUE ? u : x;
        r = s->power == 1 ? r : expr_powi(st, r, s->power);
        r = labs(s->factor) == 1 ? r : expr_mul(st, expr_int(st, labs(s->factor)), r);
        if (s->factor < 0)
            r = expr_sub(st, expr_int(st, s->shift), r);
        else if (s->shift)
            r = s->shift < 0 ? expr_sub(st, r, expr_int(st, -s->shift)) : expr_add(st, expr_int(st, s->shift), r);
        r = s->halves == -1 ? expr_fun(st, EXPR_SQRT, r) : r;
        r = s->halves < 0 ? inverse(st, r) : r;
    }
    return s->sign < 0 ? expr_neg(st, r) : r;
}

static expr_id unary_partial(ST, expr_id e)
{
    enum expr_op op = expr_op_of(st, e);
    expr_id a = st->node[e].a;
    switch (op) {
    case EXPR_NEG:   return expr_int(st, -1);
    case EXPR_POWI:  return expr_mul(st, expr_int(st, st->node[e].b), expr_powi(st, a, st->node[e].b - 1L));
    default:         return slope(st, expr_op_slope(op), a, e);
    }
}

expr_id expr_partial(ST, expr_id e, int k)
{
    expr_id a = st->node[e].a, b = st->node[e].b;
    switch (expr_op_of(st, e)) {
    case EXPR_ADD: return expr_int(st, 1);
    case EXPR_SUB: return expr_int(st, k ? -1 : 1);
    case EXPR_MUL: return k ? a : b;
    case EXPR_DIV: return k ? expr_neg(st, expr_div(st, e, b)) : inverse(st, b);
    case EXPR_POW:
        if (k == 0)
            return expr_mul(st, b, expr_pow(st, a, expr_sub(st, b, expr_int(st, 1))));
        return expr_mul(st, e, expr_fun(st, EXPR_LOG, a));
    case EXPR_ATAN2: {      /* atan2(a, b): angle of the point (b, a) */
        expr_id r2 = expr_add(st, expr_powi(st, a, 2), expr_powi(st, b, 2));
        return k ? expr_neg(st, expr_div(st, a, r2)) : expr_div(st, b, r2);
    }
    case EXPR_MIN:
    case EXPR_MAX: {
        expr_id s = expr_fun(st, EXPR_SIGN, expr_sub(st, a, b));
        bool plus = (expr_op_of(st, e) == EXPR_MAX) == (k == 0);
        return expr_mul(st, expr_rational(st, 1, 2), plus ? one_plus(st, s) : one_minus(st, s));
    }
    default: return unary_partial(st, e);
    }
}

/* The sweep's state: by position in the cone. */
struct sweep {
    struct expr_store *st;
    struct expr_cone *cone;
    unsigned char *dep;      /* depends on an active symbol */
    expr_id *bar;            /* adjoint so far, or EXPR_UNDEF */
};

static bool needed(const struct sweep *s, expr_id e)
{
    return s->dep[s->cone->place[e]];
}

static void accumulate(struct sweep *s, expr_id to, expr_id term)
{
    expr_id *bar = s->bar + s->cone->place[to];
    *bar = *bar ? expr_add(s->st, *bar, term) : term;
}

/* S y = r: the adjoint of r is S^-T y~ and that of S is -(r~ y^T). Components of one
 * solve need not stand beside each other, so the transposed solve is made for one
 * component at a time: the row e_b^T S^-1. */
static void solve_back(struct sweep *s, expr_id e, expr_id bar)
{
    struct expr_store *st = s->st;
    int index = st->node[e].a, row = st->node[e].b, m = st->solve[index].m;
    SGA_ENDS(expr_rows_clear) struct expr_rows t = expr_rows_transposed(&st->solve[index].matrix, m, m);
    SGA_FREED expr_id *r = sga_malloc((size_t)m * sizeof *r);
    for (int i = 0; i < m; i++)
        r[i] = expr_int(st, i == row);
    int transposed = expr_solve_add_rows(st, m, &t, r);
    for (int i = 0; i < m && expr_store_ok(st); i++) {
        expr_id rbar = expr_mul(st, bar, expr_solution(st, transposed, i));
        expr_id rhs = st->solve[index].rhs[i];
        if (needed(s, rhs))
            accumulate(s, rhs, rbar);
        for (int k = st->solve[index].matrix.start[i]; k < st->solve[index].matrix.start[i + 1]; k++) {
            expr_id entry = st->solve[index].matrix.entry[k];
            if (needed(s, entry))
                accumulate(s, entry, expr_neg(st, expr_mul(st, rbar, expr_solution(st, index, st->solve[index].matrix.column[k]))));
        }
    }
}

static void mark_dependence(struct sweep *s, const unsigned char *active)
{
    for (int i = 0; i < s->cone->count; i++) {
        expr_id e = s->cone->list[i];
        if (expr_op_of(s->st, e) == EXPR_SYM)
            s->dep[i] = active[s->st->node[e].a];
        for (int k = 0, n = expr_children(s->st, e); k < n && !s->dep[i]; k++)
            s->dep[i] = needed(s, expr_child(s->st, e, k));
    }
}

static void push_back(struct sweep *s, expr_id e, expr_id bar)
{
    struct expr_store *st = s->st;
    if (expr_op_of(st, e) == EXPR_SOLVE) {
        solve_back(s, e, bar);
    } else if (expr_op_of(st, e) == EXPR_DIV) {
        expr_id a = st->node[e].a, b = st->node[e].b, q = expr_div(st, bar, b);
        if (needed(s, a))
            accumulate(s, a, q);
        if (needed(s, b))
            accumulate(s, b, expr_neg(st, expr_mul(st, q, e)));
    } else {
        for (int k = 0, n = expr_children(st, e); k < n; k++)
            if (needed(s, expr_child(st, e, k)))
                accumulate(s, expr_child(st, e, k), expr_mul(st, bar, expr_partial(st, e, k)));
    }
}

static int by_symbol(const void *a, const void *b)
{
    return ((const struct expr_term *)a)->symbol - ((const struct expr_term *)b)->symbol;
}

int expr_gradient(ST, struct expr_cone *cone, expr_id f, const unsigned char *active,
                  struct expr_term **out, size_t *out_cap)
{
    int count = 0;
    if (!expr_store_ok(st))
        return 0;
    expr_cone_of(st, cone, &f, 1);
    expr_cone_index(cone);
    if (!expr_store_work(st, cone->count))
        return 0;
    struct sweep s = { .st = st, .cone = cone };
    s.dep = sga_calloc((size_t)cone->count, 1);
    s.bar = sga_calloc((size_t)cone->count, sizeof *s.bar);
    mark_dependence(&s, active);
    if (needed(&s, f))
        s.bar[cone->place[f]] = expr_int(st, 1);
    for (int i = cone->count - 1; i >= 0 && expr_store_ok(st); i--) {
        expr_id e = cone->list[i], bar = s.bar[i];
        if (!bar || expr_is_zero(st, bar))
            continue;
        if (expr_op_of(st, e) == EXPR_SYM) {
            SGA_RESERVE(*out, *out_cap, count + 1);
            (*out)[count++] = (struct expr_term){ st->node[e].a, bar };
        } else {
            push_back(&s, e, bar);
        }
    }
    free(s.dep);
    free(s.bar);
    if (count)
        qsort(*out, (size_t)count, sizeof **out, by_symbol);
    return count;
}

expr_id expr_diff(ST, expr_id e, int symbol)
{
    struct expr_cone cone;
    expr_cone_init(&cone);
    unsigned char *active = sga_calloc((size_t)st->symbols, 1);
    active[symbol] = 1;
    struct expr_term *term = NULL;
    size_t cap = 0;
    int n = expr_gradient(st, &cone, e, active, &term, &cap);
    expr_id d = n ? term[0].value : expr_int(st, 0);
    free(term);
    free(active);
    expr_cone_clear(&cone);
    return expr_store_ok(st) ? d : EXPR_UNDEF;
}
