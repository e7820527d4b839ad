/* Equations taken apart from the outside, with a list of ways kept in hand. */
#include "take_apart.h"

#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "range.h"
#include "warnings.h"

enum { WAYS = SGA_MOST_ENDS_WAYS, LARGEST_CONE = 400, STEPS = 2000 };

struct need {
    expr_id node, value;      /* node = value, a constant */
};

/* One way under work: what is still to be taken apart, and what came out. */
struct way {
    struct need *need; int needs; size_t cap;
    struct take_apart_option out;
};

struct work {
    struct state *s;
    struct expr_store *st;
    struct expr_cone cone;
    struct range *range;
    struct way way[WAYS]; int ways;
    bool changed;
};

static unsigned facts(struct work *w, expr_id e)
{
    return expr_facts_of(w->s->facts, w->st, e);
}

static bool constant(struct work *w, expr_id e)
{
    return !(facts(w, e) & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME | EXPR_HAS_PARAMETER));
}

static int sign_of(struct work *w, expr_id e)
{
    return range_compare(w->st, e, expr_int(w->st, 0));
}

static void ask(struct way *y, expr_id node, expr_id value)
{
    SGA_RESERVE(y->need, y->cap, y->needs + 1);
    y->need[y->needs++] = (struct need){ node, value };
}

/* A constant that is seen to be a simple fraction (cos(pi/2), tan(pi/4)) is taken as that:
 * the caller checks in the end that what was replaced vanishes with what took its place. */
static expr_id simple(struct expr_store *st, expr_id v)
{
    if (!v || expr_is_const(st, v))
        return v;
    SGA_ENDS(num_ball_clear) struct num_ball b;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_ENDS(arb_end) arb_t t = { 0 };
    SGA_ENDS(fmpz_end) fmpz_t n = { 0 };
    expr_id r = v;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &v, 1);
    num_ball_init(&b, st, 600);
    num_ball_list(&b, cone.list, cone.count);
    for (long q = 1; q <= 12 && r == v; q++) {
        arb_mul_si(t, num_ball_value(&b, v), q, 600);
        if (arb_is_finite(t) && mag_cmp_2exp_si(arb_radref(t), -500) < 0 && arb_get_unique_fmpz(n, t) && fmpz_bits(n) < 30)
            r = expr_rational(st, fmpz_get_si(n), q);
    }
    return r;
}

static void give(struct way *y, expr_id f)
{
    for (int i = 0; i < y->out.count; i++)
        if (y->out.out[i] == f)
            return;
    SGA_RESERVE(y->out.out, y->out.cap, y->out.count + 1);
    y->out.out[y->out.count++] = f;
}

/* A second way that begins where y stands; NULL where there are enough. */
static struct way *fork_way(struct work *w, const struct way *y)
{
    if (w->ways == WAYS)
        return NULL;
    struct way *z = w->way + w->ways++;
    *z = (struct way){ 0 };
    for (int i = 0; i < y->needs; i++)
        ask(z, y->need[i].node, y->need[i].value);
    for (int i = 0; i < y->out.count; i++)
        give(z, y->out.out[i]);
    return z;
}

enum answer { DONE, NEVER, NOT_SO };     /* taken apart; no solution; nothing found */

/* a op b = v where one of the two is a constant. */
static enum answer arithmetic(struct work *w, struct way *y, const struct expr_node n, expr_id v)
{
    bool two = n.op == EXPR_ADD || n.op == EXPR_SUB || n.op == EXPR_MUL || n.op == EXPR_DIV;      /* b of a power is no node */
    bool ca = two && constant(w, n.a), cb = two && constant(w, n.b);
    struct expr_store *st = w->st;
    switch ((enum expr_op)n.op) {
    case EXPR_NEG: ask(y, n.a, expr_neg(st, v)); return DONE;
    case EXPR_ADD:
        if (ca || cb)
            ask(y, ca ? n.b : n.a, expr_sub(st, v, ca ? n.a : n.b));
        return ca || cb ? DONE : NOT_SO;
    case EXPR_SUB:
        if (ca || cb)
            ask(y, ca ? n.b : n.a, ca ? expr_sub(st, n.a, v) : expr_add(st, v, n.b));
        return ca || cb ? DONE : NOT_SO;
    case EXPR_MUL: {
        expr_id k = ca ? n.a : n.b, f = ca ? n.b : n.a;
        int sign = ca || cb ? sign_of(w, k) : 0;
        if (sign == 1 || sign == -1)
            ask(y, f, expr_div(st, v, k));
        else if (expr_is_zero(st, v) && facts(w, n.a) & EXPR_NONZERO)
            ask(y, n.b, v);
        else if (expr_is_zero(st, v) && facts(w, n.b) & EXPR_NONZERO)
            ask(y, n.a, v);
        else
            return NOT_SO;
        return DONE;
    }
    case EXPR_DIV: {
        int sign = cb ? sign_of(w, n.b) : 0;
        if (sign_of(w, v) == 0)
            ask(y, n.a, expr_int(st, 0));
        else if (sign == 1 || sign == -1)
            ask(y, n.a, expr_mul(st, v, n.b));
        else if (ca && sign_of(w, v) != RANGE_UNKNOWN && sign_of(w, n.a) != 0)
            ask(y, n.b, expr_div(st, n.a, v));
        else
            return NOT_SO;
        return DONE;
    }
    default: return NOT_SO;
    }
}

