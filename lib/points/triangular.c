/* One variable for each constraint, in order. */
#include "triangular.h"

#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "mem.h"
#include "points_space.h"
#include "shape.h"

enum { MOST_BITS = 1 << 18 };

struct work {
    const struct points_space *s;
    struct points_point *p;
    struct expr_cone cone;
    unsigned char *shape;          /* by position in the cone */
    unsigned char *last;           /* by position in the cone, of symbols: the shape of its last node in it */
    size_t shape_cap, last_cap;
    unsigned char *used;           /* by variable: in a constraint that is solved */
    int *variable_of;              /* by symbol, or -1 */
    bool any_size;
    int *turn, *chosen;            /* the order of solving, and by constraint the variable to solve for or -1 (any) */
};

enum { SIZE_MOST = 1000 };         /* log2: of values that are in doubles */

/* All of the cone at v = 0. */
static void values_at_zero(struct work *w, int symbol)
{
    SGA_ENDS(arb_end) arb_t zero = { 0 };
    num_ball_set(&w->p->ball, symbol, zero);
    num_ball_list(&w->p->ball, w->cone.list, w->cone.count);
}

/* The derivative of the cone's last node by v, in which it is affine, from the values: a difference of two values would be lost beside a large
 * rest (s = cosh(10^6 x)). */
static void slope_of(struct work *w, arb_t out)
{
    const struct expr_store *st = w->s->st;
    struct num_ball *b = &w->p->ball;
    int count = w->cone.count;
    SGA_ARENA(mem);
    arb_ptr d = arbs_take(&mem, count);
    for (int k = 0; k < count; k++) {
        const struct expr_node n = st->node[w->cone.list[k]];
        if (w->shape[k] == POINTS_FREE)
            continue;
        arb_srcptr x = n.op == EXPR_SYM ? NULL : d + w->cone.place[n.a];
        switch ((enum expr_op)n.op) {
        case EXPR_SYM: arb_one(d + k); break;
        case EXPR_ADD: arb_add(d + k, x, d + w->cone.place[n.b], b->prec); break;
        case EXPR_SUB: arb_sub(d + k, x, d + w->cone.place[n.b], b->prec); break;
        case EXPR_NEG: arb_neg(d + k, x); break;
        case EXPR_DIV: arb_div(d + k, x, num_ball_value(b, n.b), b->prec); break;
        default:       /* a product, one side of which is free of v */
            if (w->shape[w->cone.place[n.a]] != POINTS_FREE)
                arb_mul(d + k, x, num_ball_value(b, n.b), b->prec);
            else
                arb_mul(d + k, num_ball_value(b, n.a), d + w->cone.place[n.b], b->prec);
            break;
        }
    }
    arb_set(out, d + count - 1);
}

enum answer { NO, YES, MORE_BITS };

/* e = slope v + rest with slope not 0: sets v. A slope whose ball is wide may not be 0. */
static enum answer solve_for(struct work *w, expr_id e, int variable)
{
    int symbol = w->s->variable[variable];
    struct num_ball *b = &w->p->ball;
    SGA_ENDS(arb_end) arb_t rest = { 0 }, slope = { 0 }, keep = { 0 };
    arb_set(keep, b->symbol + symbol);
    values_at_zero(w, symbol);
    arb_set(rest, num_ball_value(b, e));
    slope_of(w, slope);
    bool ok = arb_is_finite(rest) && arb_is_finite(slope) && !arb_contains_zero(slope);
    if (ok) {
        arb_div(rest, rest, slope, b->prec);
        arb_neg(rest, rest);
    }
    bool wide = !ok && (!arb_is_finite(slope) || mag_cmp_2exp_si(arb_radref(slope), -30) > 0);
    num_ball_set(b, symbol, ok ? rest : keep);
    return ok ? YES : wide ? MORE_BITS : NO;
}

/* The cone of a constraint, with its shapes in all symbols. */
static void look_at(struct work *w, int i)
{
    expr_cone_of(w->s->st, &w->cone, w->s->constraint + i, 1);
    expr_cone_index(&w->cone);
    SGA_RESERVE(w->shape, w->shape_cap, w->cone.count);
    SGA_RESERVE(w->last, w->last_cap, w->cone.count);
    points_shapes(w->s->st, &w->cone, w->last);
}

static enum answer solve_one(struct work *w, int i)
{
    const struct points_space *s = w->s;
    expr_id e = s->constraint[i];
    enum answer answer = NO;
    look_at(w, i);
    for (int k = w->cone.count - 1; k >= 0 && answer == NO; k--) {
        const struct expr_node n = s->st->node[w->cone.list[k]];
        int v = n.op == EXPR_SYM ? w->variable_of[n.a] : -1;
        if (v < 0 || w->used[v] || (w->chosen[i] >= 0 && w->chosen[i] != v) || w->last[k] != POINTS_AFFINE)
            continue;
        points_shape_in(s->st, &w->cone, n.a, w->shape);
        answer = solve_for(w, e, v);
        if (answer == YES && !w->any_size && num_ball_log2(arb_midref(w->p->ball.symbol + s->variable[v])) > SIZE_MOST)
            return NO;
        w->p->solved[i] = v;
    }
    for (int k = 0; k < w->cone.count; k++) {
        const struct expr_node n = s->st->node[w->cone.list[k]];
        if (n.op == EXPR_SYM && w->variable_of[n.a] >= 0)
            w->used[w->variable_of[n.a]] = 1;
    }
    return answer;
}

