/* Inside the points folder: constraints and their differentials at a point. */
#ifndef SGA_POINTS_DIFFERENTIALS_H
#define SGA_POINTS_DIFFERENTIALS_H

#include "arena.h"
#include "points.h"

/* The constraints' cones, and a sparse Jacobian by rows with ball values. */
struct points_jacobian {
    struct sga_arena mem;          /* of all below but the cone's */
    const struct points_space *space;
    struct expr_cone all;          /* cone of all constraints */
    expr_id **cone; int *cone_len; /* by constraint */
    int *column;                   /* by symbol: variable index or -1 */
    int **col; int *cols;          /* by constraint: structural columns */
    arb_ptr *entry;                /* by constraint: values in that order */
    arb_ptr grad;                  /* by variable */
    struct num_ball_room room;
};

void points_jacobian_init(struct points_jacobian *j, const struct points_space *space);
void points_jacobian_clear(struct points_jacobian *j);
/* Values of the constraints at the ball's symbols (into ball->value). */
void points_jacobian_values(struct points_jacobian *j, struct num_ball *ball);
/* The differential of constraint i into grad, by variable; its values must be known. */
void points_jacobian_row(struct points_jacobian *j, struct num_ball *ball, int i);
/* Entries; values must be known. */
void points_jacobian_entries(struct points_jacobian *j, struct num_ball *ball);
/* log2 of the largest entry of row i, in units of the variables' scales (powers of 2, or NULL: all are 1), or a very small number. */
slong points_row_exponent(const struct points_jacobian *j, int i, const int *scale);
/* v / 2^exponent, its middle. */
double points_scaled(const arb_t v, slong exponent);

#endif
