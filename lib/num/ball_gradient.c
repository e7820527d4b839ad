/* Reverse sweep in balls. */
#include "ball.h"

#include <arb.h>

#include "arena.h"
#include "mem.h"
#include "op.h"
#include "watch.h"

static void of_function(arb_t t, enum expr_op f, const arb_t x, slong p)
{
    switch (f) {
#define X(sym, name) case EXPR_##sym: arb_##name(t, x, p); break;
    EXPR_ELEMENTARY_TABLE(X)
#undef X
    default: arb_sgn(t, x); break;
    }
}

static void slope(arb_t t, const struct expr_slope *s, const arb_t x, const arb_t u, slong p)
{
    if (s->of == EXPR_OF_NOTHING) {
        arb_zero(t);
        return;
    }
    if (s->of == EXPR_OF_FUNCTION) {
        of_function(t, s->function, x, p);
    } else {
        arb_srcptr w = s->of == EXPR_OF_VALUE ? u : x;
        if (s->power == 1)
            arb_set(t, w);
        else
            arb_mul(t, w, w, p);
        if (s->factor != 1)
            arb_mul_si(t, t, s->factor, p);
        if (s->shift)
            arb_add_si(t, t, s->shift, p);
        if (s->halves == -1)
            arb_rsqrt(t, t, p);
        else if (s->halves < 0)
            arb_inv(t, t, p);
    }
    if (s->sign < 0)
        arb_neg(t, t);
}

/* t = value of d e / d (its only child x); u = value of e */
static void unary_partial(arb_t t, enum expr_op op, const arb_t x, const arb_t u, slong exponent, slong p)
{
    switch (op) {
    case EXPR_NEG: arb_set_si(t, -1); break;
    case EXPR_POWI:
        arb_set_si(t, exponent - 1);
        if (exponent >= 1) {
            arb_pow_ui(t, x, (ulong)(exponent - 1), p);
        } else {
            arb_pow_ui(t, x, (ulong)(1 - exponent), p);
            arb_inv(t, t, p);
        }
        arb_mul_si(t, t, exponent, p);
        break;
    default: slope(t, expr_op_slope(op), x, u, p); break;
    }
}

static void binary_partial(arb_t t, enum expr_op op, int k, arb_srcptr x, arb_srcptr y, arb_srcptr u, slong p)
{
    arb_t w;
    arb_init(w);
    switch (op) {
    case EXPR_POW:
        if (k == 0) {
            arb_sub_ui(w, y, 1, p);
            arb_pow(t, x, w, p);
            arb_mul(t, t, y, p);
        } else {
            arb_log(t, x, p);
            arb_mul(t, t, u, p);
        }
        break;
    case EXPR_ATAN2:
        arb_mul(w, x, x, p);
        arb_addmul(w, y, y, p);
        arb_div(t, k ? x : y, w, p);
        if (k)
            arb_neg(t, t);
        break;
    default:    /* MIN, MAX */
        arb_sub(w, x, y, p);
        arb_sgn(w, w);
        if ((op == EXPR_MAX) != (k == 0))
            arb_neg(w, w);
        arb_add_ui(t, w, 1, p);
        arb_mul_2exp_si(t, t, -1);
        break;
    }
    arb_clear(w);
}

/* y = S^-1 r: r~ = S^-T e_row * bar, S~ = -r~ y^T */
/* What the components of solves have gathered so far. All of them come after the solve's inputs, so that it is handed on once for
 * all, at the first of them in the list, which is the last one of the sweep. */
struct gathered {
    struct sga_arena mem;
    arb_ptr *sum;        /* by solve: m balls, or NULL; */
    int *first;          /* the place of its first component in the list */
};

static void gathered_init(struct gathered *g, const struct expr_store *st, const expr_id *list, int count)
{
    g->sum = sga_zeros(&g->mem, (size_t)st->solves + 1, sizeof *g->sum);
    g->first = sga_zeros(&g->mem, (size_t)st->solves + 1, sizeof *g->first);
    for (int i = count - 1; i >= 0; i--)
        if (st->node[list[i]].op == EXPR_SOLVE)
            g->first[st->node[list[i]].a] = i;
}

static void gathered_end(struct gathered *g, const struct expr_store *st)
{
    for (int i = 0; g->sum && i < st->solves; i++)
        if (g->sum[i])
            _arb_vec_clear(g->sum[i], st->solve[i].m);
    sga_arena_end(&g->mem);
}

/* The component n->b has the adjoint bar: A^T y = bar e_b. */
static void gather(struct num_ball *b, struct gathered *g, const struct expr_node *n, arb_srcptr bar)
{
    int m = b->st->solve[n->a].m;
    arb_srcptr row = num_ball_inverse(b, n->a) + (slong)n->b * m;
    if (!g->sum[n->a])
        g->sum[n->a] = _arb_vec_init(m);
    for (int i = 0; i < m; i++)
        arb_addmul(g->sum[n->a] + i, bar, row + i, b->prec);
}

