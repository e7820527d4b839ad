/* Taylor coefficients along a flow: recurrences on an explicit stack of (node, order). */
#include "derive.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "signal.h"

void expr_flow_init(struct expr_flow *f, struct expr_store *st)
{
    *f = (struct expr_flow){ .st = st };
}

void expr_flow_clear(struct expr_flow *f)
{
    for (size_t i = 0; i < f->jet_cap && f->jet; i++)
        free(f->jet[i]);
    free(f->jet);
    free(f->jets);
    free(f->velocity);
    free(f->tainted);
    free(f->fleeting);
    free(f->lift);
    *f = (struct expr_flow){ 0 };
}

static void cover_symbols(struct expr_flow *f)
{
    SGA_RESERVE(f->velocity, f->velocity_cap, f->st->symbols);
    for (; f->velocities < f->st->symbols; f->velocities++)
        f->velocity[f->velocities] = EXPR_UNDEF;
}

/* Room for every node and symbol of the store; new ones are empty. */
static void cover(struct expr_flow *f)
{
    struct expr_store *st = f->st;
    size_t old = f->jet_cap;
    SGA_RESERVE(f->jet, f->jet_cap, st->nodes);
    if (f->jet_cap > old) {
        memset(f->jet + old, 0, (f->jet_cap - old) * sizeof *f->jet);
        f->jets = sga_realloc(f->jets, f->jet_cap * sizeof *f->jets);
        memset(f->jets + old, 0, (f->jet_cap - old) * sizeof *f->jets);
    }
    cover_symbols(f);
    SGA_RESERVE(f->tainted, f->tainted_cap, st->nodes);
    for (; f->known < st->nodes; f->known++) {
        expr_id e = f->known;
        bool bad = false;
        if (expr_op_of(st, e) == EXPR_SYM) {
            int s = st->node[e].a;
            bad = st->symbol[s].kind == EXPR_VARIABLE && !f->velocity[s];
        }
        for (int k = 0, n = expr_children(st, e); k < n && !bad; k++)
            bad = f->tainted[expr_child(st, e, k)];
        f->tainted[e] = bad;
    }
}

void expr_flow_determine(struct expr_flow *f, int symbol, expr_id X)
{
    cover_symbols(f);
    f->velocity[symbol] = X;
    for (int i = 0; i < f->fleetings; i++)
        f->jets[f->fleeting[i]] = 0;
    f->fleetings = 0;
    f->lifts = 0;
    f->known = 0;     /* taint is worked out anew at the next question */
}

bool expr_flow_tainted(struct expr_flow *f, expr_id e)
{
    cover(f);
    return f->tainted[e];
}

static expr_id get(const struct expr_flow *f, expr_id e, int k)
{
    return k == 0 ? e : f->jet[e][k - 1];
}

static void put(struct expr_flow *f, expr_id e, expr_id value)
{
    cover(f);
    int k = f->jets[e];
    if (k == 0 && f->tainted[e]) {
        SGA_RESERVE(f->fleeting, f->fleeting_cap, f->fleetings + 1);
        f->fleeting[f->fleetings++] = e;
    }
    if ((k & (k - 1)) == 0)
        f->jet[e] = sga_realloc(f->jet[e], (size_t)(k ? 2 * k : 1) * sizeof **f->jet);
    f->jet[e][k] = value;
    f->jets[e] = k + 1;
}

/* sum over i = from..m of a_i b_(m-i) */
static expr_id convolve(struct expr_flow *f, expr_id a, expr_id b, int from, int m)
{
    struct expr_store *st = f->st;
    expr_id sum = expr_int(st, 0);
    for (int i = from; i <= m; i++)
        sum = expr_add(st, sum, expr_mul(st, get(f, a, i), get(f, b, m - i)));
    return sum;
}

