/* Truncated power series (jets) through an evaluation tape: from the coefficients of the
 * inputs those of the roots, order by order, so that a series along a flow can be built
 * (x_{k+1} = f_k / (k + 1)). In double, and in double-double.
 *
 * Coefficients are those of s -> value(t + s scale), that is multiplied by scale^k: the
 * caller chooses the scale by what is put into the time's row (its coefficient 1 is the
 * scale), and large orders neither over- nor underflow.
 *
 * Recurrences: Griewank and Walther, Evaluating Derivatives, ch. 13; a linear solve is
 * factored once for all orders. Where a function has no series (sqrt at 0) the coefficients
 * are not finite. abs, sign, min, max follow the side where the motion is; where it leaves
 * that side is what num_jet_reach says. Cost of order k: about k multiplications for each
 * instruction. */
#ifndef SGA_NUM_JET_H
#define SGA_NUM_JET_H

#include "dd.h"

struct num_tape;
struct sga_exec;

struct num_jet;      /* in double */
struct num_jet2;     /* in double-double */
struct num_jet_programs;

/* For orders 0 .. order. The tape is read now only, and may be freed before. */
struct num_jet *num_jet_new(const struct num_tape *t, int order);
void num_jet_free(struct num_jet *j);
/* The order + 1 coefficients of input i (to be set by the caller) and of root r. */
double *num_jet_input(struct num_jet *j, int i);
const double *num_jet_root(const struct num_jet *j, int r);
/* Coefficient k of everything, those of the inputs up to k and all of lower orders being
 * there. False where that of a root is not finite. */
bool num_jet_next(struct num_jet *j, int k);
/* The first `count` inputs follow the roots of the same number, the next and last one is the time: coefficients 1 .. order
 * of x' = scale root from those of order 0, by order into series (order + 1 rows of count), where row 0 is set. False where
 * one is not finite. What the functions above say is not current after it. 1 <= order. */
bool num_jet_along(struct num_jet *j, int count, int order, double t, double scale, double *series);
/* After order k: the least s in (0, 1] at which the argument of an abs, sign, min or max
 * is seen to change sign, INFINITY where none does. Sampled: two changes that lie close together are missed. */
double num_jet_reach(const struct num_jet *j, int k);
/* The sides that the tape holds its switches on, from now on. */
void num_jet_hold(struct num_jet *j, const struct num_tape *t);
/* Instructions that each order runs. */
int num_jet_length(const struct num_jet *j);
/* As num_tape_compile, for num_jet_along (always of the same count). Not where the tape solves or switches. Values differ by
 * roundings from the interpreter's. kept: see below; or NULL. */
void num_jet_compile(struct num_jet *j, struct sga_exec *memory, struct num_jet_programs *kept);
bool num_jet_compiled(const struct num_jet *j);

/* What jets have made machine code of stays when they end, and serves those that come after with the same steps, whatever their
 * constants: values are the same to the bit. `memory` must outlive it, and it the jets that are given it. */
struct num_jet_programs *num_jet_programs_new(void);
void num_jet_programs_free(struct num_jet_programs *p);      /* NULL is allowed */

/* num_jet_along will run a program without branches: no solves, no switches. */
bool num_jet_straight(const struct num_tape *t);

struct num_jet2 *num_jet2_new(const struct num_tape *t, int order);
void num_jet2_free(struct num_jet2 *j);
num_dd *num_jet2_input(struct num_jet2 *j, int i);
const num_dd *num_jet2_root(const struct num_jet2 *j, int r);
bool num_jet2_next(struct num_jet2 *j, int k);
num_dd num_jet2_reach(const struct num_jet2 *j, int k);
/* The sides that the tape holds its switches on, from now on. What is held does not end at num_jet2_reach. */
void num_jet2_hold(struct num_jet2 *j, const struct num_tape *t);
/* The first place in (0, 1] where x_0 + x_1 s + .. + x_k s^k leaves its side (1, -1), on which it begins or is 0; INFINITY: none
 * that is deeper than 1e-29 of the sum of the terms. Changes closer together than 1e-11 are not told apart. work: 3 (k + 1) numbers. */
num_dd num_jet2_change(const num_dd *x, int k, int side, double *work);
int num_jet2_length(const struct num_jet2 *j);

#endif
