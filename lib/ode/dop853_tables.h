/* Inside the ode folder: the numbers of the Dormand-Prince method of order 8 with error
 * estimates of order 5 and 3 and dense output of order 7, as published: P. J. Prince and
 * J. R. Dormand (1981); E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary
 * Differential Equations I, 2nd ed., II.5 and II.6. The tests check the order conditions.
 *
 * Stage s is at t + c[s] h and x + h sum a[s] k. Stage 12 is the end of the step itself
 * (its row is the weights b); 13 to 15 are for dense output only. */
#ifndef SGA_ODE_DOP853_TABLES_H
#define SGA_ODE_DOP853_TABLES_H

/* Nonzero coefficients of a linear combination of stages. */
struct dop853_row {
    int count;
    int stage[12];
    double a[12];
};

enum { DOP853_STAGES = 12, DOP853_END = 12, DOP853_ALL = 16 };

extern const double dop853_c[DOP853_ALL];
extern const struct dop853_row dop853_a[DOP853_ALL];
extern const struct dop853_row dop853_error5;   /* b minus the weights of order 5 */
extern const struct dop853_row dop853_weights3; /* the weights of order 3 */
extern const struct dop853_row dop853_dense[4]; /* coefficients 3..6 of the polynomial */

#endif
