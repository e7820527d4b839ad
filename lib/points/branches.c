/* Branches of abs, sign, min, max at points. */
#include "branches.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "mem.h"
#include "points_space.h"

/* log2: nearer to a change of branch a point is on neither. */
enum { NEAR_KINK = -30 };

void points_branches_at(struct points_branches *b, const struct points_space *s, struct points_point *p)
{
    SGA_ENDS(arb_end) arb_t d = { 0 };
    signed char *swap = b->before;
    b->before = b->now;
    b->now = swap;
    num_ball_list(&p->ball, b->cone.list, b->cone.count);
    for (int k = 0; k < b->cone.count; k++) {
        const struct expr_node n = s->st->node[b->cone.list[k]];
        bool pair = n.op == EXPR_MIN || n.op == EXPR_MAX;
        b->now[k] = 0;
        if (!pair && n.op != EXPR_ABS && n.op != EXPR_SIGN)
            continue;
        arb_set(d, num_ball_value(&p->ball, n.a));
        if (pair)
            arb_sub(d, d, num_ball_value(&p->ball, n.b), p->ball.prec);
        if (!arb_contains_zero(d) && arf_cmpabs_2exp_si(arb_midref(d), NEAR_KINK) > 0)
            b->now[k] = arb_is_positive(d) ? 1 : -1;
    }
    num_ball_forget(&p->ball);
}

void points_branches_init(struct points_branches *b, const struct points_space *s)
{
    expr_cone_init(&b->cone);
    b->now = b->before = b->guess = NULL;
    b->asked = s->same_branches && s->near && s->constraints;
    if (!b->asked)
        return;
    expr_cone_of(s->st, &b->cone, s->constraint, s->constraints);
    b->asked = false;
    for (int k = 0; k < b->cone.count && !b->asked; k++) {
        enum expr_op op = expr_op_of(s->st, b->cone.list[k]);
        b->asked = op == EXPR_ABS || op == EXPR_SIGN || op == EXPR_MIN || op == EXPR_MAX;
    }
    b->now = sga_calloc((size_t)b->cone.count + 1, 1);
    b->before = sga_calloc((size_t)b->cone.count + 1, 1);
    b->guess = sga_calloc((size_t)b->cone.count + 1, 1);
}

static void put_in(const struct points_space *s, struct points_point *p, const double *x, double t)
{
    for (int j = 0; j < s->variables; j++)
        num_ball_set_d(&p->ball, s->variable[j], x[j]);
    if (s->time >= 0)
        num_ball_set_d(&p->ball, s->time, t);
}

void points_branches_at_guess(struct points_branches *b, const struct points_space *s, struct points_point *p)
{
    put_in(s, p, s->near, s->near_time);
    points_branches_at(b, s, p);
    memcpy(b->guess, b->now, (size_t)b->cone.count);
    put_in(s, p, p->x, p->t);
}

bool points_branches_kept(struct points_branches *b, const struct points_space *s, struct points_point *p)
{
    assert(!b->cone.count || (b->now && b->before));
    points_branches_at(b, s, p);
    bool kept = true;
    for (int k = 0; k < b->cone.count; k++) {
        signed char asked = b->guess[k] ? b->guess[k] : b->before[k];
        kept &= !asked || asked == b->now[k];
    }
    return kept;
}

void points_branches_clear(struct points_branches *b)
{
    expr_cone_clear(&b->cone);
    free(b->now);
    free(b->before);
    free(b->guess);
}
