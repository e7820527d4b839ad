/* The pattern of J J^T and of its factor L D L^T, for rows of a sparse J: found once, for any values.
 *
 * J J^T is summed up from lists of products and factored row by row (Davis, Direct Methods for Sparse Linear Systems, 4.8);
 * order by AMD. Cost: what is filled. */
#ifndef SGA_LIN_GRAM_H
#define SGA_LIN_GRAM_H

#include <stdbool.h>

#include "arena.h"

struct lin_sparse;

/* One term of an entry of J J^T: row k of it is being summed up, the column is j, the term val[a] val[b]. */
struct lin_product { int j, a, b; };

struct lin_gram {
    struct sga_arena mem;
    int c;                         /* rows of J */
    int *order;                    /* row k of L is row order[k] of J */
    int *from;                     /* c + 1: the products of row k are from[k] .. */
    struct lin_product *product;
    int *column, *row;             /* L below its diagonal, by columns */
    int *left, *at, *place;        /* the same by rows: columns, and where each stands in `row` */
};

/* Most products of J J^T, and entries of L, for each entry of J (and some for nothing). */
struct lin_gram_most { int products, fill; };

/* False, and nothing is owned: they would be more, or J has no entries. J is not kept. Ended by lin_gram_clear. */
bool lin_gram_init(struct lin_gram *s, const struct lin_sparse *J, struct lin_gram_most most);
void lin_gram_clear(struct lin_gram *s);

#endif
