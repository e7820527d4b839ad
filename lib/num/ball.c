/* Forward evaluation in balls. */
#include "ball.h"
#include "ball_solve.h"

#include <arb_mat.h>
#include <assert.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "op.h"
#include "sort.h"
#include "watch.h"

enum { BATCH = 1 << 12, BLOCK = 64 };      /* nodes between looks at the clock; of values */

void num_ball_init(struct num_ball *b, const struct expr_store *st, slong prec)
{
    *b = (struct num_ball){ .st = st, .prec = prec, .round = 1 };
}

static void drop_solutions(struct num_ball *b)
{
    for (int i = 0; i < b->solutions; i++) {
        int m = b->st->solve[i].m;
        if (b->solution[i])
            _arb_vec_clear(b->solution[i], m);
        if (b->inverse[i])
            _arb_vec_clear(b->inverse[i], (slong)m * m);
    }
    b->solutions = 0;
}

/* What was asked for is forgotten: rounds are told apart by a byte, which is 0 where there was none yet. */
static void next_round(struct num_ball *b)
{
    if (++b->round)
        return;
    for (size_t k = 0; k < b->used_cap; k++)
        if (b->used[k])
            memset(b->asked + k * BLOCK, 0, BLOCK);
    b->round = 1;
}

void num_ball_forget(struct num_ball *b)
{
    b->nodes = 0;
    next_round(b);
    drop_solutions(b);
}

void num_ball_release(struct num_ball *b)
{
    num_ball_forget(b);
    for (size_t k = 0; k < b->used_cap; k++)
        for (size_t i = 0; i < BLOCK && b->used[k]; i++)
            arb_clear(b->value + k * BLOCK + i);
    sga_zero_pages_free(b->value, b->used_cap * BLOCK * sizeof *b->value);
    sga_zero_pages_free(b->used, b->used_cap);
    sga_zero_pages_free(b->asked, b->used_cap * BLOCK);
    b->value = NULL;
    b->used = b->asked = NULL;
    b->used_cap = 0;
}

void num_ball_clear(struct num_ball *b)
{
    num_ball_release(b);
    for (size_t i = 0; i < b->symbol_cap; i++)
        arb_clear(b->symbol + i);
    free(b->symbol);
    free(b->solution);
    free(b->inverse);
    free(b->wanted);
    *b = (struct num_ball){ 0 };
}

static void grow(arb_ptr *v, size_t *cap, int need)
{
    size_t old = *cap;
    SGA_RESERVE(*v, *cap, need);
    for (size_t i = old; i < *cap; i++)
        arb_init(*v + i);
}

/* Room for all nodes, of which a question about a few touches theirs: all zeros are a ball that is set up, and memory that is asked for
 * with zeros costs nothing before it is used. */
static void make_room(struct num_ball *b)
{
    size_t blocks = ((size_t)b->st->nodes + BLOCK - 1) / BLOCK;
    if (blocks <= b->used_cap)
        return;
    blocks = blocks > 2 * b->used_cap ? blocks : 2 * b->used_cap;
    b->value = sga_zero_pages_grow(b->value, b->used_cap * BLOCK * sizeof *b->value, blocks * BLOCK * sizeof *b->value);
    b->used = sga_zero_pages_grow(b->used, b->used_cap, blocks);
    b->asked = sga_zero_pages_grow(b->asked, b->used_cap * BLOCK, blocks * BLOCK);
    b->used_cap = blocks;
}

static void cover(struct num_ball *b)
{
    make_room(b);
    grow(&b->symbol, &b->symbol_cap, b->st->symbols);
    SGA_RESERVE(b->solution, b->solution_cap, b->st->solves);
    SGA_RESERVE(b->inverse, b->inverse_cap, b->st->solves);
    for (; b->solutions < b->st->solves; b->solutions++)
        b->solution[b->solutions] = b->inverse[b->solutions] = NULL;
}

void num_ball_set(struct num_ball *b, int symbol, const arb_t v)
{
    grow(&b->symbol, &b->symbol_cap, symbol + 1);
    arb_set(b->symbol + symbol, v);
}

