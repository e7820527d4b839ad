/* One variable for each constraint, in order. */
#include "triangular.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"

enum { MOST_BITS = 1 << 18 };

enum shape { FREE, AFFINE, OTHER };

static enum shape larger(enum shape a, enum shape b)
{
    return a > b ? a : b;
}

/* How each node of the list depends on a symbol; shape is by position. */
static enum shape shape_in(const struct expr_store *st, const struct expr_cone *cone, int symbol, unsigned char *shape)
{
    for (int k = 0; k < cone->count; k++) {
        const struct expr_node n = st->node[cone->list[k]];
        enum shape s = FREE, x, y;
        int children = expr_children(st, cone->list[k]);
        for (int c = 0; c < children; c++)
            s = larger(s, shape[cone->place[expr_child(st, cone->list[k], c)]]);
        switch ((enum expr_op)n.op) {
        case EXPR_SYM: s = n.a == symbol ? AFFINE : FREE; break;
        case EXPR_ADD: case EXPR_SUB: case EXPR_NEG: break;
        case EXPR_MUL:
            x = shape[cone->place[n.a]];
            y = shape[cone->place[n.b]];
            s = x && y ? OTHER : larger(x, y);
            break;
        case EXPR_DIV: s = shape[cone->place[n.b]] ? OTHER : shape[cone->place[n.a]]; break;
        default: s = s ? OTHER : FREE; break;
        }
        shape[k] = (unsigned char)s;
    }
    return shape[cone->count - 1];
}

struct work {
    const struct points_space *s;
    struct points_point *p;
    struct expr_cone cone;
    unsigned char *shape;          /* by position in the cone */
    size_t shape_cap;
    unsigned char *used;           /* by variable: in a constraint that is solved */
    int *variable_of;              /* by symbol, or -1 */
};

/* e at v = at */
static void value_at(struct work *w, expr_id e, int symbol, long at, arb_t out)
{
    arb_t v;
    arb_init(v);
    arb_set_si(v, at);
    num_ball_set(&w->p->ball, symbol, v);
    num_ball_list(&w->p->ball, w->cone.list, w->cone.count);
    arb_set(out, num_ball_value(&w->p->ball, e));
    arb_clear(v);
}

enum answer { NO, YES, MORE_BITS };

/* e = slope v + rest with slope not 0: sets v. A slope whose ball is wide may not be 0. */
static enum answer solve_for(struct work *w, expr_id e, int variable)
{
    int symbol = w->s->variable[variable];
    struct num_ball *b = &w->p->ball;
    arb_t rest, slope, keep;
    arb_init(rest);
    arb_init(slope);
    arb_init(keep);
    arb_set(keep, b->symbol + symbol);
    value_at(w, e, symbol, 1, slope);
    value_at(w, e, symbol, 0, rest);
    arb_sub(slope, slope, rest, b->prec);
    bool ok = arb_is_finite(rest) && arb_is_finite(slope) && !arb_contains_zero(slope);
    if (ok) {
        arb_div(rest, rest, slope, b->prec);
        arb_neg(rest, rest);
    }
    bool wide = !ok && (!arb_is_finite(slope) || mag_cmp_2exp_si(arb_radref(slope), -30) > 0);
    num_ball_set(b, symbol, ok ? rest : keep);
    arb_clear(rest);
    arb_clear(slope);
    arb_clear(keep);
    return ok ? YES : wide ? MORE_BITS : NO;
}

static enum answer solve_one(struct work *w, int i)
{
    const struct points_space *s = w->s;
    expr_id e = s->constraint[i];
    enum answer answer = NO;
    expr_cone_of(s->st, &w->cone, &e, 1);
    expr_cone_index(&w->cone);
    SGA_RESERVE(w->shape, w->shape_cap, w->cone.count);
    for (int k = w->cone.count - 1; k >= 0 && answer == NO; k--) {
        const struct expr_node n = s->st->node[w->cone.list[k]];
        int v = n.op == EXPR_SYM ? w->variable_of[n.a] : -1;
        if (v < 0 || w->used[v] || shape_in(s->st, &w->cone, n.a, w->shape) != AFFINE)
            continue;
        answer = solve_for(w, e, v);
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

static enum answer solve_all(struct work *w, bool backward)
{
    int count = w->s->constraints;
    enum answer answer = YES;
    memset(w->used, 0, (size_t)w->s->variables);
    for (int i = 0; i < count && answer == YES; i++)
        answer = solve_one(w, backward ? count - 1 - i : i);
    return answer;
}

bool points_triangular(const struct points_space *s, struct points_point *p, slong prec)
{
    struct work w = { .s = s, .p = p };
    expr_cone_init(&w.cone);
    w.used = sga_calloc((size_t)s->variables + 1, 1);
    w.variable_of = sga_malloc((size_t)s->st->symbols * sizeof *w.variable_of);
    for (int i = 0; i < s->st->symbols; i++)
        w.variable_of[i] = -1;
    for (int j = 0; j < s->variables; j++) {
        w.variable_of[s->variable[j]] = j;
        mag_zero(arb_radref(p->ball.symbol + s->variable[j]));
    }
    bool ok = false;
    for (int way = 0; way < 2 && !ok; way++) {
        bool more = true;
        for (slong bits = prec + 40 + 4 * s->constraints; more && bits <= MOST_BITS; bits *= 2) {
            p->ball.prec = bits;
            enum answer answer = solve_all(&w, way);
            ok = answer == YES && narrow(&w, prec);
            more = !ok && answer != NO;         /* each step multiplies the error that it is given */
        }
    }
    p->ball.prec = prec;
    for (int j = 0; j < s->variables && ok; j++)
        p->x[j] = arf_get_d(arb_midref(p->ball.symbol + s->variable[j]), ARF_RND_NEAR);
    p->certified = p->triangular = ok;
    num_ball_forget(&p->ball);
    expr_cone_clear(&w.cone);
    free(w.shape);
    free(w.used);
    free(w.variable_of);
    return ok;
}
