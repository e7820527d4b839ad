/* Whether some columns of the differentials are independent, proved by a singular value. */
#include "regular_columns.h"

#include "arena.h"
#include "differentials.h"
#include "least_singular.h"
#include "lin_sparse.h"
#include "lin_stairs.h"
#include "points_space.h"
#include "square.h"

bool points_columns_regular(struct points_jacobian *j, struct points_point *p, int *column)
{
    SGA_ARENA(mem);
    int c = j->space->constraints;
    struct square q = { .j = j, .p = p, .c = c, .n = j->space->variables, .unknown = column, .unknowns = c };
    q.exponent = sga_take(&mem, ((size_t)c + 1) * sizeof *q.exponent);
    for (int i = 0; i < c; i++)
        q.exponent[i] = points_row_exponent(j, i, NULL);
    struct lin_sparse *B = square_sparse(&q);
    SGA_ENDS(lin_stairs_clear) struct lin_stairs stairs = { 0 };
    double off = B ? square_spread(&q, B) * (1 + 1e-9) : 0;
    bool regular = B && square_stairs(&q, B, &stairs) && stairs.groups > 1 && num_least_singular_stairs(&stairs, j->space->budget) > off;
    regular = regular || (B && num_least_singular(B, j->space->budget) > off);
    lin_sparse_free(B);
    return regular;
}
