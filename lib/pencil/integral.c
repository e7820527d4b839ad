/* Scaling of rows and columns by their contents. The content of rational numbers is the
 * gcd of their numerators over the lcm of their denominators; divided by it they are coprime
 * integers. So 1e150 and 1e-150 cost nothing where they are only a choice of units. */
#include "integral.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"

struct loose {
    int row, col;
    bool b;
    fmpq value;
};

static int by_place(const void *x, const void *y)
{
    const struct loose *a = x, *b = y;
    if (a->row != b->row)
        return a->row < b->row ? -1 : 1;
    if (a->col != b->col)
        return a->col < b->col ? -1 : 1;
    return a->b - b->b;
}

/* One list, sorted, equal places added up, zeros dropped. */
static int gather(const struct pencil *p, struct loose *out)
{
    int n = 0, kept = 0;
    for (int which = 0; which < 2; which++) {
        const struct pencil_matrix *m = which ? &p->B : &p->A;
        for (int i = 0; i < m->entries; i++, n++) {
            out[n] = (struct loose){ m->entry[i].row, m->entry[i].col, which != 0, { 0, 0 } };
            fmpq_init(&out[n].value);
            fmpq_set(&out[n].value, &m->entry[i].value);
        }
    }
    if (n)
        qsort(out, (size_t)n, sizeof *out, by_place);
    for (int i = 0; i < n; i++) {
        if (kept && by_place(out + kept - 1, out + i) == 0) {
            fmpq_add(&out[kept - 1].value, &out[kept - 1].value, &out[i].value);
            fmpq_clear(&out[i].value);
            continue;
        }
        if (kept && fmpq_is_zero(&out[kept - 1].value))
            fmpq_clear(&out[--kept].value);
        out[kept++] = out[i];
    }
    if (kept && fmpq_is_zero(&out[kept - 1].value))
        fmpq_clear(&out[--kept].value);
    assert(kept <= n);
    return kept;
}

/* Divides each column (or row) by its content. True where something changed. */
static bool scale(struct loose *e, int entries, int lines, bool columns)
{
    SGA_FREED fmpq *content = sga_calloc((size_t)lines + 1, sizeof *content);
    bool changed = false;
    for (int i = 0; i < lines; i++)
        fmpq_init(content + i);
    for (int i = 0; i < entries; i++) {
        fmpq *c = content + (columns ? e[i].col : e[i].row);
        if (fmpq_is_zero(c)) {
            fmpq_abs(c, &e[i].value);
            continue;
        }
        fmpz_gcd(fmpq_numref(c), fmpq_numref(c), fmpq_numref(&e[i].value));
        fmpz_lcm(fmpq_denref(c), fmpq_denref(c), fmpq_denref(&e[i].value));
    }
    for (int i = 0; i < entries; i++) {
        fmpq *c = content + (columns ? e[i].col : e[i].row);
        if (fmpq_is_one(c))
            continue;
        changed = true;
        fmpq_div(&e[i].value, &e[i].value, c);
    }
    for (int i = 0; i < lines; i++)
        fmpq_clear(content + i);
    return changed;
}

/* log2 of an integer > 0, rounded upwards a little */
static double log2_of(const fmpz_t n)
{
    slong e;
    double d = fmpz_get_d_2exp(&e, n);
    return (log2(d) + (double)e) * (1 + 1e-12) + 1e-9;
}

static void bound(struct integral *p)
{
    SGA_ENDS(fmpz_end) fmpz_t apart = { 0 }, joint = { 0 }, sum = { 0 };
    p->apart = p->joint = 0;
    for (int i = 0; i < p->entries; ) {
        int row = p->entry[i].row;
        fmpz_zero(apart);
        fmpz_zero(joint);
        while (i < p->entries && p->entry[i].row == row) {
            int col = p->entry[i].col;
            fmpz_zero(sum);
            for (; i < p->entries && p->entry[i].row == row && p->entry[i].col == col; i++) {
                fmpz_addmul(apart, &p->entry[i].value, &p->entry[i].value);
                if (fmpz_sgn(&p->entry[i].value) > 0)
                    fmpz_add(sum, sum, &p->entry[i].value);
                else
                    fmpz_sub(sum, sum, &p->entry[i].value);
            }
            fmpz_addmul(joint, sum, sum);
        }
        p->apart += 0.5 * log2_of(apart);
        p->joint += 0.5 * log2_of(joint);
    }
}

void integral_init(struct integral *p, const struct pencil *given)
{
    SGA_FREED struct loose *e = sga_calloc((size_t)given->A.entries + (size_t)given->B.entries + 1, sizeof *e);
    int n = gather(given, e);
    for (int pass = 0; pass < 6; pass++) {
        bool columns = scale(e, n, given->cols, true);
        if (!scale(e, n, given->rows, false) && !columns)
            break;
    }
    *p = (struct integral){ .rows = given->rows, .cols = given->cols, .entries = n };
    p->entry = sga_calloc((size_t)n + 1, sizeof *p->entry);
    for (int i = 0; i < n; i++) {
        p->entry[i] = (struct integral_entry){ e[i].row, e[i].col, e[i].b, 0 };
        fmpz_init(&p->entry[i].value);
        fmpz_set(&p->entry[i].value, fmpq_numref(&e[i].value));   /* the rows came last: integers */
        fmpq_clear(&e[i].value);
    }
    bound(p);
}

void integral_clear(struct integral *p)
{
    for (int i = 0; i < p->entries; i++)
        fmpz_clear(&p->entry[i].value);
    free(p->entry);
    *p = (struct integral){ 0 };
}
