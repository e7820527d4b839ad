/* Inside the points folder: an elimination at work, of all rows or of the rest of one. */
#ifndef SGA_POINTS_SPARSE_WORK_H
#define SGA_POINTS_SPARSE_WORK_H

#include "arena.h"
#include "sparse.h"

struct points_list {
    int *item;
    size_t cap;
    int count;
};

struct points_work {
    struct points_lu *lu;
    unsigned char *done;
    const double *norm;           /* by row: first largest entry */
    struct points_list *by_length, *meet;
    int *count;                   /* by column: rows that are not done and have an entry there */
    int *at;                      /* by column: where the row in work has it, if the row says so too */
    int lowest;
    double tiny;
    double budget;                /* multiplications until it pauses */
    const unsigned char *first;   /* by column: twice the logarithm of how many rows it was in; NULL: rows are not cut */
    const unsigned char *kept;    /* by column: pivots of an earlier elimination, which come first and are not cut; or NULL */
    int others;                   /* so many other entries of a row are left, once there are twice as many */
};

/* What an elimination and those of its rest have in common. */
struct points_problem {
    int rows, cols;
    double tiny;
    const double *norm;           /* by row */
    const unsigned char *first;   /* by column, as in points_work */
};

/* All in mem but what lists and lu own; the budget has no end, and rows are not cut. Cost: linear. */
void points_work_begin(struct points_work *w, struct sga_arena *mem, struct points_lu *lu, struct points_row *row, const struct points_problem *p,
                       double tiny);
/* As far as the budget goes; false: it is over before the rows are. */
bool points_work_run(struct points_work *w);
void points_work_end(struct points_work *w);
/* Row i is found by its length, which has changed. */
void points_work_file(struct points_work *w, int i);

/* Leaves `others` entries of a row beside those in kept columns, where there are twice as many. Cost: linear in the row. */
void points_cut_row(struct points_work *w, int i);

/* What is left to do is done by columns: a guess at those of all pivots, by rows that are cut, then an elimination in these alone. w is then
 * through, and its lu whole. False: that led to no pivots that are regular, or known to be all there are; nothing has changed. */
bool points_rest_by_columns(struct points_work *w, const unsigned char *first);

#endif
