/* The rank of a wide matrix is never less than that of its part, whatever the size of its last column. */
#include <math.h>

#include "ball.h"
#include "check.h"
#include "drops.h"

enum { N = 2, M = 2 };

static void ranks_of(const long *H, long small, const long *rate, int *rank, int *augmented)
{
    struct expr_store st;
    struct mech_fibre f = { 0 };
    expr_id entry[M * N], right[M];
    expr_store_init(&st);
    for (int k = 0; k < M * N; k++)
        entry[k] = expr_rational(&st, H[k], k == M * N - 1 ? small : 1);
    for (int i = 0; i < M; i++)
        right[i] = expr_int(&st, rate[i]);
    f.H = entry;
    f.rate = right;
    struct mech_search s = { .f = &f, .st = &st, .n = N, .m = M };
    struct num_ball ball;
    num_ball_init(&ball, &st, 64);
    mech_ranks_at(&s, &ball, 1e-8, rank, augmented);
    num_ball_clear(&ball);
    expr_store_clear(&st);
}

int main(void)
{
    static const struct { long H[M * N], small, rate[M]; int rank, augmented; } list[] = {
        { { 1, 0, 0, 1 }, 1, { 1, 1 }, 2, 2 },
        { { 1, 0, 0, 1 }, 10000, { 1000000, 0 }, 2, 2 },         /* rates of another size than H, which lost the small row */
        { { 1, 0, 0, 0 }, 1, { 0, 1000000000 }, 1, 2 },
        { { 1, 0, 0, 0 }, 1, { 1000000000, 0 }, 1, 1 },
        { { 0, 0, 0, 0 }, 1, { 3, 4 }, 0, 1 },
        { { 0, 0, 0, 0 }, 1, { 0, 0 }, 0, 0 },
    };
    for (size_t k = 0; k < sizeof list / sizeof *list; k++) {
        int rank, augmented;
        ranks_of(list[k].H, list[k].small, list[k].rate, &rank, &augmented);
        CHECK(rank == list[k].rank && augmented == list[k].augmented, "%zu: %d, %d", k, rank, augmented);
    }
    return CHECK_END();
}