void num_ball_set_d(struct num_ball *b, int symbol, double v)
{
    grow(&b->symbol, &b->symbol_cap, symbol + 1);
    arb_set_d(b->symbol + symbol, v);
}

static void matrix_of(arb_mat_t A, const struct num_ball *b, const struct expr_solve *s)
{
    arb_mat_init(A, s->m, s->m);
    for (int i = 0; i < s->m; i++)
        for (int k = s->matrix.start[i]; k < s->matrix.start[i + 1]; k++)
            arb_set(arb_mat_entry(A, i, s->matrix.column[k]), b->value + s->matrix.entry[k]);
}

arb_srcptr num_ball_inverse(struct num_ball *b, int index)
{
    int m = b->st->solve[index].m;
    assert(index < b->solutions);
    if (b->inverse[index])
        return b->inverse[index];
    arb_mat_t A;
    matrix_of(A, b, b->st->solve + index);
    bool ok = arb_mat_inv(A, A, b->prec);
    b->inverse[index] = _arb_vec_init((slong)m * m);
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) {
            if (ok)
                arb_swap(b->inverse[index] + i * m + j, arb_mat_entry(A, i, j));
            else
                arb_indeterminate(b->inverse[index] + i * m + j);
        }
    arb_mat_clear(A);
    return b->inverse[index];
}

static void solve(struct num_ball *b, int index)
{
    const struct expr_solve *s = b->st->solve + index;
    int m = s->m;
    arb_mat_t A, r, y;
    b->solution[index] = _arb_vec_init(m);
    if (num_ball_solve_sparse(b, s, b->solution[index]))
        return;
    matrix_of(A, b, s);
    arb_mat_init(r, m, 1);
    arb_mat_init(y, m, 1);
    for (int i = 0; i < m; i++)
        arb_set(arb_mat_entry(r, i, 0), b->value + s->rhs[i]);
    bool ok = sga_watch_ok() && arb_mat_solve(y, A, r, b->prec);
    for (int i = 0; i < m; i++) {
        if (ok)
            arb_swap(b->solution[index] + i, arb_mat_entry(y, i, 0));
        else
            arb_indeterminate(b->solution[index] + i);
    }
    arb_mat_clear(A);
    arb_mat_clear(r);
    arb_mat_clear(y);
}

static void cube_root(arb_t r, const arb_t x, slong prec)
{
    if (!arb_contains_zero(x)) {
        bool negative = arb_is_negative(x);
        arb_abs(r, x);
        arb_root_ui(r, r, 3, prec);
        if (negative)
            arb_neg(r, r);
        return;
    }
    /* [-c, c] holds every real cube root of a ball around 0 */
    arb_t u;
    arb_init(u);
    mag_t m;
    mag_init(m);
    arb_get_mag(m, x);
    arf_set_mag(arb_midref(u), m);
    arb_root_ui(u, u, 3, prec);
    arb_get_mag(m, u);
    arb_zero(r);
    mag_set(arb_radref(r), m);
    mag_clear(m);
    arb_clear(u);
}

/* The ends of x, moved to those of a function's domain that they lie beyond. False: all of x is outside. */
static bool cut_to(arf_t low, arf_t high, const arb_t x, const struct expr_interval *domain, slong prec)
{
    arb_get_lbound_arf(low, x, prec);
    arb_get_ubound_arf(high, x, prec);
    if ((domain->has_low && arf_cmp_si(high, domain->low) < 0) || (domain->has_high && arf_cmp_si(low, domain->high) > 0))
        return false;
    if (domain->has_low && arf_cmp_si(low, domain->low) < 0)
        arf_set_si(low, domain->low);
    if (domain->has_high && arf_cmp_si(high, domain->high) > 0)
        arf_set_si(high, domain->high);
    return true;
}

/* A function on the part of x that lies in its domain: where a ball reaches out of that but not wholly, it has a value only for what is
 * inside; NaN beyond stays NaN. The ends are taken apart, since a midpoint and radius may not be exactly inside, or f not see that they are:
 * it is monotone there. Of an end just inside it needs twice the bits (1 - x^2 at 1 - 2^-80). */