/* Whether all that was solved for is known to so many bits. */
static bool narrow(const struct work *w, slong prec)
{
    bool all = true;
    for (int i = 0; i < w->s->constraints && all; i++) {
        arb_srcptr v = w->p->ball.symbol + w->s->variable[w->p->solved[i]];
        all = arb_rel_accuracy_bits(v) >= prec || mag_cmp_2exp_si(arb_radref(v), -prec) < 0;
    }
    return all;
}

/* Which constraints still to be placed contain a variable: how many, and the exclusive or of their places and of their shapes in it. */
struct meets {
    int count, which;
    unsigned char shape;
};

/* An order that does not depend on that of the constraints: a variable that only one of those left contains, which is
 * affine in it, is solved for after all others, and that one is set aside; and so on. False where this comes to an
 * end. */
static bool by_shape(struct work *w)
{
    const struct points_space *s = w->s;
    int c = s->constraints, n = s->variables, place = c, depth = 0;
    SGA_ARENA(mem);
    int **of = sga_zeros(&mem, (size_t)c + 1, sizeof *of), *len = sga_zeros(&mem, (size_t)c + 1, sizeof *len);
    unsigned char **shape = sga_zeros(&mem, (size_t)c + 1, sizeof *shape);
    struct meets *meet = sga_zeros(&mem, (size_t)n + 1, sizeof *meet);
    size_t total = 1;
    for (int i = 0; i < c; i++) {
        look_at(w, i);
        of[i] = sga_take(&mem, ((size_t)w->cone.count + 1) * sizeof **of);
        shape[i] = sga_take(&mem, (size_t)w->cone.count + 1);
        for (int k = 0; k < w->cone.count; k++) {
            const struct expr_node *e = s->st->node + w->cone.list[k];
            int v = e->op == EXPR_SYM ? w->variable_of[e->a] : -1;
            if (v < 0)
                continue;
            shape[i][len[i]] = w->last[k];
            of[i][len[i]++] = v;
            meet[v].count++;
            meet[v].which ^= i;
            meet[v].shape ^= w->last[k];
        }
        total += (size_t)len[i];
        w->chosen[i] = -1;
    }
    int *stack = sga_take(&mem, (total + (size_t)n) * sizeof *stack);
    for (int v = 0; v < n; v++)
        if (meet[v].count == 1)
            stack[depth++] = v;
    while (depth) {
        int v = stack[--depth], i = meet[v].which;
        if (meet[v].count != 1 || meet[v].shape != POINTS_AFFINE)
            continue;
        w->chosen[i] = v;
        w->turn[--place] = i;
        for (int k = 0; k < len[i]; k++) {
            meet[of[i][k]].which ^= i;
            meet[of[i][k]].shape ^= shape[i][k];
            if (--meet[of[i][k]].count == 1)
                stack[depth++] = of[i][k];
        }
    }
    return place == 0;
}

static bool solve_all(struct work *w, slong prec)
{
    const struct points_space *s = w->s;
    struct points_point *p = w->p;
    bool ok = false, more = true;
    for (slong bits = prec + 40 + 4 * s->constraints; more && bits <= MOST_BITS; bits *= 2) {
        p->ball.prec = bits;
        memset(w->used, 0, (size_t)s->variables);
        enum answer answer = YES;
        for (int i = 0; i < s->constraints && answer == YES; i++)
            answer = solve_one(w, w->turn[i]);
        ok = answer == YES && narrow(w, prec);
        more = !ok && answer != NO;         /* each step multiplies the error that it is given */
    }
    return ok;
}

static bool in_given_order(struct work *w, slong prec)
{
    for (int i = 0; i < w->s->constraints; i++) {
        w->turn[i] = i;
        w->chosen[i] = -1;
    }
    return solve_all(w, prec);
}

/* The variables' balls, to go back to: a start that this way does not lead on from is one for steps, which go by p->x. The caller clears it. */
static arb_ptr kept(struct sga_arena *mem, const struct points_space *s, const struct points_point *p)
{
    arb_ptr v = arbs_take(mem, s->variables);
    for (int j = 0; j < s->variables; j++)
        arb_set(v + j, p->ball.symbol + s->variable[j]);
    return v;
}

bool points_triangular(const struct points_space *s, struct points_point *p, slong prec, bool any_size)
{
    SGA_ARENA(mem);
    struct work w = { .s = s, .p = p, .any_size = any_size };
    arb_ptr before = kept(&mem, s, p);
    w.turn = sga_take(&mem, (size_t)(s->constraints + 1) * sizeof *w.turn);
    w.chosen = sga_take(&mem, (size_t)(s->constraints + 1) * sizeof *w.chosen);
    expr_cone_init(&w.cone);
    w.used = sga_zeros(&mem, (size_t)s->variables + 1, 1);
    w.variable_of = sga_take(&mem, (size_t)s->st->symbols * sizeof *w.variable_of);
    for (int i = 0; i < s->st->symbols; i++)
        w.variable_of[i] = -1;
    for (int j = 0; j < s->variables; j++) {
        w.variable_of[s->variable[j]] = j;
        mag_zero(arb_radref(p->ball.symbol + s->variable[j]));
    }
    bool ok = (by_shape(&w) && solve_all(&w, prec)) || in_given_order(&w, prec);
    p->ball.prec = prec;
    for (int j = 0; j < s->variables; j++) {
        if (ok)
            p->x[j] = arf_get_d(arb_midref(p->ball.symbol + s->variable[j]), ARF_RND_NEAR);
        else
            num_ball_set(&p->ball, s->variable[j], before + j);
    }
    p->certified = p->triangular = ok;
    num_ball_forget(&p->ball);
    expr_cone_clear(&w.cone);
    free(w.shape);
    free(w.last);
    return ok;
}
