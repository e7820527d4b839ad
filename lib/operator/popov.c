/* Row reduction over k[D]. */
#include "popov.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"

bool op_within(const struct op_limits *l, const struct ore_matrix *m, struct sga_error *err)
{
    size_t most = l->max_bytes ? l->max_bytes : (size_t)100 << 20, size = m ? ore_matrix_size(m) : 0;
    if (size > most)
        return sga_fail(err, SGA_E_LIMIT_MEMORY, "an operator matrix grew to %zu MB; the limit is %zu MB", size >> 20, most >> 20);
    return !l->budget || sga_budget_ok(l->budget, err);
}

/* The last column of largest order in row i; -1 for a zero row. */
static int find_pivot(const struct ore_matrix *m, int i)
{
    int at = -1, order = -1;
    for (int j = 0; j < m->cols; j++)
        if (ore_order(ore_at(m, i, j)) >= order && !ore_is_zero(ore_at(m, i, j))) {
            order = ore_order(ore_at(m, i, j));
            at = j;
        }
    return at;
}

/* c = lcm of the denominators / gcd of the numerators of a row; false for a zero row */
static bool row_content(fmpz_poly_q_t c, const struct ore_matrix *m, int i)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t g = { 0 }, l = { 0 };
    fmpz_poly_one(l);
    for (int j = 0; j < m->cols; j++) {
        const struct ore *x = ore_at(m, i, j);
        for (int k = 0; k < x->len; k++) {
            if (fmpz_poly_q_is_zero(x->a + k))
                continue;
            if (!fmpz_poly_is_one(g))
                fmpz_poly_gcd(g, g, fmpz_poly_q_numref(x->a + k));
            if (!fmpz_poly_is_one(fmpz_poly_q_denref(x->a + k)))
                fmpz_poly_lcm(l, l, fmpz_poly_q_denref(x->a + k));
        }
    }
    bool any = !fmpz_poly_is_zero(g);
    if (any) {
        fmpz_poly_set(fmpz_poly_q_numref(c), l);
        fmpz_poly_set(fmpz_poly_q_denref(c), g);
        fmpz_poly_q_canonicalise(c);
    }
    return any;
}

static void scale(struct op_popov *p, int i, const fmpz_poly_q_t c)
{
    if (fmpz_poly_q_is_one(c))
        return;
    ore_matrix_scale_row(&p->R, i, c);
    ore_matrix_scale_row(&p->U, i, c);
    if (p->inverse.cols) {
        SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t d;
        fmpz_poly_q_init(d);
        fmpz_poly_q_inv(d, c);
        ore_matrix_scale_col(&p->inverse, i, d);
    }
}

static void make_primitive(struct op_popov *p, int i)
{
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t c;
    fmpz_poly_q_init(c);
    if (row_content(c, &p->R, i))
        scale(p, i, c);
}

/* row i += q row j throughout */
static void add_row(struct op_popov *p, int i, const struct ore *q, int j)
{
    ore_matrix_add_row(&p->R, i, q, j);
    ore_matrix_add_row(&p->U, i, q, j);
    if (p->inverse.cols)
        ore_matrix_sub_col(&p->inverse, j, q, i);
}

/* Takes the leading term of entry (i, col) away with row j, whose entry there has a lower or
 * the same order: row i = b/g row i - a/g D^k row j with the two leading coefficients a, b. */
static void eliminate(struct op_popov *p, int i, int j, int col)
{
    const struct ore *x = ore_at(&p->R, i, col), *y = ore_at(&p->R, j, col);
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t ratio, b;
    SGA_ENDS(ore_clear) struct ore q;
    ore_init(&q);
    fmpz_poly_q_init(ratio);
    fmpz_poly_q_init(b);
    fmpz_poly_q_div(ratio, ore_leading(x), ore_leading(y));
    fmpz_poly_set(fmpz_poly_q_numref(b), fmpz_poly_q_denref(ratio));
    fmpz_poly_one(fmpz_poly_q_denref(b));
    scale(p, i, b);
    fmpz_poly_one(fmpz_poly_q_denref(ratio));
    fmpz_poly_q_neg(ratio, ratio);
    ore_add_term(&q, ratio, ore_order(ore_at(&p->R, i, col)) - ore_order(y));
    add_row(p, i, &q, j);
    make_primitive(p, i);
}

/* Two rows with the same pivot column: the one of larger order (larger size) first. */
static bool find_pair(const struct ore_matrix *m, const int *pivot, int *high, int *low)
{
    for (int i = 0; i < m->rows; i++)
        for (int j = 0; j < i; j++) {
            if (pivot[i] < 0 || pivot[i] != pivot[j])
                continue;
            const struct ore *x = ore_at(m, i, pivot[i]), *y = ore_at(m, j, pivot[j]);
            bool swap = ore_order(x) != ore_order(y) ? ore_order(x) < ore_order(y) : ore_size(x) < ore_size(y);
            *high = swap ? j : i;
            *low = swap ? i : j;
            return true;
        }
    return false;
}