/* The adjoint of a node of the list. */
static arb_ptr bar_of(const struct num_ball_room *room, expr_id e)
{
    return room->bar + room->place[e];
}

/* dr = y and dA = - y x^T, for entries that are no numbers. */
static void hand_on(struct num_ball *b, const struct gathered *g, int solve, const struct num_ball_room *room)
{
    const struct expr_solve *s = b->st->solve + solve;
    const struct expr_node *node = b->st->node;
    for (int i = 0; i < s->m; i++) {
        arb_srcptr y = g->sum[solve] + i;
        if (node[s->rhs[i]].op != EXPR_CONST)
            arb_add(bar_of(room, s->rhs[i]), bar_of(room, s->rhs[i]), y, b->prec);
        for (int k = s->matrix.start[i]; k < s->matrix.start[i + 1]; k++) {
            expr_id e = s->matrix.entry[k];
            if (node[e].op != EXPR_CONST)
                arb_submul(bar_of(room, e), y, b->solution[solve] + s->matrix.column[k], b->prec);
        }
    }
}

static void back_two(struct num_ball *b, expr_id e, arb_srcptr bar, const struct num_ball_room *room, arb_ptr t)
{
    const struct expr_node *n = b->st->node + e;
    arb_ptr v = b->value, da = bar_of(room, n->a), db = bar_of(room, n->b);
    slong p = b->prec;
    switch ((enum expr_op)n->op) {
    case EXPR_ADD: arb_add(da, da, bar, p); arb_add(db, db, bar, p); break;
    case EXPR_SUB: arb_add(da, da, bar, p); arb_sub(db, db, bar, p); break;
    case EXPR_MUL: arb_addmul(da, bar, v + n->b, p); arb_addmul(db, bar, v + n->a, p); break;
    case EXPR_DIV:
        arb_div(t, bar, v + n->b, p);
        arb_add(da, da, t, p);
        arb_submul(db, t, v + e, p);
        break;
    default:
        binary_partial(t, (enum expr_op)n->op, 0, v + n->a, v + n->b, v + e, p);
        arb_addmul(da, bar, t, p);
        if (n->op == EXPR_POW && b->st->node[n->b].op == EXPR_CONST)
            break;
        binary_partial(t, (enum expr_op)n->op, 1, v + n->a, v + n->b, v + e, p);
        arb_addmul(db, bar, t, p);
        break;
    }
}

static void back(struct num_ball *b, expr_id e, arb_srcptr bar, const struct num_ball_room *room, arb_ptr t)
{
    const struct expr_node *n = b->st->node + e;
    int parts = expr_op_args((enum expr_op)n->op);
    if (parts == 2) {
        back_two(b, e, bar, room, t);
    } else if (parts == 1) {
        unary_partial(t, (enum expr_op)n->op, b->value + n->a, b->value + e, n->b, b->prec);
        arb_addmul(bar_of(room, n->a), bar, t, b->prec);
    }
}

void num_ball_room_clear(struct num_ball_room *room)
{
    free(room->place);
    if (room->bar)
        _arb_vec_clear(room->bar, room->bars);
    *room = (struct num_ball_room){ 0 };
}

static void make_room(struct num_ball_room *room, const struct expr_store *st, const expr_id *list, int count)
{
    SGA_RESERVE(room->place, room->place_cap, st->nodes);
    if (count > room->bars) {
        int bars = 2 * count;
        if (room->bar)
            _arb_vec_clear(room->bar, room->bars);
        room->bar = _arb_vec_init(bars);
        room->bars = bars;
    }
    for (int i = 0; i < count; i++)
        room->place[list[i]] = i;
}

void num_ball_gradient(struct num_ball *b, expr_id root, const expr_id *list, int count,
                       const int *col_of_symbol, arb_ptr grad, struct num_ball_room *room)
{
    arb_t t;
    struct gathered g = { .sum = NULL };
    arb_init(t);
    sga_watch_count(SGA_COUNT_BALLS, count);
    make_room(room, b->st, list, count);
    arb_one(bar_of(room, root));
    for (int i = count - 1; i >= 0; i--) {
        expr_id e = list[i];
        const struct expr_node *n = b->st->node + e;
        arb_ptr bar = room->bar + i;
        if (n->op == EXPR_SOLVE) {
            if (!g.sum)
                gathered_init(&g, b->st, list, i + 1);
            if (!arb_is_zero(bar))
                gather(b, &g, n, bar);
            if (g.first[n->a] == i && g.sum[n->a])
                hand_on(b, &g, n->a, room);
        } else if (!arb_is_zero(bar)) {
            if (n->op != EXPR_SYM)
                back(b, e, bar, room, t);
            else if (col_of_symbol[n->a] >= 0)
                arb_set(grad + col_of_symbol[n->a], bar);
        }
        arb_zero(bar);
    }
    gathered_end(&g, b->st);
    arb_clear(t);
}
