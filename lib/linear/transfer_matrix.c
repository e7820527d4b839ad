/* Elimination over Q(s). */
#include "transfer_matrix.h"

#include <arb_poly.h>
#include <assert.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "buf.h"
#include "flint_ends.h"
#include "mem.h"

/* The least common multiple of the denominators of row `row` of a matrix, into m; NULL is nothing. */
static void common(fmpz_t m, const struct linear_matrix *a, int row)
{
    for (int k = 0; a && k < linear_cols(a); k++)
        fmpz_lcm(m, m, fmpq_denref(fmpq_mat_entry(a->q, row, k)));
}

/* The whole number m a(row, col). */
static void whole(fmpz_t out, const fmpz_t m, const struct linear_matrix *a, int row, int col)
{
    const fmpq *q = fmpq_mat_entry(a->q, row, col);
    fmpz_divexact(out, m, fmpq_denref(q));
    fmpz_mul(out, out, fmpq_numref(q));
}

/* [s E - A | B - s F], rows in whole numbers. */
static void system_matrix(fmpz_poly_mat_t M, const struct transfer_equations *e)
{
    int rows = linear_rows(e->A), n = linear_cols(e->A), inputs = linear_cols(e->B);
    SGA_ENDS(fmpz_end) fmpz_t m = { 0 }, v = { 0 };
    for (int i = 0; i < rows; i++) {
        fmpz_one(m);
        common(m, e->E, i);
        common(m, e->F, i);
        common(m, e->A, i);
        common(m, e->B, i);
        for (int k = 0; k < n; k++) {
            fmpz_poly_struct *p = fmpz_poly_mat_entry(M, i, k);
            whole(v, m, e->A, i, k);
            fmpz_neg(v, v);
            fmpz_poly_set_coeff_fmpz(p, 0, v);
            if (e->E)
                whole(v, m, e->E, i, k);
            else
                fmpz_set_ui(v, i == k);
            if (!e->E)
                fmpz_mul(v, v, m);
            fmpz_poly_set_coeff_fmpz(p, 1, v);
        }
        for (int k = 0; k < inputs; k++) {
            fmpz_poly_struct *p = fmpz_poly_mat_entry(M, i, n + k);
            whole(v, m, e->B, i, k);
            fmpz_poly_set_coeff_fmpz(p, 0, v);
            if (!e->F)
                continue;
            whole(v, m, e->F, i, k);
            fmpz_neg(v, v);
            fmpz_poly_set_coeff_fmpz(p, 1, v);
        }
    }
}

/* What is solved: x_pivot = (R_u u - R_free x_free) / den. */
struct solved {
    fmpz_poly_mat_t R;
    fmpz_poly_t den;
    int rank, n, *pivot;
};

/* The columns of the pivots, rising; false: one belongs to an input. */
static bool find_pivots(struct solved *s)
{
    int col = 0;
    for (int r = 0; r < s->rank; r++) {
        while (fmpz_poly_is_zero(fmpz_poly_mat_entry(s->R, r, col))) {
            col++;
            assert(col < fmpz_poly_mat_ncols(s->R));
        }
        if (col >= s->n)
            return false;
        s->pivot[r] = col++;
    }
    return true;
}

/* sum over pivots of m C(output, pivot) R(., col). */
static void along(fmpz_poly_t sum, const struct solved *s, const struct linear_matrix *C, const fmpz_t m, int output, int col)
{
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t term = { 0 };
    fmpz_poly_zero(sum);
    for (int r = 0; r < s->rank; r++) {
        whole(c, m, C, output, s->pivot[r]);
        fmpz_poly_scalar_mul_fmpz(term, fmpz_poly_mat_entry(s->R, r, col), c);
        fmpz_poly_add(sum, sum, term);
    }
}

/* An output must not see what is left free. */
static bool determined(const struct solved *s, const struct linear_matrix *C, const fmpz_t m, int output)
{
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t sum = { 0 }, own = { 0 };
    for (int k = 0, r = 0; k < s->n; k++) {
        if (r < s->rank && s->pivot[r] == k) {
            r++;
            continue;
        }
        along(sum, s, C, m, output, k);
        whole(c, m, C, output, k);
        fmpz_poly_scalar_mul_fmpz(own, s->den, c);
        if (!fmpz_poly_equal(sum, own))
            return false;
    }
    return true;
}

static void reduce(fmpz_poly_struct *num, fmpz_poly_struct *den)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t g = { 0 };
    fmpz_poly_gcd(g, num, den);
    fmpz_poly_div(num, num, g);
    fmpz_poly_div(den, den, g);
    if (fmpz_sgn(fmpz_poly_lead(den)) < 0) {
        fmpz_poly_neg(num, num);
        fmpz_poly_neg(den, den);
    }
}

static bool entries(struct transfer_matrix *t, const struct solved *s, const struct transfer_equations *e)
{
    SGA_ENDS(fmpz_end) fmpz_t m = { 0 }, d = { 0 };
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t direct = { 0 };
    for (int i = 0; i < t->outputs; i++) {
        fmpz_one(m);
        common(m, e->C, i);
        common(m, e->D, i);
        t->which = i;
        if (!determined(s, e->C, m, i))
            return false;
        for (int k = 0; k < t->inputs; k++) {
            fmpz_poly_struct *num = t->num + i * t->inputs + k, *den = t->den + i * t->inputs + k;
            along(num, s, e->C, m, i, s->n + k);
            whole(d, m, e->D, i, k);
            fmpz_poly_scalar_mul_fmpz(direct, s->den, d);
            fmpz_poly_add(num, num, direct);
            fmpz_poly_scalar_mul_fmpz(den, s->den, m);
            reduce(num, den);
        }
    }
    return true;
}