/* Rows by pivot column, zero rows last. */
static void sort_rows(struct op_popov *p, int *pivot)
{
    int n = p->R.rows, done = 0;
    for (int col = 0; col < p->R.cols; col++)
        for (int i = done; i < n; i++)
            if (pivot[i] == col) {
                int keep = pivot[i];
                pivot[i] = pivot[done];
                pivot[done] = keep;
                ore_matrix_swap_rows(&p->R, i, done);
                ore_matrix_swap_rows(&p->U, i, done);
                if (p->inverse.cols)
                    ore_matrix_swap_cols(&p->inverse, i, done);
                done++;
                break;
            }
    p->rank = done;
}

bool op_popov_weak(struct op_popov *p, const struct ore_matrix *P, bool inverse,
                   const struct op_limits *limits, struct sga_error *err)
{
    int n = P->rows, high, low;
    *p = (struct op_popov){ 0 };
    ore_matrix_set(&p->R, P);
    ore_matrix_identity(&p->U, n);
    if (inverse)
        ore_matrix_identity(&p->inverse, n);
    p->pivot = sga_calloc((size_t)n + 1, sizeof *p->pivot);
    p->order = sga_calloc((size_t)n + 1, sizeof *p->order);
    for (int i = 0; i < n; i++) {
        make_primitive(p, i);
        p->pivot[i] = find_pivot(&p->R, i);
    }
    while (find_pair(&p->R, p->pivot, &high, &low)) {
        eliminate(p, high, low, p->pivot[high]);
        p->pivot[high] = find_pivot(&p->R, high);
        if (!op_within(limits, &p->R, err) || !op_within(limits, inverse ? &p->inverse : &p->U, err)) {
            op_popov_clear(p);
            return false;
        }
    }
    sort_rows(p, p->pivot);
    for (int i = 0; i < p->rank; i++)
        p->order[i] = ore_order(ore_at(&p->R, i, p->pivot[i]));
    return true;
}

void op_popov_copy(struct op_popov *p, const struct op_popov *from)
{
    size_t n = (size_t)from->R.rows + 1;
    *p = (struct op_popov){ .rank = from->rank };
    ore_matrix_set(&p->R, &from->R);
    ore_matrix_set(&p->U, &from->U);
    p->pivot = memcpy(sga_malloc(n * sizeof *p->pivot), from->pivot, n * sizeof *p->pivot);
    p->order = memcpy(sga_malloc(n * sizeof *p->order), from->order, n * sizeof *p->order);
}

/* The row whose pivot column holds the entry of row i that exceeds the pivot's order most. */
static int worst(const struct op_popov *p, int i)
{
    int at = -1, most = -1;
    for (int k = 0; k < p->rank; k++) {
        int excess = k == i ? -1 : ore_order(ore_at(&p->R, i, p->pivot[k])) - p->order[k];
        if (excess > most) {
            most = excess;
            at = k;
        }
    }
    return at;
}

bool op_popov_finish(struct op_popov *p, const struct op_limits *limits, struct sga_error *err)
{
    assert(p->rank <= p->R.rows);
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t c;
    bool ok = true;
    for (int i = 0; i < p->rank && ok; i++)
        for (int k; ok && (k = worst(p, i)) >= 0; ok = op_within(limits, &p->R, err) && op_within(limits, &p->U, err))
            eliminate(p, i, k, p->pivot[k]);
    fmpz_poly_q_init(c);
    for (int i = 0; i < p->rank && ok; i++) {
        fmpz_poly_q_inv(c, ore_leading(ore_at(&p->R, i, p->pivot[i])));
        scale(p, i, c);
    }
    if (!ok)
        op_popov_clear(p);
    return ok;
}

void op_popov_reduce(const struct op_popov *p, struct ore *a, struct ore *q)
{
    SGA_ENDS(ore_clear) struct ore term;
    ore_init(&term);
    for (int i = 0; i < p->rank; i++)
        ore_zero(q + i);
    for (;;) {
        int at = -1, most = -1;
        for (int i = 0; i < p->rank; i++)
            if (ore_order(a + p->pivot[i]) - p->order[i] > most) {
                most = ore_order(a + p->pivot[i]) - p->order[i];
                at = i;
            }
        if (at < 0)
            break;
        ore_zero(&term);
        ore_add_term(&term, ore_leading(a + p->pivot[at]), most);    /* pivots are monic */
        ore_add(q + at, q + at, &term);
        for (int j = 0; j < p->R.cols; j++)
            ore_submul(a + j, &term, ore_at(&p->R, at, j));
    }
}

void op_popov_clear(struct op_popov *p)
{
    ore_matrix_clear(&p->R);
    ore_matrix_clear(&p->U);
    ore_matrix_clear(&p->inverse);
    free(p->pivot);
    free(p->order);
    *p = (struct op_popov){ 0 };
}
