/* Inside and above the points folder: powers of two for variables whose natural sizes lie
 * far apart (1e150 y^2 - 1e-150 x = 0 has its points near y = 1e-150 sqrt(x)).
 *
 * Terms of a sum, and of a row A x' = alpha, should be of one size, arguments of elementary
 * functions near 1: linear equations for the logarithms of the variables' sizes, solved by
 * least squares (geometric scaling, Fulkerson & Wolfe 1962, for nonlinear terms). */
#ifndef SGA_POINTS_SCALING_H
#define SGA_POINTS_SCALING_H

#include "warnings.h"
#include "expr.h"

struct scaling;
/* NULL for more than SCALING_MOST variables. */
enum { SCALING_MOST = SGA_MOST_SCALED };
struct scaling *scaling_new(const struct expr_store *st, const int *variable, int variables);
/* The size of time is an unknown too, and a velocity's size that of its variable over it; otherwise time counts as 1. */
void scaling_time(struct scaling *w, int symbol);
void scaling_free(struct scaling *w);
/* Whether time was met in what was added. */
bool scaling_has_time(const struct scaling *w);
/* A sum begins: what is added until the next one is of one size. */
void scaling_sum(struct scaling *w);
/* The terms of e, times the velocity of a variable (by index; -1: none). */
void scaling_add(struct scaling *w, expr_id e, int velocity);
/* Whether some terms were left out: too many. */
bool scaling_cut(const struct scaling *w);
/* Variable j (the number of variables: time) is about as large as 2^log, with a weight (an equation's: 1). */
void scaling_anchor(struct scaling *w, int j, double log, double weight);
/* log2 of the largest term of e, for variables of the sizes log[] (time's last); -INFINITY for 0. */
double scaling_size(struct scaling *w, expr_id e, const double *log);
/* As scaling_solve, unbounded and never NULL: log[] (by unknown: the variables, then time where that is one). */
void scaling_logs(struct scaling *w, double *log);
/* By variable, log2 of its size, bounded so that doubles can hold it; NULL where all are
 * near 1 or nothing is known. The caller frees it. */
int *scaling_solve(struct scaling *w);
/* The same of logarithms. */
int *scaling_rounded(const double *log, int count);

#endif
