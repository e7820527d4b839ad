/* Ranks at a point. */
#include "ball.h"
#include "drops.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "form.h"
#include "lin_rank.h"
#include "mem.h"

/* Singular values above the tolerance times the largest or 1; *least: what that was (0 on entry), or is taken to be. */
static int rank_of(const double *a, int rows, int cols, double tolerance, double *least)
{
    struct lin_dense dense = { .rows = rows, .cols = cols, .a = a };
    int rank;
    lin_rank(&dense, tolerance, 1, least, &rank);
    return rank;
}

/* The last column of a wide matrix shrinks to the size of the others, if it is larger: ranks stay. */
static void shrink_last(double *wide, int rows, int cols)
{
    double most = 1, last = 0;
    for (int k = 0; k < rows * cols; k++)
        if (k % cols == cols - 1)
            last = fmax(last, fabs(wide[k]));
        else
            most = fmax(most, fabs(wide[k]));
    for (int i = 0; i < rows && last > most; i++)
        wide[i * cols + cols - 1] *= most / last;
}

/* Ranks of H and of [H, -rate] at the symbols of a ball. */
void mech_ranks_at(const struct mech_search *s, struct num_ball *ball, double tolerance, int *rank, int *augmented)
{
    int n = s->n, m = s->m;
    SGA_ARENA(mem);
    double *H = sga_zeros(&mem, (size_t)m * (size_t)n + 1, sizeof *H);
    double *wide = sga_zeros(&mem, (size_t)m * (size_t)(n + 1) + 1, sizeof *wide);
    num_ball_extend(ball);
    for (int i = 0; i < m; i++) {
        double b = arf_get_d(arb_midref(num_ball_value(ball, s->f->rate[i])), ARF_RND_NEAR);
        for (int j = 0; j < n; j++) {
            double v = arf_get_d(arb_midref(num_ball_value(ball, mech_entry(s, i, j))), ARF_RND_NEAR);
            H[(size_t)i * (size_t)n + (size_t)j] = wide[(size_t)i * (size_t)(n + 1) + (size_t)j] = v;
        }
        wide[(size_t)i * (size_t)(n + 1) + (size_t)n] = -b;
    }
    double least = 0;
    shrink_last(wide, m, n + 1);
    *rank = rank_of(H, m, n, tolerance, &least);
    *augmented = rank_of(wide, m, n + 1, tolerance, &least);      /* values interlace: it is no less above the same bound */
    if (*augmented < *rank)        /* but for roundings at the bound itself */
        *augmented = *rank;
    assert(*augmented <= n + 1);
}

/* M and H as one matrix, for its rank at a point: full is n + m. */
int mech_whole_rank_at(const struct mech_search *s, struct num_ball *ball, double tolerance)
{
    assert(tolerance > 0);
    int n = s->n, size = n + s->m;
    SGA_FREED double *K = sga_calloc((size_t)size * (size_t)size + 1, sizeof *K);
    num_ball_extend(ball);
    for (size_t k = 0; k < s->in->masses; k++)
        K[(size_t)s->in->mass[k].row * (size_t)size + (size_t)s->in->mass[k].col]
            += arf_get_d(arb_midref(num_ball_value(ball, s->in->mass[k].value)), ARF_RND_NEAR);
    for (int i = 0; i < s->m; i++)
        for (int j = 0; j < n; j++)
            K[(size_t)(n + i) * (size_t)size + (size_t)j] = K[(size_t)j * (size_t)size + (size_t)(n + i)]
                = arf_get_d(arb_midref(num_ball_value(ball, mech_entry(s, i, j))), ARF_RND_NEAR);
    double least = 0;
    return rank_of(K, size, size, tolerance, &least);
}
