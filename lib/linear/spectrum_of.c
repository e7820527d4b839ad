/* Eigenvalues: by the pencil's exact structure, or in discs. */
#include "spectrum_of.h"

#include <acb_mat.h>
#include <acb_poly.h>
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "buf.h"
#include "pencil.h"

SGA_END_BY(acb_mat_end, acb_mat_t, acb_mat_clear)

/* Eigenvalues are written as doubles where their nearest double is enough. */
static const double DOUBLE = 1e-15;

static enum spectrum_side side_of_text(const char *re)
{
    return strcmp(re, "0") == 0 ? SPECTRUM_AXIS : re[0] == '-' ? SPECTRUM_LEFT : SPECTRUM_RIGHT;
}

static void add_entries(struct pencil_matrix *to, const struct linear_matrix *m)
{
    for (int i = 0; i < linear_rows(m); i++)
        for (int k = 0; k < linear_cols(m); k++)
            if (!fmpq_is_zero(fmpq_mat_entry(m->q, i, k)))
                pencil_add(to, i, k, fmpq_mat_entry(m->q, i, k));
}

static void take(struct spectrum_of *s, const struct pencil_structure *p, const struct pencil_eigenvalue *e, int count)
{
    s->value = sga_zeros(&s->mem, (size_t)count + 1, sizeof *s->value);
    s->exact = true;
    for (int i = 0; i < count; i++) {
        const struct pencil_factor *f = p->factor + e[i].factor;
        s->value[i] = (struct spectrum_value){
            .re = sga_take_text(&s->mem, e[i].re), .im = sga_take_text(&s->mem, e[i].im), .multiplicity = f->multiplicity,
            .block = f->blocks ? f->block[0] : 0, .side = side_of_text(e[i].re), .size = hypot(strtod(e[i].re, NULL), strtod(e[i].im, NULL)) };
        s->total += f->multiplicity;
    }
    s->count = count;
}

bool spectrum_of_pencil(struct spectrum_of *s, const struct linear_matrix *E, const struct linear_matrix *F, const struct sga_budget *budget,
                        struct sga_error *err)
{
    assert(E->exact && F->exact && linear_rows(E) == linear_rows(F) && linear_cols(E) == linear_cols(F));
    struct pencil p;
    struct pencil_structure structure;
    struct pencil_options options = { .spectrum = true, .budget = budget };
    struct pencil_eigenvalue *e = NULL;
    int count = 0;
    *s = (struct spectrum_of){ .exact = true };
    if (!linear_rows(E) || !linear_cols(E))
        return true;
    pencil_init(&p, linear_rows(E), linear_cols(E));
    add_entries(&p.A, E);
    add_entries(&p.B, F);
    bool ok = pencil_structure(&p, &options, &structure, err);
    pencil_clear(&p);
    if (!ok)
        return false;
    if (structure.no_spectrum)
        s->missing = "the eigenvalues would take longer than the time that is left; raise limits.seconds";
    else
        ok = pencil_eigenvalues(&structure, DOUBLE, budget, &e, &count, err);
    if (ok && !s->missing) {
        take(s, &structure, e, count);
        pencil_eigenvalues_clear(e, count);
    }
    pencil_structure_clear(&structure);
    return ok;
}

static int by_value(const void *x, const void *y)
{
    const acb_struct *a = x, *b = y;
    int c = arf_cmp(arb_midref(acb_realref(a)), arb_midref(acb_realref(b)));
    return c ? c : arf_cmp(arb_midref(acb_imagref(a)), arb_midref(acb_imagref(b)));
}

/* The double nearest to the middle, 0 where the ball has it; *error grows to what it may be off by. */
static double written(const arb_t x, double *error)
{
    SGA_ENDS(arb_end) arb_t off = { 0 };
    SGA_ENDS(mag_end) mag_t size = { 0 };
    double v = arb_contains_zero(x) ? 0 : arf_get_d(arb_midref(x), ARF_RND_NEAR);
    arb_set_d(off, v);
    arb_sub(off, x, off, LINEAR_BITS);
    arb_get_mag(size, off);
    *error = fmax(*error, mag_get_d(size));
    return v;
}

static char *number(struct spectrum_of *s, const arb_t x)
{
    char text[32];
    sga_format_double(text, written(x, &s->error));
    return sga_take_text(&s->mem, text);
}

