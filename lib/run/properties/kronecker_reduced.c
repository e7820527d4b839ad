/* Infinite blocks from the dimensions of generations; see the header. */
#include "kronecker_reduced.h"

#include <assert.h>
#include <flint/fmpq.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "exact_rank.h"
#include "flint_ends.h"
#include "mem.h"
#include "pencil.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "system.h"

static bool exact_and_whole(const struct job *j)
{
    const struct sga_solution *sol = j->solution;
    return sol->exact && !j->request->system.restrictions && sol->verdict != SGA_INCONSISTENT;
}

/* An entry of (A | B) in a row, or of (A | B)^T in a column. */
struct place {
    int row, col;
    const fmpq *value;
};

static int by_place(const void *x, const void *y)
{
    const struct place *a = x, *b = y;
    return a->row != b->row ? (a->row < b->row ? -1 : 1) : (a->col > b->col) - (a->col < b->col);
}

static struct place *places_of(const struct pencil *p, bool transposed, struct sga_arena *mem, int *count)
{
    struct place *at = sga_take(mem, ((size_t)(p->A.entries + p->B.entries) + 1) * sizeof *at);
    *count = 0;
    for (int which = 0; which < 2; which++) {
        const struct pencil_matrix *m = which ? &p->B : &p->A;
        int shift = which ? (transposed ? p->rows : p->cols) : 0;
        for (int i = 0; i < m->entries; i++) {
            const struct pencil_entry *e = m->entry + i;
            at[(*count)++] = (struct place){ transposed ? e->col : e->row, (transposed ? e->row : e->col) + shift, &e->value };
        }
    }
    qsort(at, (size_t)*count, sizeof *at, by_place);
    return at;
}

/* The entries at[0 .. n) of one row times a common denominator; equal places add up. */
static void integral_row(const struct place *at, int n, struct exact_row *to)
{
    SGA_ENDS(fmpz_end) fmpz_t den = { 1 };
    SGA_ENDS(fmpz_end) fmpz_t v = { 0 };
    SGA_ENDS(fmpq_end) fmpq_t sum = { { 0, 1 } };
    for (int i = 0; i < n; i++)
        fmpz_lcm(den, den, fmpq_denref(at[i].value));
    for (int i = 0; i < n; i++) {
        fmpq_add(sum, sum, at[i].value);
        if (i + 1 < n && at[i + 1].col == at[i].col)
            continue;
        fmpq_mul_fmpz(sum, sum, den);
        fmpz_set(v, fmpq_numref(sum));
        exact_row_push(to, at[i].col, v);
        fmpq_zero(sum);
    }
}

/* Whether as many rows of (A | B), or of its transpose, depend on the others. */
static bool dependent_rows(const struct job *j, const struct pencil *p, bool transposed, int wanted)
{
    int rows = transposed ? p->cols : p->rows, cols = 2 * (transposed ? p->rows : p->cols), count, from = 0;
    SGA_ARENA(mem);
    const struct place *at = places_of(p, transposed, &mem, &count);
    struct exact_row *row = sga_zeros(&mem, (size_t)rows + 1, sizeof *row);
    const struct exact_row **list = sga_take(&mem, ((size_t)rows + 1) * sizeof *list);
    for (int i = 0; i < rows; i++) {
        int end = from;
        while (end < count && at[end].row == i)
            end++;
        integral_row(at + from, end - from, row + i);
        list[i] = row + i;
        from = end;
    }
    SGA_ENDS(exact_echelon_clear) struct exact_echelon e;
    exact_echelon_init(&e, cols, 0);
    struct sga_error err = { 0 };
    bool same = exact_echelon_add(&e, list, rows, j->budget, &err) && rows - e.pivots == wanted;
    for (int i = 0; i < rows && same; i++) {
        if (e.pivot_of_row[i] >= 0)
            continue;
        struct exact_combination c;
        same = exact_combine(&e, row + i, true, &c, j->budget, &err) == EXACT_YES;
        exact_combination_clear(&c);
    }
    for (int i = 0; i < rows; i++)
        exact_row_clear(row + i);
    return same;
}

static int *zeros_of(int count)
{
    return sga_calloc((size_t)count + 1, sizeof(int));
}

bool kronecker_reduced(const struct job *j, const struct pencil *p, struct pencil_structure *out)
{
    const struct sga_solution *sol = j->solution;
    const struct sys_system *sys = &j->request->system;
    int rights = sol->free_columns, rank = p->cols - rights, lefts = p->rows - rank, sum = 0;
    *out = (struct pencil_structure){ .basis = PENCIL_PROVED, .no_spectrum = true };
    if (!exact_and_whole(j) || p->rows != sys->rows || p->cols != sys->variables || lefts < 0)
        return false;
    if ((rights && !dependent_rows(j, p, true, rights)) || (lefts && !dependent_rows(j, p, false, lefts)))
        return false;
    int before = p->cols;
    for (int k = 0; k < sol->generations; k++) {
        int blocks = before - sol->dimension[k];
        if (!k) {
            out->infinites = blocks;
            out->infinite = zeros_of(blocks);
        }
        for (int i = 0; i < blocks && i < out->infinites; i++)
            out->infinite[i] = k + 1;
        sum += blocks;
        before = sol->dimension[k];
    }
    out->regular = !rights && !lefts;
    out->normal_rank = rank;
    out->finite = rank - sum;
    out->nilpotency = out->infinites ? out->infinite[0] : 0;
    out->rights = rights;
    out->right = zeros_of(rights);
    out->lefts = lefts;
    out->left = zeros_of(lefts);
    assert(out->finite >= 0 && pencil_structure_sane(p, out));
    return true;
}

static bool same_list(const int *a, int count, const int *b, int other)
{
    return count == other && memcmp(a, b, (size_t)count * sizeof *a) == 0;
}

bool kronecker_shown(const struct job *j, const struct pencil *p, const struct pencil_structure *s)
{
    struct pencil_structure r;
    bool same = kronecker_reduced(j, p, &r) && r.normal_rank == s->normal_rank && r.finite == s->finite
                && same_list(r.infinite, r.infinites, s->infinite, s->infinites) && same_list(r.right, r.rights, s->right, s->rights)
                && same_list(r.left, r.lefts, s->left, s->lefts);
    pencil_structure_clear(&r);
    return same;
}
