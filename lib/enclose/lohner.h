/* Inside the enclose folder: the set that holds the solution, and one step of it.
 *
 * The set is { x + A r : |r_i| <= radius_i }, x an exact point, A = U Q with U diagonal (units of the variables) and
 * Q about orthogonal. A step h makes of it
 *     phi_h(x) + J A r + w,   J = d phi_h / d x at x,
 * phi_h(x) and J by Taylor series with remainders from Cauchy's estimates on the disc (disc.h):
 *     |k-th coefficient of phi_i| <= b_i / R^k,   |that of J_ij| <= b_i / (d_j R^k),
 * and, with r = theta r0 for complex theta, |theta| < T = min_j d_j / |(A r0)_j|, for what is
 * not linear in r
 *     |w_i| <= b_i T^-2 / (1 - 1/T).
 * The new A comes from a QR factorisation of the midpoint of J A with its longest columns first, so that
 * sets that turn and shear are not wrapped in ever larger boxes (Lohner 1987; Nedialkov, Jackson,
 * Corliss, Validated solutions of initial value problems for ODEs, Appl. Math. Comput. 105, 1999, section 6).
 * Everything is rigorous but the choices of x, A and of the step, which need not be. */
#ifndef SGA_ENCLOSE_LOHNER_H
#define SGA_ENCLOSE_LOHNER_H

#include "disc.h"
#include "series.h"

struct enc_set {
    int n;
    arb_ptr x;               /* exact */
    arb_mat_t A;             /* exact */
    mag_ptr radius;
};

void enc_set_init(struct enc_set *s, int n);
void enc_set_clear(struct enc_set *s);
/* The set that is the box of these balls. */
void enc_set_box(struct enc_set *s, arb_srcptr box);
/* The set { y + B r } of balls y and B, r as it is, in the new form; size: about what the variables
 * can change by (their units). False where it is not finite. */
bool enc_set_move(struct enc_set *s, arb_srcptr y, const arb_mat_t B, const double *size);

struct enc_step {
    const struct enc_program *p;
    struct enc_disc disc;
    struct enc_series point, rough;     /* from x: full precision; few bits and orders, with tangents */
    slong prec;
    int order, linear;       /* of the two */
    double h;                /* signed; the step holds for s between 0 and h */
    arb_ptr jacobian;        /* n x n x (linear + 1): the coefficients of J */
    slong jacobian_room;
    double theta;            /* a lower bound of T */
    enum { ENC_STEP_OK, ENC_STEP_DISC, ENC_STEP_WIDE, ENC_STEP_SERIES } failure;
};

void enc_step_init(struct enc_step *w, const struct enc_program *p, int fields);
void enc_step_clear(struct enc_step *w);
/* Prepare a step from the set at time t, of at most |most| in the direction of its sign, at least `least`. False: w->failure. */
bool enc_step_make(struct enc_step *w, const struct enc_set *set, const arb_t t, double most, double least, slong prec);
/* The box that holds the solutions after time s (a ball whose exact value lies between 0 and h). */
void enc_step_at(const struct enc_step *w, const struct enc_set *set, const arb_t s, arb_ptr box);
/* The set after the whole step. */
bool enc_step_take(const struct enc_step *w, struct enc_set *set);

#endif