static void elementary(arb_t r, const arb_t x, const struct expr_interval *domain, slong prec, void (*f)(arb_t, const arb_t, slong))
{
    arf_t low, high;
    f(r, x, prec);
    if (!domain->closed || arb_is_finite(r) || !arb_is_finite(x))
        return;
    arf_init(low);
    arf_init(high);
    if (cut_to(low, high, x, domain, prec)) {
        arb_t end;
        arb_init(end);
        arb_set_arf(r, low);
        f(r, r, 2 * prec + 20);
        arb_set_arf(end, high);
        f(end, end, 2 * prec + 20);
        arb_union(r, r, end, prec);
        arb_clear(end);
    }
    arf_clear(low);
    arf_clear(high);
}

/* x^y near x = 0 for y > 0: between 0 and the largest. */
static void power(arb_t r, const arb_t x, const arb_t y, slong prec)
{
    arb_pow(r, x, y, prec);
    if (arb_is_finite(r) || !arb_is_finite(x) || !arb_contains_zero(x) || !arb_is_positive(y))
        return;
    arf_t high;
    arb_t end;
    arf_init(high);
    arb_init(end);
    arb_get_ubound_arf(high, x, prec);
    arb_set_arf(end, high);
    if (arf_sgn(high) > 0)
        arb_pow(end, end, y, prec);
    else
        arb_zero(end);
    arb_zero(r);
    arb_union(r, r, end, prec);
    arf_clear(high);
    arb_clear(end);
}

static void min_max(arb_t r, const arb_t x, const arb_t y, bool max, slong prec)
{
    if (max)
        arb_max(r, x, y, prec);
    else
        arb_min(r, x, y, prec);
}

static void eval(struct num_ball *b, expr_id e)
{
    const struct expr_node *n = b->st->node + e;
    arb_ptr v = b->value, r = v + e;
    arb_srcptr x = v + n->a, y = v + n->b;
    slong p = b->prec;
    b->used[e / BLOCK] = 1;
    switch ((enum expr_op)n->op) {
    case EXPR_UNDEF_OP: arb_indeterminate(r); break;
    case EXPR_CONST: arb_set_fmpq(r, b->st->constant + n->a, p); break;
    case EXPR_PI:    arb_const_pi(r, p); break;
    case EXPR_SYM:   arb_set(r, b->symbol + n->a); break;
    case EXPR_ADD:   arb_add(r, x, y, p); break;
    case EXPR_SUB:   arb_sub(r, x, y, p); break;
    case EXPR_MUL:   arb_mul(r, x, y, p); break;
    case EXPR_DIV:   arb_div(r, x, y, p); break;
    case EXPR_NEG:   arb_neg(r, x); break;
    case EXPR_POWI:
        arb_pow_ui(r, x, (ulong)labs((long)n->b), p);
        if (n->b < 0)
            arb_inv(r, r, p);
        break;
    case EXPR_POW:   power(r, x, y, p); break;
#define X(sym, name) case EXPR_##sym: elementary(r, x, expr_op_domain(EXPR_##sym), p, arb_##name); break;
    EXPR_ELEMENTARY_TABLE(X)
#undef X
    case EXPR_SQRT:  elementary(r, x, expr_op_domain(EXPR_SQRT), p, arb_sqrt); break;
    case EXPR_ATAN2: arb_atan2(r, x, y, p); break;
    case EXPR_CBRT:  cube_root(r, x, p); break;
    case EXPR_ABS:   arb_abs(r, x); break;
    case EXPR_SIGN:  arb_sgn(r, x); break;
    case EXPR_MIN:   min_max(r, x, y, false, p); break;
    case EXPR_MAX:   min_max(r, x, y, true, p); break;
    case EXPR_SOLVE:
        if (!b->solution[n->a])
            solve(b, n->a);
        arb_set(r, b->solution[n->a] + n->b);
        break;
    case EXPR_OP_COUNT: break;
    }
}