static void make(struct transfer_matrix *t, int outputs, int inputs)
{
    size_t count = (size_t)outputs * (size_t)inputs;
    *t = (struct transfer_matrix){ .outputs = outputs, .inputs = inputs };
    t->num = sga_calloc(count + 1, sizeof *t->num);
    t->den = sga_calloc(count + 1, sizeof *t->den);
}

void transfer_matrix_clear(struct transfer_matrix *t)
{
    for (int k = 0; k < t->outputs * t->inputs; k++) {
        fmpz_poly_clear(t->num + k);
        fmpz_poly_clear(t->den + k);
    }
    free(t->num);
    free(t->den);
    *t = (struct transfer_matrix){ .outputs = 0 };
}

enum transfer_status transfer_matrix_find(struct transfer_matrix *t, const struct transfer_equations *e)
{
    struct solved s = { .n = linear_cols(e->A) };
    SGA_ENDS(fmpz_poly_mat_end) fmpz_poly_mat_t M, R;
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t den = { 0 };
    int rows = linear_rows(e->A), inputs = linear_cols(e->B);
    fmpz_poly_mat_init(M, rows, s.n + inputs);
    fmpz_poly_mat_init(R, rows, s.n + inputs);
    make(t, linear_rows(e->C), inputs);
    SGA_ARENA(mem);
    s.pivot = sga_zeros(&mem, (size_t)rows + 1, sizeof *s.pivot);
    system_matrix(M, e);
    fmpz_poly_one(den);
    s.rank = rows ? (int)fmpz_poly_mat_rref(R, den, M) : 0;
    assert(s.rank <= rows && s.rank <= s.n + inputs);
    *s.R = *R;                     /* borrowed */
    *s.den = *den;
    enum transfer_status status = !find_pivots(&s) ? TRANSFER_INPUTS_BOUND : !entries(t, &s, e) ? TRANSFER_OUTPUT_FREE : TRANSFER_OK;
    if (status != TRANSFER_OK) {
        int which = t->which;
        transfer_matrix_clear(t);
        t->which = which;
    }
    return status;
}

bool transfer_matrix_proper(const struct transfer_matrix *t, bool strictly)
{
    for (int k = 0; k < t->outputs * t->inputs; k++)
        if (fmpz_poly_degree(t->num + k) + strictly > fmpz_poly_degree(t->den + k))
            return false;
    return true;
}

/* One entry's polynomial: highest powers first. Returns how many terms it has. */
static int polynomial(const fmpz_poly_t p, struct sga_buf *out)
{
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    int terms = 0;
    for (slong k = fmpz_poly_degree(p); k >= 0; k--) {
        fmpz_poly_get_coeff_fmpz(c, p, k);
        if (fmpz_is_zero(c))
            continue;
        bool minus = fmpz_sgn(c) < 0;
        fmpz_abs(c, c);
        sga_buf_puts(out, terms ? (minus ? " - " : " + ") : minus ? "-" : "");
        bool one = fmpz_is_one(c) && k > 0;
        char *text = one ? NULL : fmpz_get_str(NULL, 10, c);
        sga_buf_printf(out, "%s%s", text ? text : "", text && k > 0 ? "*" : "");
        flint_free(text);
        if (k > 0)
            sga_buf_puts(out, "s");
        if (k > 1)
            sga_buf_printf(out, "^%ld", (long)k);
        terms++;
    }
    if (!terms)
        sga_buf_puts(out, "0");
    return terms;
}

void transfer_entry_text(const struct transfer_matrix *t, int output, int input, struct sga_buf *out)
{
    const fmpz_poly_struct *num = t->num + output * t->inputs + input, *den = t->den + output * t->inputs + input;
    SGA_ENDS(sga_buf_free) struct sga_buf a = { 0 }, b = { 0 };
    int above = polynomial(num, &a), below = polynomial(den, &b);
    bool plain = fmpz_poly_is_one(den), single = below == 1 && (fmpz_is_one(fmpz_poly_lead(den)) || fmpz_poly_degree(den) == 0);
    if (plain) {
        sga_buf_puts(out, a.data);
        return;
    }
    sga_buf_printf(out, above > 1 ? "(%s)" : "%s", a.data);
    sga_buf_printf(out, single ? "/%s" : "/(%s)", b.data);
}

bool transfer_entry_at(const struct transfer_matrix *t, int output, int input, double omega, acb_t value)
{
    enum { MOST_BITS = 4096, WANTED = 64 };
    int k = output * t->inputs + input;
    arb_poly_t p;
    acb_t s, d;
    bool ok = false;
    arb_poly_init(p);
    acb_init(s);
    acb_init(d);
    arb_set_d(acb_imagref(s), omega);
    for (slong bits = LINEAR_BITS; bits <= MOST_BITS; bits *= 2) {
        arb_poly_set_fmpz_poly(p, t->num + k, bits);
        arb_poly_evaluate_acb(value, p, s, bits);
        arb_poly_set_fmpz_poly(p, t->den + k, bits);
        arb_poly_evaluate_acb(d, p, s, bits);
        ok = !acb_contains_zero(d);
        if (ok)
            acb_div(value, value, d, bits);
        if (ok && (acb_rel_accuracy_bits(value) >= WANTED || acb_is_zero(value)))
            break;
    }
    acb_clear(s);
    acb_clear(d);
    arb_poly_clear(p);
    return ok;
}
