/* A wide sparse matrix whose rows come in groups, each with columns that no group before it has: block triangular, with wide blocks on the
 * diagonal, as the differentials of constraints are, whose later generations hold variables that the earlier ones do not.
 *
 * With M_g the rows of group g in the columns that are new there, and C_g the same rows in columns of earlier groups, J d = -r is solved group by
 * group, d_g = -M_g^+ (r_g + C_g d): factors fill within a group only, and conditions are those of one. In a group d_g has least norm; with one group d is
 * the correction of least norm (lin_normal.h). */
#ifndef SGA_LIN_STAIRS_H
#define SGA_LIN_STAIRS_H

#include <stdbool.h>

#include "arena.h"

struct lin_normal;
struct lin_sparse;

struct lin_stair {
    struct lin_sparse *M;          /* with its values */
    int *row, *col;                /* of M in J */
    int *entry;                    /* of M's entries in J */
    struct lin_normal *normal;
};

struct lin_stairs {
    struct sga_arena mem;
    const struct lin_sparse *J;    /* borrowed */
    int groups;
    struct lin_stair *at;
    int *of_column;                /* by column: the group in which it is new; -1: in none */
    double *work;
};

/* group (rows of J; NULL: all are one): 0 .. groups - 1. The values are those of J. False: a group has fewer new columns than rows, or a row of it none.
 * Ended by lin_stairs_clear in every case. Cost: linear for each group: a few are meant. */
bool lin_stairs_init(struct lin_stairs *s, const struct lin_sparse *J, const int *group, int groups);
void lin_stairs_clear(struct lin_stairs *s);
/* J has other values now, in the same pattern. */
void lin_stairs_take(struct lin_stairs *s);

/* Factors of each M_g M_g^T. False: they would be much fuller than M_g, or less than `least` of a row's length is left once the rows before it are
 * taken out. */
bool lin_stairs_factor(struct lin_stairs *s, double least);
/* d (columns of J) with J d = -r. False: not finite. The relative error is that of lin_normal in each group. */
bool lin_stairs_solve(struct lin_stairs *s, const double *r, double *d);

#endif
