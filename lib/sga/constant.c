/* Functions that do not vary along the present constraint set. */
#include "state.h"

#include <stdlib.h>
#include <string.h>

#include <arb_mat.h>

#include "arb_ends.h"
#include "arena.h"
#include "derive.h"
#include "facts.h"
#include "mem.h"
#include "needed_bits.h"
#include "oracle.h"
#include "points.h"
#include "system.h"

/* Whether d_x e lies in the span of the constraints' differentials at point p:
 * 1 yes (every residue's ball contains 0), 0 no, -1 no value. */
static int dependent_at(struct state *s, struct points_point *p, const expr_id *grad, slong need)
{
    int c = s->sol->constraints, n = s->sys->variables;
    num_ball_extend(&p->ball);
    SGA_ENDS(arb_mat_end) arb_mat_t B, b, y;
    arb_mat_init(B, c, c);
    arb_mat_init(b, c, 1);
    arb_mat_init(y, c, 1);
    for (int i = 0; i < c; i++) {        /* B^T y = b over the solved columns */
        for (int k = 0; k < c; k++)
            if (grad[(size_t)k * (size_t)n + (size_t)p->solved[i]])
                arb_set(arb_mat_entry(B, i, k), num_ball_value(&p->ball, grad[(size_t)k * (size_t)n + (size_t)p->solved[i]]));
        if (grad[(size_t)c * (size_t)n + (size_t)p->solved[i]])
            arb_set(arb_mat_entry(b, i, 0), num_ball_value(&p->ball, grad[(size_t)c * (size_t)n + (size_t)p->solved[i]]));
    }
    int result = arb_mat_solve(y, B, b, p->ball.prec) ? 1 : -1;
    SGA_ENDS(arb_end) arb_t r = { 0 };
    for (int j = 0; j < n && result == 1; j++) {
        expr_id g = grad[(size_t)c * (size_t)n + (size_t)j];
        if (g)
            arb_set(r, num_ball_value(&p->ball, g));
        else
            arb_zero(r);
        for (int k = 0; k < c; k++)
            if (grad[(size_t)k * (size_t)n + (size_t)j])
                arb_submul(r, arb_mat_entry(y, k, 0), num_ball_value(&p->ball, grad[(size_t)k * (size_t)n + (size_t)j]), p->ball.prec);
        if (!arb_is_finite(r) || (arb_contains_zero(r) && mag_cmp_2exp_si(arb_radref(r), -need) > 0))
            result = -1;      /* a wide ball says nothing */
        else if (!arb_contains_zero(r))
            result = 0;
    }
    return result;
}

enum { MOST_BITS = 20000 };

/* The point with so many bits that a gradient as small as its parts allow is told from 0. */
static slong with_bits(struct state *s, struct points_point *p, const expr_id *grad, int count)
{
    struct points_space space = s->space;
    space.constraint = s->con;
    space.constraints = s->sol->constraints;
    SGA_FREED expr_id *root = sga_malloc((size_t)(count + 1) * sizeof *root);
    int roots = 0;
    for (int i = 0; i < count; i++)
        if (grad[i])
            root[roots++] = grad[i];
    num_ball_extend(&p->ball);
    expr_cone_of(s->st, &s->cone, root, roots);
    slong need = points_needed_bits(&p->ball, s->cone.list, s->cone.count, points_oracle_height(s->oracle));
    if (need > MOST_BITS)
        return 0;
    if (space.constraints && !points_refine(&space, p, 2 * need))
        return 0;
    p->ball.prec = 2 * need;
    num_ball_forget(&p->ball);
    return need;
}

void state_activate(struct state *s)
{
    if (s->activated == s->st->symbols)
        return;
    SGA_RESERVE_IN(&s->mem, s->active, s->active_cap, s->st->symbols);
    memset(s->active, 0, (size_t)s->st->symbols);
    for (int j = 0; j < s->sys->variables; j++)
        s->active[s->variable[j]] = 1;
    s->activated = s->st->symbols;
}

unsigned state_facts(struct state *s, expr_id e)
{
    return expr_facts_of(s->facts, s->st, e);
}

int state_size(struct state *s, expr_id e)
{
    expr_cone_of(s->st, &s->cone, &e, 1);
    return s->cone.count;
}

bool state_locally_constant(struct state *s, expr_id e)
{
    int c = s->sol->constraints, n = s->sys->variables;
    state_activate(s);
    SGA_FREED expr_id *grad = sga_calloc((size_t)(c + 1) * (size_t)n, sizeof *grad);
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    for (int k = 0; k <= c; k++) {
        int m = expr_gradient(s->st, &s->cone, k < c ? s->con[k] : e, s->active, &term, &cap);
        for (int i = 0; i < m; i++)
            grad[(size_t)k * (size_t)n + (size_t)s->column[term[i].symbol]] = term[i].value;
    }
    bool all = s->oracle->reals > 0;
    for (int k = 0; k < s->oracle->reals && all; k++)       /* few bits first: they tell most that vary */
        all = dependent_at(s, s->oracle->real + k, grad, 60) == 1;
    for (int k = 0; k < s->oracle->reals && all; k++) {
        slong need = with_bits(s, s->oracle->real + k, grad, (c + 1) * n);
        all = need && dependent_at(s, s->oracle->real + k, grad, need) == 1;
    }
    return all;
}