/* u' = G a': m u_m = sum over i = 1..m of i a_i G_(m-i) */
static expr_id chain(struct expr_flow *f, expr_id a, expr_id G, int m)
{
    struct expr_store *st = f->st;
    expr_id sum = expr_int(st, 0);
    for (int i = 1; i <= m; i++)
        sum = expr_add(st, sum, expr_mul(st, expr_rational(st, i, m), expr_mul(st, get(f, a, i), get(f, G, m - i))));
    return sum;
}

/* The solve whose solution is the m-th coefficient: S_0 u_m = r_m - sum S_i u_(m-i). */
static int lift_solve(struct expr_flow *f, int solve, int m)
{
    if (m == 0)
        return solve;
    for (int i = f->lifts - 1; i >= 0; i--)
        if (f->lift[i].solve == solve && f->lift[i].order == m)
            return f->lift[i].result;
    struct expr_store *st = f->st;
    int n = st->solve[solve].m;
    SGA_FREED expr_id *r = sga_malloc((size_t)n * sizeof *r);
    for (int i = 0; i < n; i++) {
        r[i] = get(f, st->solve[solve].rhs[i], m);
        for (int k = 1; k <= m; k++) {
            int lower = lift_solve(f, solve, m - k);    /* known already: one look-up */
            for (int q = st->solve[solve].matrix.start[i]; q < st->solve[solve].matrix.start[i + 1]; q++)
                r[i] = expr_sub(st, r[i], expr_mul(st, get(f, st->solve[solve].matrix.entry[q], k),
                                                   expr_solution(st, lower, st->solve[solve].matrix.column[q])));
        }
    }
    int result = expr_solve_add_rows(st, n, &st->solve[solve].matrix, r);
    SGA_RESERVE(f->lift, f->lift_cap, f->lifts + 1);
    f->lift[f->lifts].solve = solve;
    f->lift[f->lifts].order = m;
    f->lift[f->lifts++].result = result;
    return result;
}

/* What the m-th coefficient of e needs besides those of lower order of e itself: the
 * nodes whose coefficients up to `order` must be known. */
struct need {
    expr_id node[3];
    int order[3];
    int count;
};

static void want(struct need *n, expr_id e, int order)
{
    n->node[n->count] = e;
    n->order[n->count++] = order;
}

static struct need needs(struct expr_flow *f, expr_id e, int m)
{
    struct expr_store *st = f->st;
    struct need n = { .count = 0 };
    enum expr_op op = expr_op_of(st, e);
    expr_id a = st->node[e].a, b = st->node[e].b;
    switch (op) {
    case EXPR_UNDEF_OP: case EXPR_CONST: case EXPR_PI: case EXPR_SOLVE:
        break;
    case EXPR_SYM:
        if (st->symbol[a].kind == EXPR_VARIABLE && f->velocity[a])
            want(&n, f->velocity[a], m - 1);
        break;
    case EXPR_POWI:
        if (b < 0) {
            want(&n, expr_powi(st, a, -(long)b), m);
        } else {
            want(&n, expr_powi(st, a, b / 2), m);
            want(&n, expr_powi(st, a, b - b / 2), m);
        }
        break;
    case EXPR_ADD: case EXPR_SUB: case EXPR_MUL: case EXPR_DIV:
        want(&n, b, m);
        want(&n, a, m);
        break;
    default:
        want(&n, a, m);
        if (op == EXPR_POW || op == EXPR_ATAN2 || op == EXPR_MIN || op == EXPR_MAX) {
            want(&n, b, m);
            want(&n, expr_partial(st, e, 1), m - 1);
        }
        break;
    }
    return n;
}

