/* Inside the enclose folder: how far in complex time solutions are proved to exist.
 *
 * Theorem (Cauchy; Hille, Ordinary Differential Equations in the Complex Domain, theorem 2.3.1,
 * with a box in place of a ball). Let X be holomorphic on |s| <= R, |z_j - x_j| <= b_j, with
 * |X_j| <= M_j there. If |y_j - x_j| <= d_j and d_j + R M_j <= b_j, the solution z' = X(t + s, z),
 * z(0) = y exists for |s| <= R, stays in the box, and is holomorphic in s and y: the Picard
 * iterates stay in the box, are holomorphic, and converge. */
#ifndef SGA_ENCLOSE_DISC_H
#define SGA_ENCLOSE_DISC_H

#include <acb.h>

#include "program.h"

struct enc_disc {
    const struct enc_program *p;
    int fields;               /* roots 0 .. fields - 1: X; those after it must not vanish */
    acb_ptr value;            /* by slot */
    double *b, *d, *M;        /* by variable: as above */
    double R, time;           /* time: of the last evaluation, R <= time */
    double grow;              /* of the search: what to try next */
    int bad;                  /* of the last failure: the root after the field that may vanish; -1: X itself */
    long evaluations, searches;
};

/* The start's share of the box: d_j = ENC_SHARE b_j. */
#define ENC_SHARE 0.125

void enc_disc_init(struct enc_disc *c, const struct enc_program *p, int fields);
void enc_disc_clear(struct enc_disc *c);
/* Find R, as large as is easy but at most `most`, and b such that the theorem holds around the exact point x
 * (n) at time t, with the further roots not 0 in the box. False if none is found
 * with R >= least. All bounds are rigorous; the search is not. */
bool enc_disc_find(struct enc_disc *c, arb_srcptr x, const arb_t t, double most, double least);

/* Inside the search (box.c): the values of all slots that are not aux, the inputs being set. False where one is not shown to be
 * finite and holomorphic on the box. */
enum { ENC_BOX_BITS = 64 };
bool enc_box_values(struct enc_disc *c);

#endif
