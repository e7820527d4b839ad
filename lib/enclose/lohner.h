/* Inside the enclose folder: the set that holds the solution, and one step of it.
 *
 * The set is { x + A r : |r_i| <= radius_i }, x an exact point, A = U Q with U diagonal (units of the variables) and
 * Q about orthogonal. A step h makes of it
 *     phi_h(x) + J A r,   J = d phi_h / d x over the set (mean value theorem; the set is convex, J one of all matrices
 *     between),
 * phi_h(x) by a Taylor series from x of full precision, J by one from the box around the set with fewer bits and orders, both with
 * the tails of tail.h. The new A comes from a QR factorisation of the midpoint of J A with its longest columns
 * first, so that sets that turn and shear are not wrapped in ever larger boxes (Lohner 1987; Nedialkov, Jackson,
 * Corliss, Validated solutions of initial value problems for ODEs, Appl. Math. Comput. 105, 1999, section 6).
 * Everything is rigorous but the choices of x, A and of the step, which need not be. */
#ifndef SGA_ENCLOSE_LOHNER_H
#define SGA_ENCLOSE_LOHNER_H

#include "tail.h"

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
/* Half the widths of the box around the set, n. */
void enc_set_width(const struct enc_set *s, mag_ptr width);
/* The box around the set, n balls. */
void enc_set_hull(const struct enc_set *s, arb_ptr box);
/* The set { y + B r } of balls y and B, r as it is, in the new form; size: about what the variables
 * can change by (their units). False where it is not finite. */
bool enc_set_move(struct enc_set *s, arb_srcptr y, const arb_mat_t B, const double *size);

/* Bits of what multiplies radii. */
enum { ENC_ROUGH_BITS = 64 };

struct enc_step {
    const struct enc_program *p;
    int fields;              /* roots 0 .. fields - 1: X; those after it must not vanish */
    struct enc_series point, rough;     /* from x; from the box, with derivatives */
    struct enc_tail point_tail, rough_tail;
    slong prec;
    double h;                /* signed; the step holds for s between 0 and h */
    arb_ptr box;             /* n: around the set */
    mag_ptr width;           /* n: its half widths */
    arb_ptr jacobian;        /* n x n x (order of rough + 1): the coefficients of J */
    slong jacobian_room;
    mag_ptr jacobian_tail;   /* n x n */
    double *size;            /* by variable: its unit */
    int more;                /* orders that J needed beyond the guess in the last steps */
    slong bits;              /* of rough: more than ENC_ROUGH_BITS where those lose all to cancellation */
    int calm;                /* steps, for more and bits to become less */
    long runs;               /* Taylor series so far */
    int bad;                 /* of a failure ENC_STEP_SHORT: the root after the field that may vanish; -1: X itself */
    enum { ENC_STEP_OK, ENC_STEP_SHORT, ENC_STEP_WIDE } failure;
};

void enc_step_init(struct enc_step *w, const struct enc_program *p, int fields);
void enc_step_clear(struct enc_step *w);
/* Prepare a step from the set at time t, of at most |most| in the direction of its sign, at least `least`. False: w->failure. */
bool enc_step_make(struct enc_step *w, const struct enc_set *set, const arb_t t, double most, double least, slong prec);
/* The box that holds the solutions after time s (a ball whose exact value lies between 0 and h). */
void enc_step_at(const struct enc_step *w, const struct enc_set *set, const arb_t s, arb_ptr box);
/* The set after time s, as for enc_step_at. */
bool enc_step_take(const struct enc_step *w, struct enc_set *set, const arb_t s);

static inline arb_ptr enc_step_jacobian(const struct enc_step *w, int i, int j)
{
    return w->jacobian + ((size_t)i * (size_t)w->p->n + (size_t)j) * (size_t)(w->rough.order + 1);
}

#endif
