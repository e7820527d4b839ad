/* Ranks at a point. */
#include "drops.h"

#include <stdlib.h>

#include "lin_dense.h"
#include "mem.h"

static int rank_of(const double *a, int rows, int cols, double tolerance)
{
    struct lin_dense dense = { .rows = rows, .cols = cols, .a = a };
    int small = rows < cols ? rows : cols, rank = 0;
    double *sv = sga_calloc((size_t)small + 1, sizeof *sv);
    if (lin_singular_values(&dense, sv))
        while (rank < small && sv[rank] > tolerance * (sv[0] > 1 ? sv[0] : 1))
            rank++;
    free(sv);
    return rank;
}

/* Ranks of H and of [H, -rate] at the symbols of a ball. */
void mech_ranks_at(const struct mech_search *s, struct num_ball *ball, double tolerance, int *rank, int *augmented)
{
    int n = s->n, m = s->m;
    double *H = sga_calloc((size_t)m * (size_t)n + 1, sizeof *H), *wide = sga_calloc((size_t)m * (size_t)(n + 1) + 1, sizeof *wide);
    num_ball_extend(ball);
    for (int i = 0; i < m; i++) {
        double b = arf_get_d(arb_midref(num_ball_value(ball, s->f->rate[i])), ARF_RND_NEAR);
        for (int j = 0; j < n; j++) {
            double v = arf_get_d(arb_midref(num_ball_value(ball, mech_entry(s, i, j))), ARF_RND_NEAR);
            H[(size_t)i * (size_t)n + (size_t)j] = wide[(size_t)i * (size_t)(n + 1) + (size_t)j] = v;
        }
        wide[(size_t)i * (size_t)(n + 1) + (size_t)n] = -b;
    }
    *rank = rank_of(H, m, n, tolerance);
    *augmented = rank_of(wide, m, n + 1, tolerance);
    free(H);
    free(wide);
}

/* M and H as one matrix, for its rank at a point: full is n + m. */
int mech_whole_rank_at(const struct mech_search *s, struct num_ball *ball, double tolerance)
{
    int n = s->n, size = n + s->m;
    double *K = sga_calloc((size_t)size * (size_t)size + 1, sizeof *K);
    num_ball_extend(ball);
    for (size_t k = 0; k < s->in->masses; k++)
        K[(size_t)s->in->mass[k].row * (size_t)size + (size_t)s->in->mass[k].col]
            += arf_get_d(arb_midref(num_ball_value(ball, s->in->mass[k].value)), ARF_RND_NEAR);
    for (int i = 0; i < s->m; i++)
        for (int j = 0; j < n; j++)
            K[(size_t)(n + i) * (size_t)size + (size_t)j] = K[(size_t)j * (size_t)size + (size_t)(n + i)]
                = arf_get_d(arb_midref(num_ball_value(ball, mech_entry(s, i, j))), ARF_RND_NEAR);
    int rank = rank_of(K, size, size, tolerance);
    free(K);
    return rank;
}
