/* Corrections of least norm by the normal equations: d = -J^T (J J^T)^-1 r, where J has
 * independent rows. The quick way for rows that are well apart, as those of constraints near a
 * known point mostly are; the condition is squared, so what is less certain is left to
 * lin_kkt or to a QR.
 *
 * J J^T is summed up along a pattern found once (lin_gram.h) and factored as L D L^T by SuiteSparse's LDL. */
#ifndef SGA_LIN_NORMAL_H
#define SGA_LIN_NORMAL_H

#include <stdbool.h>

struct lin_gram;
struct lin_normal;
struct lin_sparse;

/* For this pattern of J (copied). NULL where J J^T or L would be much fuller than J. Freed with
 * lin_normal_free (NULL is allowed). */
struct lin_normal *lin_normal_new(const struct lin_sparse *J);
void lin_normal_free(struct lin_normal *s);
/* The pattern of J J^T, borrowed. */
const struct lin_gram *lin_normal_gram(const struct lin_normal *s);

/* d (cols) from r (rows) and J's values, in the order of the pattern's entries. False, and d undefined:
 * a row is nearly (1e-3 of its length) a combination of others, or a value is not finite. The relative error of d
 * is some 1e6 roundings at most. */
bool lin_normal_step(struct lin_normal *s, const double *val, const double *r, double *d);

/* The same in two parts: factors, and d from them as often as asked. `least`: what must be left of each row's length once the rows
 * before it are taken out (1e-3 above; the error of d grows with the square of 1 / least). val is the one that was factored. */
bool lin_normal_factor(struct lin_normal *s, const double *val, double least);
bool lin_normal_solve(struct lin_normal *s, const double *val, const double *r, double *d);

#endif
