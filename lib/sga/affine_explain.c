/* Which rows of an affine system are combinations of other rows as they stand, velocities and right sides together.
 *
 * A row that vanishes on the set may do so for the constraints' sake; one that is a combination of rows follows from them
 * everywhere, without any derivative. */
#include "affine.h"

#include <limits.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"
#include "reduction.h"
#include "system.h"

/* Both sides beside each other. */
static void whole_row(const struct affine *a, int i, struct exact_row *out)
{
    const struct affine_row *r = a->row + i;
    exact_row_copy(&r->a, INT_MAX, out);
    for (int k = 0; k < r->b.entries; k++)
        exact_row_push(out, a->n + r->b.col[k], r->b.value + k);
}

/* scale_i (row i) * den = sum of factor * scale_q (row q): row i counts once. */
static void take(struct affine_run *r, struct sga_vanished *v, const struct exact_echelon *e, const int *row, const struct exact_combination *k)
{
    struct expr_store *st = r->s->st;
    SGA_ENDS(fmpq_end) fmpq_t f = { { 0, 1 } };
    free(v->part);
    v->part = sga_malloc(((size_t)k->count + 1) * sizeof *v->part);
    v->parts = 0;
    v->part[v->parts++] = (struct sga_part){ .row = v->source, .tangency = -1, .factor = expr_int(st, 1) };
    for (int q = 0; q < k->count; q++) {
        int of = row[e->pivot[k->pivot[q]].row];
        fmpq_set_fmpz_frac(f, k->factor + q, k->den);
        fmpq_mul(f, f, &r->a->row[of].scale);
        fmpq_div(f, f, &r->a->row[v->source].scale);
        fmpq_neg(f, f);
        v->part[v->parts++] = (struct sga_part){ .row = of, .tangency = -1, .factor = expr_fmpq(st, f) };
    }
    v->rest = expr_int(st, 0);
    v->generation = 0;
}

bool affine_explain(struct affine_run *r)
{
    struct sga_solution *sol = r->s->sol;
    int rows = r->s->sys->rows, others = 0;
    SGA_ARENA(mem);
    unsigned char *gone = sga_zeros(&mem, (size_t)rows + 1, 1);
    for (int k = 0; k < sol->vanished_rows; k++)
        if (sol->vanished[k].source < rows)
            gone[sol->vanished[k].source] = 1;
    struct exact_row *whole = sga_zeros(&mem, (size_t)rows + 1, sizeof *whole);
    const struct exact_row **list = sga_take(&mem, ((size_t)rows + 1) * sizeof *list);
    int *row = sga_take(&mem, ((size_t)rows + 1) * sizeof *row);
    for (int i = 0; i < rows; i++) {
        whole_row(r->a, i, whole + i);
        if (gone[i])
            continue;
        list[others] = whole + i;
        row[others++] = i;
    }
    SGA_ENDS(exact_echelon_clear) struct exact_echelon e;
    exact_echelon_init(&e, 2 * r->a->n + r->a->atoms, 0);
    bool ok = exact_echelon_add(&e, list, others, r->s->options->budget, r->s->err);
    for (int k = 0; k < sol->vanished_rows && ok; k++) {
        struct sga_vanished *v = sol->vanished + k;
        if (v->source >= rows)
            continue;
        SGA_ENDS(exact_combination_clear) struct exact_combination c;
        enum exact_found found = exact_combine(&e, whole + v->source, true, &c, r->s->options->budget, r->s->err);
        if (found == EXACT_YES)
            take(r, v, &e, row, &c);
        ok = found != EXACT_STOPPED;
    }
    for (int i = 0; i < rows; i++)
        exact_row_clear(whole + i);
    return ok;
}
