/* The search for a disc. Its proof is one evaluation of the field on a complex box (box.c). */
#include "disc.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"

enum { SHRINKS = 100, FRESH = 60, PASSES = 3, OFTEN = 32, ROUNDS = 8 };
static const double FLAT = 0x1p-44;

void enc_disc_init(struct enc_disc *c, const struct enc_program *p, int fields)
{
    size_t n = (size_t)p->n + 1;
    *c = (struct enc_disc){ .p = p, .fields = fields, .value = _acb_vec_init(p->slots), .b = sga_calloc(n, sizeof(double)),
                            .d = sga_calloc(n, sizeof(double)), .M = sga_calloc(n, sizeof(double)) };
}

void enc_disc_clear(struct enc_disc *c)
{
    if (!c->p)
        return;
    _acb_vec_clear(c->value, c->p->slots);
    free(c->b);
    free(c->d);
    free(c->M);
    *c = (struct enc_disc){ 0 };
}

/* A double >= |z|. */
static double bound(const acb_t z)
{
    mag_t m;
    mag_init(m);
    acb_get_mag(m, z);
    double d = mag_is_inf(m) ? INFINITY : mag_get_d(m) * (1 + 0x1p-40) + 0x1p-1000;
    mag_clear(m);
    return d;
}

static void set_disc(acb_t z, arb_srcptr x, double radius)
{
    arb_set_round(acb_realref(z), x, ENC_BOX_BITS);
    mag_t m;
    mag_init(m);
    mag_set_d(m, radius);
    arb_add_error_mag(acb_realref(z), m);
    arb_zero(acb_imagref(z));
    arb_add_error_mag(acb_imagref(z), m);
    mag_clear(m);
}

/* M for the box b and the time disc R. False where X is not shown to be holomorphic, or a root that must not vanish may. */
static bool evaluate(struct enc_disc *c, arb_srcptr x, const arb_t t, double R)
{
    const struct enc_program *p = c->p;
    c->evaluations++;
    c->time = R;
    for (int j = 0; j < p->n; j++)
        set_disc(c->value + j, x + j, c->b[j]);
    set_disc(c->value + p->n, t, R);
    c->bad = -1;
    if (!enc_box_values(c))
        return false;
    for (int k = c->fields; k < p->roots; k++)
        if (acb_contains_zero(c->value + p->root[k])) {
            c->bad = k - c->fields;
            return false;
        }
    for (int j = 0; j < p->n; j++) {
        c->M[j] = bound(c->value + p->root[j]);
        if (!isfinite(c->M[j]))
            return false;
    }
    return true;
}

/* The radius that the theorem gives for the box as it is, rounded down. */
static double radius_of(const struct enc_disc *c)
{
    double R = INFINITY;
    for (int j = 0; j < c->p->n; j++)
        R = fmin(R, (1 - ENC_SHARE) * c->b[j] / c->M[j]);
    return fmin(R * (1 - 0x1p-40), c->time);
}

/* A box must not be flat: variables that do not move still have starts nearby. Thin boxes cost a few bits (remainders of J are
 * divided by d), thick ones are felt by what depends strongly on a large variable: sin(10^6 x). */
static void thicken(struct enc_disc *c, arb_srcptr x)
{
    int n = c->p->n;
    double big = 0;
    for (int j = 0; j < n; j++)
        big = fmax(big, fabs(arf_get_d(arb_midref(x + j), ARF_RND_UP)));
    big = big > 0 && isfinite(big) ? big : 1;
    for (int j = 0; j < n; j++) {
        double size = fabs(arf_get_d(arb_midref(x + j), ARF_RND_UP));
        c->b[j] = fmax(c->b[j], fmax(FLAT * fmax(size, 0x1p-10 * big), 0x1p-900));
    }
}

/* Where the box is what moves in the time R, all sides give the same radius. */
static void reshape(struct enc_disc *c, arb_srcptr x, double R)
{
    for (int j = 0; j < c->p->n; j++)
        c->b[j] = R * c->M[j] / (1 - ENC_SHARE);
    thicken(c, x);
}

/* Make the box smaller until it is shown to be a domain of X. */
static bool shrink(struct enc_disc *c, arb_srcptr x, const arb_t t, double R)
{
    for (int k = 0; k < SHRINKS; k++) {
        if (evaluate(c, x, t, R))
            return true;
        for (int j = 0; j < c->p->n; j++)
            c->b[j] *= 0.25;
        R *= 0.25;
    }
    return false;
}

static double *copy(const double *v, int n)
{
    return memcpy(sga_malloc((size_t)(n + 1) * sizeof *v), v, (size_t)n * sizeof *v);
}

/* Every box that X is holomorphic on gives a valid R. The search goes on with the shape and size of the last
 * step, and tries one that is a little larger or smaller, as did good last. */
bool enc_disc_find(struct enc_disc *c, arb_srcptr x, const arb_t t, double most, double least)
{
    int n = c->p->n;
    bool fresh = !(c->R > 0);
    c->grow = fresh ? 2 : c->grow;
    thicken(c, x);
    double time = fresh ? fmin(most, 1) : fmin(2 * c->R, most);
    if (!shrink(c, x, t, time))
        return false;
    double R = radius_of(c);
    double *b = copy(c->b, n), *M = copy(c->M, n);
    int rounds = fresh ? FRESH : c->searches++ % OFTEN ? 1 : ROUNDS;
    for (int k = 0; k < rounds; k++) {
        double next = R;
        for (int pass = 0; pass < PASSES && next > 0; pass++) {
            /* a smaller box shows what the field is without its own size; the sides pull each other along */
            double goal = c->grow > 1 ? c->grow * R : pass ? 1.2 * R : 0.5 * R;
            reshape(c, x, pass ? 1.02 * goal : goal);
            next = evaluate(c, x, t, fmin(2 * R, most)) ? radius_of(c) : 0;
        }
        if (next > 1.01 * R) {
            R = next;
            memcpy(b, c->b, (size_t)n * sizeof *b);
            memcpy(M, c->M, (size_t)n * sizeof *M);
        } else {
            memcpy(c->M, M, (size_t)n * sizeof *M);
            c->grow = c->grow > 1 ? 0.5 : 1.25;
        }
    }
    memcpy(c->b, b, (size_t)n * sizeof *b);
    memcpy(c->M, M, (size_t)n * sizeof *M);
    free(b);
    free(M);
    c->R = fmin(R, most);
    for (int j = 0; j < n; j++)
        c->d[j] = ENC_SHARE * c->b[j];
    return c->R >= least;
}
