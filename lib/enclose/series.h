/* Inside the enclose folder: Taylor coefficients of a solution and of its derivatives with
 * respect to the start, in balls.
 *
 * Every operation is one of ball arithmetic, so a coefficient encloses the exact one for every start
 * inside the balls given. Cost: order^2 / 2 multiplications for each slot. */
#ifndef SGA_ENCLOSE_SERIES_H
#define SGA_ENCLOSE_SERIES_H

#include <arb_mat.h>

#include "program.h"

struct enc_series {
    const struct enc_program *p;
    slong prec;
    int order, room;         /* coefficients 0 .. order; allocated */
    arb_ptr value;           /* by slot: room + 1 coefficients */
    arb_ptr scaled;          /* the same, the k-th times k, where code.scaled */
    arb_ptr tangent;         /* by slot, the derivative along one direction; NULL until asked for */
    int *from;               /* by slot: tangent coefficients below this one are 0 */
    signed char *choice;     /* by slot: what CHOICE took: 1 a, -1 minus a, 2 b, 3 the constant 1, -3 minus 1; 0 undecided */
    arb_mat_struct *inverse; /* by system */
};

void enc_series_init(struct enc_series *s, const struct enc_program *p);
void enc_series_clear(struct enc_series *s);
/* The coefficients 0 .. order of all slots along x' = roots[0..n) from x (n) at time t. Those of
 * the variables are enc_series_of(s, j). False where something is not finite. */
bool enc_series_run(struct enc_series *s, arb_srcptr x, const arb_t t, int order, slong prec);
/* The values of all slots at x and t, as coefficients 0: of those without a value not finite, of choices the hull of both branches. */
void enc_series_values(struct enc_series *s, arb_srcptr x, const arb_t t, slong prec);
/* The derivatives of those coefficients with respect to the start of variable j: 0 .. order, for
 * the slots of the variables into enc_series_tangent. After enc_series_run. */
bool enc_series_along(struct enc_series *s, int j);
/* Of all slots, as functions of the start, only the derivatives of their values: into
 * coefficient 0 of their tangents; of abs, min and max that are undecided all that lies between those of both branches. After enc_series_values too. */
bool enc_series_slope(struct enc_series *s, int j);

/* Shared by values and derivatives: r = r0 - or + sum_{i=0}^{len-1} x_i y_{top-i}, x and y from their first entries, r0 NULL
 * for 0; and a coefficient of the branch that was chosen (constant: of a sign, the 0-th of a value). */
void enc_convolve(arb_t r, const arb_t r0, bool minus, arb_srcptr x, arb_srcptr y, slong top, slong len, slong prec);
void enc_follow(arb_t r, int choice, const arb_t a, const arb_t b, bool constant);

static inline arb_ptr enc_series_of(const struct enc_series *s, int slot) { return s->value + (size_t)slot * (size_t)(s->room + 1); }
static inline arb_ptr enc_series_tangent(const struct enc_series *s, int slot) { return s->tangent + (size_t)slot * (size_t)(s->room + 1); }

#endif
