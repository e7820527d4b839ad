/* How far a sparse matrix is from a singular one, proved. */
#ifndef SGA_NUM_LEAST_SINGULAR_H
#define SGA_NUM_LEAST_SINGULAR_H

struct lin_sparse;
struct lin_stairs;
struct sga_budget;

/* A lower bound of the smallest singular value of B (rows <= columns, independent, of lengths near 1), whose values are taken as exact;
 * 0 where none is proved: B is nearly singular (1e-13), its factor would be too full, or time is over.
 *
 * B B^T - s^2 I = L D L^T with D > 0, computed with roundings u, is E away from what it is of, |E_ij| <= gamma_k d_i d_j, d_i^2 the
 * diagonal and k the most terms of a sum (Demmel; Rump, Verification of positive definiteness, BIT 46 (2006) 433, 2.3; Verification
 * methods, Acta Numerica 2010, 10.8): no eigenvalue of B B^T is below s^2 - |E|. In doubles, then in double-doubles.
 * Cost: the factor of B B^T, some times. */
double num_least_singular(const struct lin_sparse *B, const struct sga_budget *budget);

/* The same of a matrix in stairs, from bounds s_g of its blocks: a right inverse R of it solves group by group, |R| <= |T| with T_gg = 1 / s_g and
 * T_gh = 1 / s_g sum_j |C_gj| T_jh, and the least singular value is at least 1 / |R|. Less than that of the whole by up to the couplings over the
 * singular values of each step; its factors fill within a group only. */
double num_least_singular_stairs(const struct lin_stairs *s, const struct sga_budget *budget);

#endif
