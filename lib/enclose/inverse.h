/* Inside the enclose folder: bounds of |1 / f| for power series f, and of inverse matrices of them.
 *
 * Let q_0 .. q_M be the first coefficients of 1 / f, q = sum q_i s^i. Then q f = 1 - e with e of degree > M, |e| <= P = sum_{i <= M} |q_i| R^i
 * sum_{l > M - i} |f_l| R^l, and 1 / f = q / (1 - e): |1 / f| <= |q| / (1 - |e|) if |e| < 1, also for f plus a tail w, where
 * |e| <= P + |q| |w|. Larger M serve where f changes much within R (M = 0: |f - f_0| < |f_0|). For a matrix S: Q S = 1 - E with matrices, and
 * S is regular on the disc if |E| v < v for some v > 0 (the spectral radius of |E|, and so of each E(s), is below 1). */
#ifndef SGA_ENCLOSE_INVERSE_H
#define SGA_ENCLOSE_INVERSE_H

#include "series.h"

struct enc_tail;

struct enc_inverse {
    int known;               /* coefficients q_0 .. that are there */
    arb_ptr q;               /* ENC_INVERSE_SCALAR + 1 */
    mag_t norm, error;       /* |q|, P */
};

struct enc_matrix_inverse {
    int known;
    arb_mat_struct *Q;       /* ENC_INVERSE_MATRIX + 1 */
    mag_ptr norm, error;     /* m x m: |Q_ij|, P for E_ij */
};

struct enc_inverses {
    const struct enc_program *p;
    struct enc_inverse *scalar;              /* by slot; used for denominators and roots */
    struct enc_matrix_inverse *matrix;       /* by system */
};

/* The largest M. */
enum { ENC_INVERSE_SCALAR = 24, ENC_INVERSE_MATRIX = 12 };

void enc_inverses_init(struct enc_inverses *v, const struct enc_program *p);
void enc_inverses_clear(struct enc_inverses *v);
void enc_inverses_forget(struct enc_inverses *v);
/* norm and error of the slot's, or the system's, series in t: sizes and R are there. False where error is not below 1 (a matrix: is not finite). */
bool enc_inverse_find(struct enc_tail *t, int slot);
bool enc_inverse_matrix(struct enc_tail *t, int system);
/* Whether S is shown to be regular on the disc. After enc_inverse_matrix; tau: tails by slot. */
bool enc_inverse_regular(const struct enc_tail *t, int system);
/* |q| / (1 - error - norm tau), infinite if that is not positive. */
void enc_inverse_bound(mag_t r, const struct enc_inverse *v, const mag_t tau);

#endif