/* g(u) = v for g with an inverse; v is inside g's range (the range has been asked). */
static enum answer inverse(struct work *w, struct way *y, const struct expr_node n, expr_id v)
{
    struct expr_store *st = w->st;
    int sign = sign_of(w, v);
    bool zero = sign == 0, known = sign != RANGE_UNKNOWN;
    enum expr_op undone = expr_op_undone((enum expr_op)n.op);
    if (undone) {
        ask(y, n.a, expr_fun(st, undone, v));
        return DONE;
    }
    switch ((enum expr_op)n.op) {
    case EXPR_EXP: if (sign != 1) return NOT_SO; ask(y, n.a, expr_fun(st, EXPR_LOG, v)); return DONE;
    case EXPR_SQRT: if (!known) return NOT_SO; ask(y, n.a, expr_powi(st, v, 2)); return DONE;
    case EXPR_CBRT: ask(y, n.a, expr_powi(st, v, 3)); return DONE;
    case EXPR_TANH: if (!zero) return NOT_SO; ask(y, n.a, v); return DONE;
    case EXPR_ABS: case EXPR_SIGN: if (!zero) return NOT_SO; ask(y, n.a, v); return DONE;
    case EXPR_POWI:
        if (n.b <= 0 || !zero)
            return NOT_SO;
        ask(y, n.a, v);
        return DONE;
    case EXPR_POW:
        if (expr_is_const(st, n.b) && fmpq_sgn(expr_const_value(st, n.b)) > 0 && (zero || sign == 1)) {
            ask(y, n.a, zero ? v : expr_pow(st, v, expr_div(st, expr_int(st, 1), n.b)));
            return DONE;
        }
        if (constant(w, n.a) && sign == 1 && range_compare(st, n.a, expr_int(st, 1)) != 0) {    /* a^u = v */
            ask(y, n.b, expr_div(st, expr_fun(st, EXPR_LOG, v), expr_fun(st, EXPR_LOG, n.a)));
            return DONE;
        }
        return NOT_SO;
    default: return NOT_SO;
    }
}

/* sin u or cos u = 1 or -1, cosh u = 1: a function of half the angle vanishes. */
static enum answer turning(struct work *w, struct way *y, const struct expr_node n, bool high)
{
    struct expr_store *st = w->st;
    if (n.op == EXPR_COSH) {
        ask(y, n.a, expr_int(st, 0));
        return DONE;
    }
    if (n.op != EXPR_SIN && n.op != EXPR_COS)
        return NOT_SO;
    expr_id half = expr_mul(st, expr_rational(st, 1, 2), n.a);
    if (n.op == EXPR_SIN)
        half = expr_add(st, half, expr_mul(st, expr_rational(st, high ? -1 : 1, 4), expr_pi(st)));
    give(y, expr_fun(st, n.op == EXPR_COS && !high ? EXPR_COS : EXPR_SIN, half));
    return DONE;
}

/* a b = v, an end of the range of a box: both factors are at ends, one pair for each way. */
static enum answer corners(struct work *w, struct way *y, const struct expr_node n, struct range a, struct range b, expr_id v)
{
    expr_id x[2] = { a.lo, a.hi }, z[2] = { b.lo, b.hi };
    bool hit[4];
    int hits = 0;
    if (sign_of(w, v) == 0 || n.a == n.b)
        return NOT_SO;
    for (int k = 0; k < 4; k++) {
        expr_id p = x[k / 2] && z[k % 2] ? expr_mul(w->st, x[k / 2], z[k % 2]) : EXPR_UNDEF;
        int c = p ? range_compare(w->st, p, v) : 1;
        if (c == RANGE_UNKNOWN)
            return NOT_SO;
        hit[k] = c == 0;
        hits += hit[k];
    }
    if (hits && w->ways + hits - 1 > WAYS)
        sga_limit_open(w->s->options->budget, SGA_LIMIT_ENDS_WAYS);
    if (!hits || w->ways + hits - 1 > WAYS)
        return NOT_SO;
    for (int k = 3; k >= 0; k--) {
        if (!hit[k])
            continue;
        struct way *to = --hits ? fork_way(w, y) : y;
        ask(to, n.b, z[k % 2]);
        ask(to, n.a, x[k / 2]);
    }
    return DONE;
}

