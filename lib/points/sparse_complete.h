/* Inside the points folder: pivots for the rows that columns which are a guess left without. */
#ifndef SGA_POINTS_SPARSE_COMPLETE_H
#define SGA_POINTS_SPARSE_COMPLETE_H

#include <stdbool.h>

struct points_lu;
struct points_row;

/* Rows that are left, at most. */
enum { POINTS_MOST_LEFT = 64 };

/* lu is an elimination in some columns alone of rows whose entries are `row`: each row that it left without a pivot gets one in any column,
 * by what its operations make of the whole row, the largest beside its norm first, or depends on the others (`tiny` as in
 * points_lu_factor). Its pivots are then
 * as many as the rank; its operations and U know nothing of those that came. False: too many rows are left, or what is left of one is neither
 * large nor nothing. Cost: the operations for each row that is left. */
bool points_complete(struct points_lu *lu, const struct points_row *row, const double *norm, double tiny);

#endif