/* The highest 64 bits as a whole number, odd where any bit below them is set, to be rounded as all of the bits are; what it is to be multiplied by is a
 * power of 2, in a range that ends all doubles. */
static mp_limb_t highest(const arf_t x, slong exponent, int *power)
{
    enum { RANGE = 4000 };
    mp_srcptr limb;
    mp_size_t limbs;
    ARF_GET_MPN_READONLY(limb, limbs, x);
    slong e = num_ball_log2(x) - exponent;        /* it is in 2^(e - 1) .. 2^e */
    *power = (int)(e > RANGE ? RANGE : e < -RANGE ? -RANGE : e) - FLINT_BITS;
    return limb[limbs - 1] | (limbs > 1);
}

double num_ball_double(const arf_t x, slong exponent)
{
    int power;
    if (arf_is_special(x))
        return arf_get_d(x, ARF_RND_NEAR);
    double v = (double)highest(x, exponent, &power);
    return ldexp(arf_sgn(x) < 0 ? -v : v, power);
}

long double num_ball_long(const arf_t x, slong exponent)
{
    int power;
    if (arf_is_special(x))
        return arf_get_d(x, ARF_RND_NEAR);
    long double v = highest(x, exponent, &power);
    return ldexpl(arf_sgn(x) < 0 ? -v : v, power);
}

static void extend(struct num_ball *b, int nodes)
{
    cover(b);
    while (b->nodes < nodes) {
        int upto = nodes - b->nodes > BATCH ? b->nodes + BATCH : nodes;
        sga_watch_count(SGA_COUNT_BALLS, upto - b->nodes);
        for (; b->nodes < upto; b->nodes++)
            if (b->asked[b->nodes] != b->round)
                eval(b, b->nodes);
    }
}

void num_ball_extend(struct num_ball *b)
{
    extend(b, b->st->nodes);
}

static bool is_known(const struct num_ball *b, expr_id e)
{
    return (int)e < b->nodes || b->asked[e] == b->round;
}

/* Evaluates nodes of a list, children first. */
static void eval_all(struct num_ball *b, const expr_id *list, int count)
{
    for (int from = 0; from < count; from += BATCH) {
        int upto = count - from > BATCH ? from + BATCH : count;
        sga_watch_count(SGA_COUNT_BALLS, upto - from);
        for (int i = from; i < upto; i++)
            eval(b, list[i]);
    }
}

void num_ball_ask(struct num_ball *b, expr_id e)
{
    int count = 0;
    cover(b);
    if (is_known(b, e))
        return;
    SGA_RESERVE(b->wanted, b->wanted_cap, 1);
    b->wanted[count++] = e;
    b->asked[e] = b->round;
    for (int i = 0; i < count; i++) {
        int children = expr_children(b->st, b->wanted[i]);
        SGA_RESERVE(b->wanted, b->wanted_cap, count + children);
        for (int k = 0; k < children; k++) {
            expr_id child = expr_child(b->st, b->wanted[i], k);
            if (is_known(b, child))
                continue;
            b->asked[child] = b->round;
            b->wanted[count++] = child;
        }
    }
    sga_sort(b->wanted, (size_t)count);
    eval_all(b, b->wanted, count);
}

void num_ball_list(struct num_ball *b, const expr_id *list, int count)
{
    cover(b);
    drop_solutions(b);
    cover(b);
    eval_all(b, list, count);
}

void num_ball_constant(const struct expr_store *st, expr_id e, double otherwise, slong prec, arb_t r)
{
    if (e == EXPR_UNDEF) {
        arb_set_d(r, otherwise);
        return;
    }
    if (expr_is_const(st, e)) {
        arb_set_fmpq(r, expr_const_value(st, e), prec);
        return;
    }
    struct num_ball b;
    struct expr_cone cone;
    num_ball_init(&b, st, prec);
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    num_ball_list(&b, cone.list, cone.count);
    arb_set(r, num_ball_value(&b, e));
    expr_cone_clear(&cone);
    num_ball_clear(&b);
}
