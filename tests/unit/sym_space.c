/* Row spaces modulo a prime: kernels against multiplication, reduction against membership. */
#include "sym_work.h"

#include <string.h>

#include "check.h"
#include "points.h"
#include "points_random.h"

enum { MOST = 12 };

static mp_limb_t dot(const mp_limb_t *a, const mp_limb_t *b, int n, nmod_t mod)
{
    mp_limb_t sum = 0;
    for (int j = 0; j < n; j++)
        sum = nmod_add(sum, nmod_mul(a[j], b[j], mod), mod);
    return sum;
}

/* Sparse rows, some of them sums of earlier ones. */
static int make(mp_limb_t (*row)[MOST], int rows, int cols, nmod_t mod, uint64_t *random)
{
    int independent = 0;
    memset(row, 0, (size_t)rows * sizeof *row);
    for (int i = 0; i < rows; i++) {
        if (independent < cols / 2 && i % 2 == 0) {
            row[i][independent] = 1 + points_random(random) % 5;      /* a staircase: the rank is known */
            for (int j = independent + 1; j < cols; j++)
                row[i][j] = points_random(random) % 3 ? 0 : points_random(random) % mod.n;
            independent++;
        } else {
            for (int k = 0; k < i; k++) {
                mp_limb_t f = points_random(random) % mod.n;
                for (int j = 0; j < cols; j++)
                    row[i][j] = nmod_add(row[i][j], nmod_mul(f, row[k][j], mod), mod);
            }
        }
    }
    return independent;
}

static void one(int rows, int cols, nmod_t mod, uint64_t *random)
{
    mp_limb_t row[MOST][MOST], v[MOST];
    struct sym_space s, kernel;
    int rank = make(row, rows, cols, mod, random), added = 0, zero = 1;
    sym_space_init(&s, cols, mod);
    for (int i = 0; i < rows; i++) {
        memcpy(v, row[i], sizeof v);
        added += sym_space_insert(&s, v);
    }
    CHECK(s.rank == rank && added == rank, "%d, %d, should be %d", s.rank, added, rank);
    sym_space_finish(&s);
    sym_space_kernel(&s, &kernel);
    CHECK(kernel.rank == cols - rank, "%d of %d", kernel.rank, cols);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < cols; j++)
            if (kernel.row[j])
                zero &= dot(row[i], kernel.row[j], cols, mod) == 0;
    CHECK(zero, "the kernel is annihilated");
    for (int i = 0; i < rows; i++) {
        memcpy(v, row[i], sizeof v);
        sym_space_reduce(&s, v);
        zero = 1;
        for (int j = 0; j < cols; j++)
            zero &= v[j] == 0;
        CHECK(zero, "row %d lies in the space", i);
    }
    sym_space_clear(&s);
    sym_space_clear(&kernel);
}

int main(void)
{
    nmod_t mod;
    uint64_t random = check_seed(20260811);
    nmod_init(&mod, 1152921504606847009ul);
    for (int k = check_scale(60); k > 0; k--)
        one(1 + (int)(points_random(&random) % MOST), 1 + (int)(points_random(&random) % MOST), mod, &random);
    return CHECK_END();
}