/* node = v where v is the lower (upper) end of its range. */
static enum answer at_end(struct work *w, struct way *y, const struct expr_node n, expr_id v, bool high)
{
    const struct range *r = w->range;
    int args = expr_op_args((enum expr_op)n.op);
    struct range a = args > 0 ? r[w->cone.place[n.a]] : (struct range){ 0 };
    struct range b = args > 1 ? r[w->cone.place[n.b]] : (struct range){ 0 };
    switch ((enum expr_op)n.op) {
    case EXPR_ADD:
        ask(y, n.b, high ? b.hi : b.lo);      /* the last is taken apart first */
        ask(y, n.a, high ? a.hi : a.lo);
        return DONE;
    case EXPR_SUB:
        ask(y, n.b, high ? b.lo : b.hi);
        ask(y, n.a, high ? a.hi : a.lo);
        return DONE;
    case EXPR_MUL: return corners(w, y, n, a, b, v);
    case EXPR_MIN: case EXPR_MAX:        /* max is at its lower end where both are, if these are equal */
        if (high == (n.op == EXPR_MAX) || (high ? !a.hi || !b.hi : !a.lo || !b.lo)
            || range_compare(w->st, high ? a.hi : a.lo, v) != 0 || range_compare(w->st, high ? b.hi : b.lo, v) != 0)
            return NOT_SO;
        ask(y, n.b, v);
        ask(y, n.a, v);
        return DONE;
    default: return turning(w, y, n, high);
    }
}

/* One equation of a way. */
static enum answer take_apart(struct work *w, struct way *y, struct need q)
{
    const struct expr_node n = w->st->node[q.node];
    struct range r = w->range[w->cone.place[q.node]];
    if (constant(w, q.node)) {
        int c = range_compare(w->st, q.node, q.value);
        return c == 0 ? DONE : c == RANGE_UNKNOWN ? NOT_SO : NEVER;
    }
    int low = r.lo ? range_compare(w->st, q.value, r.lo) : 1, high = r.hi ? range_compare(w->st, q.value, r.hi) : -1;
    if (low == -1 || high == 1 || (low == 0 && !r.lo_in) || (high == 0 && !r.hi_in))
        return NEVER;
    enum answer a = arithmetic(w, y, n, q.value);
    if (a != NOT_SO)
        return a;
    if (low != RANGE_UNKNOWN && high != RANGE_UNKNOWN)
        a = inverse(w, y, n, q.value);
    if (a == NOT_SO && (low == 0 || high == 0))
        a = at_end(w, y, n, q.value, high == 0);
    w->changed |= a == DONE;
    return a;
}

static void drop_way(struct work *w, int i)
{
    free(w->way[i].need);
    free(w->way[i].out.out);
    memmove(w->way + i, w->way + i + 1, (size_t)(--w->ways - i) * sizeof *w->way);
}

/* All ways to their ends. False: too long. */
static bool run(struct work *w)
{
    int steps = 0;
    for (int i = 0; i < w->ways; i++) {
        bool never = false;
        while (w->way[i].needs && !never) {
            struct need q = w->way[i].need[--w->way[i].needs];
            enum answer a = q.node && q.value && steps++ < STEPS ? take_apart(w, w->way + i, q) : NOT_SO;
            if (a == NOT_SO)
                give(w->way + i, expr_sub(w->st, q.node, simple(w->st, q.value)));
            never = a == NEVER;
        }
        if (never)
            drop_way(w, i--);
        w->changed |= never;
    }
    return steps < STEPS && expr_store_ok(w->st);
}

struct take_apart take_apart_of(struct state *s, expr_id f)
{
    struct work w = { .s = s, .st = s->st };
    struct take_apart e = { 0 };
    struct sga_error before = *s->st->error;
    bool ok = false;
    expr_cone_init(&w.cone);
    expr_cone_of(s->st, &w.cone, &f, 1);
    if (w.cone.count <= LARGEST_CONE && expr_store_ok(s->st)) {
        expr_cone_index(&w.cone);
        w.range = sga_calloc((size_t)w.cone.count, sizeof *w.range);
        range_of_list(s->st, s->facts, w.cone.list, w.cone.count, w.cone.place, w.range);
        w.ways = 1;
        ask(w.way, f, expr_int(s->st, 0));
        ok = run(&w);
    }
    *s->st->error = before;
    if (ok && w.changed) {
        for (int i = 0; i < w.ways; i++) {
            e.option = sga_realloc(e.option, (size_t)(e.options + 1) * sizeof *e.option);
            e.option[e.options++] = w.way[i].out;
            free(w.way[i].need);
        }
        e.changed = !(e.options == 1 && e.option[0].count == 1 && e.option[0].out[0] == f);
    } else {
        while (w.ways)
            drop_way(&w, 0);
        e.option = sga_calloc(1, sizeof *e.option);
        e.option->out = sga_malloc(sizeof f);
        e.option->out[0] = f;
        e.option->count = e.options = 1;
    }
    expr_cone_clear(&w.cone);
    free(w.range);
    return e;
}

void take_apart_clear(struct take_apart *e)
{
    for (int i = 0; i < e->options; i++)
        free(e->option[i].out);
    free(e->option);
    *e = (struct take_apart){ 0 };
}
