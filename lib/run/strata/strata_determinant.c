/* Zeros of the determinants of dense blocks. A small one is written out and factored where its
 * factors are short; otherwise a zero is looked for on the final set, and the stratum is described. */
#include "strata_listing.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>

#include "arena.h"
#include "expr_rows.h"
#include "run_job.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "request.h"
#include "stratum.h"
#include "warnings.h"

/* Minors of subsets: 2^r of them. A start of a search costs up to 60 r^3 operations on balls, which
 * bounds how many there are. */
enum { MOST_WRITTEN = 10, MOST_STARTS = 8, START_WORK = 8000, NAMED = 12 };

/* det S by its minors of the first rows: without divisions, so right where S is singular. */
static expr_id written_out(struct job *j, const struct sga_determinant *d)
{
    assert(d->size > 0 && d->solve < j->request->store.solves);
    struct expr_store *st = &j->request->store;
    struct poly_limits limits = poly_limits_of(POLY_MODEST, j->budget);
    int r = d->size;
    uint32_t all = (uint32_t)1 << r;
    SGA_ARENA(mem);
    expr_id *minor = sga_zeros(&mem, all, sizeof *minor), det;
    bool ok = true;
    minor[0] = expr_int(st, 1);
    for (uint32_t s = 1; s < all && ok; s++) {
        int row = __builtin_popcount(s) - 1, sign = row;
        expr_id sum = expr_int(st, 0);
        for (int k = 0; k < r; k++) {
            if (!(s >> k & 1))
                continue;
            expr_id a = expr_rows_at(&st->solve[d->solve].matrix, row, k);
            if (a == EXPR_UNDEF) {
                sign--;
                continue;
            }
            expr_id t = expr_mul(st, a, minor[s & ~((uint32_t)1 << k)]);
            sum = sign-- & 1 ? expr_sub(st, sum, t) : expr_add(st, sum, t);
        }
        minor[s] = sum;
        ok = expr_is_const(st, sum) || (poly_normal(st, sum, &limits, &minor[s]) && job_goes_on(j));
    }
    det = ok ? minor[all - 1] : EXPR_UNDEF;
    return det;
}

/* "the determinant of the 10 x 10 matrix that x1', x2', ... are solved for with" */
static char *described(const struct job *j, const struct sga_determinant *d)
{
    struct sga_buf text = { 0 };
    sga_buf_printf(&text, "the determinant of the %d x %d matrix from which the derivatives of ", d->size, d->size);
    SGA_ARENA(mem);
    unsigned char *solved = sga_zeros(&mem, (size_t)j->request->system.variables + 1, 1);
    for (int k = 0; k < d->size; k++)
        solved[d->col[k]] = 1;
    for (int i = 0, named = 0; i < j->request->system.variables && named < NAMED; i++)
        if (solved[i])
            sga_buf_printf(&text, "%s%s", named++ ? ", " : "", answer_variable_name(j, i));
    sga_buf_printf(&text, "%s are solved vanishes", d->size > NAMED ? ", ..." : "");
    return sga_buf_take(&text);
}

static const char *search(struct listing *l, const struct sga_determinant *d)
{
    struct job *j = l->j;
    struct stratum as = { .kind = "pivot" };
    expr_id det = d->size <= MOST_WRITTEN ? written_out(j, d) : EXPR_UNDEF;
    if (det) {
        strata_factors(l, det, 0);
        return "written_out";
    }
    if (d->size > SGA_MOST_DETERMINANT) {
        sga_limit_met(j->budget, SGA_LIMIT_DETERMINANT);
        return "not_searched";
    }
    int starts = START_WORK / (d->size * d->size * d->size);
    starts = starts < 1 ? 1 : starts > MOST_STARTS ? MOST_STARTS : starts;
    if (!strata_drops(j, d->value, starts, &as))
        return "none_found";
    as.description = described(j, d);
    strata_add(j, EXPR_UNDEF, -1, as);
    return "found";
}

void strata_determinants(struct listing *l)
{
    struct job *j = l->j;
    int blocks = j->solution->dense_blocks;
    j->strata.determinant = sga_calloc((size_t)blocks + 1, sizeof *j->strata.determinant);
    for (int q = 0; q < blocks; q++)
        j->strata.determinant[q] = job_goes_on(j) ? search(l, j->solution->determinant + q) : "not_searched";
}