static enum spectrum_side side_of_ball(const arb_t re)
{
    return arb_is_positive(re) ? SPECTRUM_RIGHT : arb_is_negative(re) ? SPECTRUM_LEFT : arb_is_zero(re) ? SPECTRUM_AXIS : SPECTRUM_UNKNOWN;
}

/* Discs that overlap are one: their hull holds as many eigenvalues as they are. */
static void take_discs(struct spectrum_of *s, acb_ptr e, int n)
{
    s->value = sga_zeros(&s->mem, (size_t)n + 1, sizeof *s->value);
    s->total = n;
    int left = n;
    SGA_ARENA(mem);
    unsigned char *gone = sga_zeros(&mem, (size_t)n + 1, 1);
    for (int i = 0; i < n; i++) {
        int together = 1;
        if (gone[i])
            continue;
        for (int k = i + 1; k < n; k++)
            if (!gone[k] && acb_overlaps(e + i, e + k)) {
                acb_union(e + i, e + i, e + k, LINEAR_BITS);
                gone[k] = 1;
                together++;
                k = i;             /* the hull may reach others */
            }
        s->value[s->count++] = (struct spectrum_value){
            .re = number(s, acb_realref(e + i)), .im = number(s, acb_imagref(e + i)), .multiplicity = together,
            .block = together == 1, .side = side_of_ball(acb_realref(e + i)),
            .size = hypot(arf_get_d(arb_midref(acb_realref(e + i)), ARF_RND_NEAR), arf_get_d(arb_midref(acb_imagref(e + i)), ARF_RND_NEAR)) };
        left -= together;
    }
    assert(left == 0);
}

/* All eigenvalues lie about m, the mean of the diagonal, within a norm of A - m: into e. Where entries are not told from 0, nothing else is known. */
static void all_within(acb_t e, const struct linear_matrix *A)
{
    int n = linear_rows(A);
    SGA_ENDS(arb_mat_end) arb_mat_t rest;
    SGA_ENDS(mag_end) mag_t norm = { 0 };
    arb_ptr mean = acb_realref(e);
    arb_mat_init(rest, n, n);
    arb_mat_trace(mean, A->b, LINEAR_BITS);
    arb_div_si(mean, mean, n, LINEAR_BITS);
    mag_zero(arb_radref(mean));
    arb_mat_set(rest, A->b);
    for (int i = 0; i < n; i++)
        arb_sub(arb_mat_entry(rest, i, i), arb_mat_entry(rest, i, i), mean, LINEAR_BITS);
    arb_mat_bound_inf_norm(norm, rest);
    arb_zero(acb_imagref(e));
    arb_add_error_mag(acb_realref(e), norm);
    arb_add_error_mag(acb_imagref(e), norm);
}

/* A disc that reaches beyond all of them has what it shares with them; discs of several are alike. */
static void cut_back(acb_ptr e, const acb_t all)
{
    if (!acb_is_finite(e)) {
        acb_set(e, all);
        return;
    }
    arb_intersection(acb_realref(e), acb_realref(e), acb_realref(all), LINEAR_BITS);
    arb_intersection(acb_imagref(e), acb_imagref(e), acb_imagref(all), LINEAR_BITS);
}

enum { MOST_DISCS = 30 };      /* beyond it the polynomial costs more than it tells */

/* Points that lie on each other tell nothing: each goes 2^log of the size its own way; log 0: none does. */
static void spread(acb_ptr to, acb_srcptr near, int n, int log, int size)
{
    acb_t way;
    acb_init(way);
    for (int i = 0; i < n; i++) {
        acb_set(to + i, near + i);
        if (!log)
            continue;
        acb_unit_root(way, (ulong)n, LINEAR_BITS);
        acb_pow_ui(way, way, (ulong)i, LINEAR_BITS);
        acb_mul_2exp_si(way, way, log + size);
        acb_add(to + i, to + i, way, LINEAR_BITS);
        acb_get_mid(to + i, to + i);
    }
    acb_clear(way);
}

/* Of |p(z_i)| / prod |z_i - z_k|, times the number of points. */
static void disc_radius(mag_t radius, const acb_poly_t p, acb_srcptr z, int n, int i)
{
    acb_t apart, product;
    SGA_ENDS(mag_end) mag_t below = { 0 };
    acb_init(apart);
    acb_init(product);
    acb_one(product);
    for (int k = 0; k < n; k++)
        if (k != i) {
            acb_sub(apart, z + i, z + k, LINEAR_BITS);
            acb_mul(product, product, apart, LINEAR_BITS);
        }
    acb_poly_evaluate(apart, p, z + i, LINEAR_BITS);
    acb_get_mag(radius, apart);
    acb_get_mag_lower(below, product);
    mag_div(radius, radius, below);
    mag_mul_ui(radius, radius, (ulong)n);
    acb_clear(product);
    acb_clear(apart);
}