static expr_id coefficient(struct expr_flow *f, expr_id e, int m)
{
    struct expr_store *st = f->st;
    enum expr_op op = expr_op_of(st, e);
    expr_id a = st->node[e].a, b = st->node[e].b;
    switch (op) {
    case EXPR_UNDEF_OP: case EXPR_CONST: case EXPR_PI:
        return expr_int(st, 0);
    case EXPR_SYM:
        if (st->symbol[a].kind == EXPR_TIME)
            return expr_int(st, m == 1);
        if (st->symbol[a].kind == EXPR_SIGNAL)
            return expr_signal_coefficient(st, a, m);
        if (st->symbol[a].kind != EXPR_VARIABLE || !f->velocity[a])
            return expr_int(st, 0);
        return expr_mul(st, expr_rational(st, 1, m), get(f, f->velocity[a], m - 1));
    case EXPR_ADD: return expr_add(st, get(f, a, m), get(f, b, m));
    case EXPR_SUB: return expr_sub(st, get(f, a, m), get(f, b, m));
    case EXPR_NEG: return expr_neg(st, get(f, a, m));
    case EXPR_MUL: return convolve(f, a, b, 0, m);
    case EXPR_DIV:      /* a = u b: u_m b_0 = a_m - sum of b_i u_(m-i) */
        return expr_div(st, expr_sub(st, get(f, a, m), convolve(f, b, e, 1, m)), b);
    case EXPR_POWI:
        if (b < 0) {
            expr_id q = expr_powi(st, a, -(long)b);
            return expr_neg(st, expr_div(st, convolve(f, q, e, 1, m), q));
        }
        return convolve(f, expr_powi(st, a, b / 2), expr_powi(st, a, b - b / 2), 0, m);
    case EXPR_SOLVE:
        return expr_solution(st, lift_solve(f, a, m), b);
    case EXPR_POW: case EXPR_ATAN2: case EXPR_MIN: case EXPR_MAX:
        return expr_add(st, chain(f, a, expr_partial(st, e, 0), m), chain(f, b, expr_partial(st, e, 1), m));
    default:
        return chain(f, a, expr_partial(st, e, 0), m);
    }
}

struct task {
    expr_id node;
    int order;
};

struct tasks {
    struct task *item;
    size_t cap;
    int count;
};

static bool known(struct expr_flow *f, expr_id e, int order)
{
    cover(f);
    return f->jets[e] >= order;
}

static bool require(struct expr_flow *f, struct tasks *t, expr_id e, int order)
{
    if (order <= 0 || known(f, e, order))
        return true;
    SGA_RESERVE(t->item, t->cap, t->count + 1);
    t->item[t->count++] = (struct task){ e, order };
    return false;
}

/* Everything that the m-th coefficient needs is known, or was put on the stack. */
static bool ready(struct expr_flow *f, struct tasks *t, expr_id e, int m)
{
    struct expr_store *st = f->st;
    if (!require(f, t, e, m - 1))
        return false;
    bool ok = true;
    if (expr_op_of(st, e) == EXPR_SOLVE) {
        for (int k = 0, n = expr_children(st, e); k < n; k++)
            ok &= require(f, t, expr_child(st, e, k), m);
        /* lower coefficients of the sister components: made by the same lifted solves */
        for (int k = 1; ok && k < m; k++)
            lift_solve(f, st->node[e].a, k);
        return ok;
    }
    struct need n = needs(f, e, m);
    for (int i = 0; i < n.count; i++)
        ok &= require(f, t, n.node[i], n.order[i]);
    int args = expr_op_args(expr_op_of(st, e));
    if (ok && args >= 1 && expr_op_of(st, e) >= EXPR_POW && expr_op_of(st, e) != EXPR_SOLVE)
        ok = require(f, t, expr_partial(st, e, 0), m - 1);
    return ok;
}

expr_id expr_flow_coefficient(struct expr_flow *f, expr_id e, int k)
{
    struct tasks t = { 0 };
    require(f, &t, e, k);
    while (t.count && expr_store_ok(f->st)) {
        struct task top = t.item[t.count - 1];
        if (known(f, top.node, top.order)) {
            t.count--;
        } else if (ready(f, &t, top.node, top.order)) {
            expr_id c = coefficient(f, top.node, top.order);
            put(f, top.node, c);
            t.count--;
        }
    }
    free(t.item);
    return expr_store_ok(f->st) ? get(f, e, k) : EXPR_UNDEF;
}
