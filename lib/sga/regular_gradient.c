/* Irregular constraints with a definite second derivative across their zeros. */
#include "regular.h"

#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "ball.h"
#include "derive.h"
#include "mem.h"
#include "system.h"

/* Symmetric elimination of H (n x n) with diagonal pivots: the indices of the pivots, in
 * picked; 0 where H is not semidefinite to about 1e-3 of its largest entry. */
static int definite_part(double *H, int n, int *picked)
{
    double scale = 0;
    int rank = 0, sign = 0;
    SGA_FREED unsigned char *used = sga_calloc((size_t)n, 1);
    for (int i = 0; i < n * n; i++)
        scale = fmax(scale, fabs(H[i]));
    bool ok = isfinite(scale) && scale > 0;
    while (ok) {
        int p = -1;
        double off = 0;
        for (int i = 0; i < n; i++) {
            if (used[i])
                continue;
            if (p < 0 || fabs(H[i * n + i]) > fabs(H[p * n + p]))
                p = i;
            for (int j = 0; j < i; j++)
                if (!used[j])
                    off = fmax(off, fabs(H[i * n + j]));
        }
        if (p < 0 || fabs(H[p * n + p]) < 1e-3 * scale) {
            ok = off < 1e-3 * scale;
            break;
        }
        int here = H[p * n + p] > 0 ? 1 : -1;
        ok = !sign || sign == here;
        sign = here;
        used[p] = 1;
        picked[rank++] = p;
        for (int i = 0; i < n && ok; i++)
            for (int j = 0; j < n; j++)
                if (!used[i] && !used[j])
                    H[i * n + j] -= H[i * n + p] * H[p * n + j] / H[p * n + p];
    }
    return ok ? rank : 0;
}

/* In natural sizes: what is small beside the others must not be a matter of units. */
static double second_derivative(const struct state *s, struct num_ball *b, expr_id node, int i, int k)
{
    const int *scale = s->sol->scale;
    double v = arf_get_d(arb_midref(num_ball_value(b, node)), ARF_RND_NEAR);
    return scale ? ldexp(v, scale[i] + scale[k]) : v;
}

int regular_by_gradient(struct state *s, expr_id e, const double *x, double t, expr_id **out)
{
    int n = s->sys->variables, rank = 0;
    *out = NULL;
    if (n > 60)
        return 0;
    state_activate(s);
    SGA_FREED struct expr_term *first = NULL, *second = NULL;
    size_t cap1 = 0, cap2 = 0;
    int count = expr_gradient(s->st, &s->cone, e, s->active, &first, &cap1);
    SGA_ARENA(mem);
    expr_id *node = sga_zeros(&mem, (size_t)n * (size_t)n, sizeof *node);
    for (int i = 0; i < count; i++) {
        int row = s->column[first[i].symbol];
        int m = expr_gradient(s->st, &s->cone, first[i].value, s->active, &second, &cap2);
        for (int k = 0; k < m; k++)
            node[row * n + s->column[second[k].symbol]] = second[k].value;
    }
    SGA_ENDS(num_ball_clear) struct num_ball b;
    num_ball_init(&b, s->st, 64);
    for (int i = 0; i < s->sys->parameters; i++)
        num_ball_set_d(&b, s->parameter_symbol[i], 1.25);
    for (int j = 0; j < n; j++)
        num_ball_set_d(&b, s->variable[j], x[j]);
    num_ball_set_d(&b, s->sys->time, t);
    num_ball_extend(&b);
    double *H = sga_zeros(&mem, (size_t)n * (size_t)n, sizeof *H);
    int *picked = sga_take(&mem, (size_t)n * sizeof *picked);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            if (node[i * n + k])
                H[i * n + k] = second_derivative(s, &b, node[i * n + k], i, k);
    rank = definite_part(H, n, picked);
    if (rank) {
        *out = sga_calloc((size_t)rank, sizeof **out);
        for (int i = 0; i < rank; i++)
            for (int k = 0; k < count; k++)
                if (s->column[first[k].symbol] == picked[i])
                    (*out)[i] = first[k].value;
    }
    return rank;
}
