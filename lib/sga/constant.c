/* Functions that do not vary along the present constraint set. */
#include "state.h"

#include <stdlib.h>
#include <string.h>

#include <arb_mat.h>

#include "mem.h"

/* Whether d_x e lies in the span of the constraints' differentials at point p:
 * 1 yes (every residue's ball contains 0), 0 no, -1 no value. */
static int dependent_at(struct state *s, struct points_point *p, const expr_id *grad)
{
    int c = s->sol->constraints, n = s->sys->variables;
    num_ball_extend(&p->ball);
    arb_mat_t B, b, y;
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
    arb_t r;
    arb_init(r);
    for (int j = 0; j < n && result == 1; j++) {
        expr_id g = grad[(size_t)c * (size_t)n + (size_t)j];
        if (g)
            arb_set(r, num_ball_value(&p->ball, g));
        else
            arb_zero(r);
        for (int k = 0; k < c; k++)
            if (grad[(size_t)k * (size_t)n + (size_t)j])
                arb_submul(r, arb_mat_entry(y, k, 0), num_ball_value(&p->ball, grad[(size_t)k * (size_t)n + (size_t)j]), p->ball.prec);
        if (!arb_is_finite(r) || (arb_contains_zero(r) && mag_cmp_2exp_si(arb_radref(r), -60) > 0))
            result = -1;      /* a wide ball says nothing */
        else if (!arb_contains_zero(r))
            result = 0;
    }
    arb_clear(r);
    arb_mat_clear(B);
    arb_mat_clear(b);
    arb_mat_clear(y);
    return result;
}

bool state_locally_constant(struct state *s, expr_id e)
{
    int c = s->sol->constraints, n = s->sys->variables;
    SGA_RESERVE(s->active, s->active_cap, s->st->symbols);
    memset(s->active, 0, (size_t)s->st->symbols);
    for (int j = 0; j < n; j++)
        s->active[s->variable[j]] = 1;
    expr_id *grad = sga_calloc((size_t)(c + 1) * (size_t)n, sizeof *grad);
    struct expr_term *term = NULL;
    size_t cap = 0;
    for (int k = 0; k <= c; k++) {
        int m = expr_gradient(s->st, &s->cone, k < c ? s->con[k] : e, s->active, &term, &cap);
        for (int i = 0; i < m; i++)
            grad[(size_t)k * (size_t)n + (size_t)s->column[term[i].symbol]] = term[i].value;
    }
    free(term);
    bool all = s->shadow->reals > 0;
    for (int k = 0; k < s->shadow->reals && all; k++)
        all = dependent_at(s, s->shadow->real + k, grad) == 1;
    free(grad);
    return all;
}