/* Discs about points near the eigenvalues (n), by the characteristic polynomial: those that hang together hold as many roots as they are (Smith
 * 1970). For eigenvalues so near to each other that no invariant subspace is told; the points are spread as far as gives the smallest discs. */
static void discs(acb_ptr e, acb_srcptr near, const struct linear_matrix *A)
{
    static const int log[] = { 0, -150, -100, -80, -60, -50, -40, -30, -20, -10 };
    int n = linear_rows(A);
    arb_poly_t real;
    acb_poly_t p;
    acb_ptr z = _acb_vec_init(n);
    mag_ptr radius = _mag_vec_init(n);
    SGA_ENDS(mag_end) mag_t most = { 0 }, least = { 0 };
    arb_poly_init(real);
    acb_poly_init(p);
    arb_mat_bound_inf_norm(most, A->b);
    int size = mag_get_d(most) > 0 && isfinite(mag_get_d(most)) ? ilogb(mag_get_d(most)) : 0;
    arb_mat_charpoly(real, A->b, LINEAR_BITS);
    acb_poly_set_arb_poly(p, real);
    mag_inf(least);
    _acb_vec_indeterminate(e, n);
    for (size_t way = 0; way < sizeof log / sizeof *log; way++) {
        spread(z, near, n, log[way], size);
        mag_zero(most);
        for (int i = 0; i < n; i++) {
            disc_radius(radius + i, p, z, n, i);
            mag_max(most, most, radius + i);
        }
        if (mag_cmp(most, least) >= 0)
            continue;
        mag_set(least, most);
        for (int i = 0; i < n; i++) {
            acb_set(e + i, z + i);
            arb_add_error_mag(acb_realref(e + i), radius + i);
            arb_add_error_mag(acb_imagref(e + i), radius + i);
        }
    }
    _mag_vec_clear(radius, n);
    _acb_vec_clear(z, n);
    acb_poly_clear(p);
    arb_poly_clear(real);
}

static bool enclose(acb_ptr e, const struct linear_matrix *A)
{
    int n = linear_rows(A);
    SGA_ENDS(acb_mat_end) acb_mat_t M, R;
    acb_mat_init(M, n, n);
    acb_mat_init(R, n, n);
    acb_mat_set_arb_mat(M, A->b);
    acb_ptr near = _acb_vec_init(n);
    acb_mat_approx_eig_qr(near, NULL, R, M, NULL, 0, LINEAR_BITS);
    for (int i = 0; i < n; i++)
        acb_get_mid(near + i, near + i);
    bool ok = acb_mat_eig_multiple(e, M, near, R, LINEAR_BITS);
    if (!ok && n <= MOST_DISCS) {
        discs(e, near, A);
        ok = true;
    }
    _acb_vec_clear(near, n);
    acb_ptr all = _acb_vec_init(1);
    all_within(all, A);
    for (int i = 0; i < n; i++)
        if (ok)
            cut_back(e + i, all);
        else
            acb_set(e + i, all);
    ok = acb_is_finite(all);
    _acb_vec_clear(all, 1);
    return ok;
}

bool spectrum_of_matrix(struct spectrum_of *s, const struct linear_matrix *A, const struct sga_budget *budget, struct sga_error *err)
{
    int n = linear_rows(A);
    assert(n == linear_cols(A));
    if (A->exact) {
        struct linear_matrix one;
        linear_matrix_init(&one, n, n);
        fmpq_mat_one(one.q);
        linear_matrix_enclose(&one);
        bool ok = spectrum_of_pencil(s, &one, A, budget, err);
        linear_matrix_clear(&one);
        return ok;
    }
    *s = (struct spectrum_of){ .exact = false };
    acb_ptr e = _acb_vec_init(n);
    if (enclose(e, A)) {
        qsort(e, (size_t)n, sizeof *e, by_value);
        take_discs(s, e, n);
    } else {
        s->missing = "the eigenvalues could not be enclosed";
    }
    _acb_vec_clear(e, n);
    return true;
}

void spectrum_of_clear(struct spectrum_of *s)
{
    sga_arena_end(&s->mem);
    *s = (struct spectrum_of){ .count = 0 };
}
