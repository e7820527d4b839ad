/* Inside the points folder: how an expression depends on one symbol. */
#ifndef SGA_POINTS_SHAPE_H
#define SGA_POINTS_SHAPE_H

struct expr_cone;
struct expr_store;

enum points_shape {
    POINTS_FREE,       /* not at all */
    POINTS_AFFINE,     /* slope and rest without it */
    POINTS_CURVED,     /* by rational operations, roots and rational powers */
    POINTS_HIDDEN      /* under a function that is none of these */
};

/* Of the cone's last node in each of its symbols, by the symbol's position in the indexed cone; what stands at positions of other nodes is of no use.
 * Cost: the cone, and once more for each 64 symbols to which more than one path leads. */
void points_shapes(const struct expr_store *st, const struct expr_cone *cone, unsigned char *shape);

/* Of each node of an indexed cone, by position in it; returns that of its last node. Cost: the cone. */
enum points_shape points_shape_in(const struct expr_store *st, const struct expr_cone *cone, int symbol, unsigned char *shape);

#endif
