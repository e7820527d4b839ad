/* Inside the points folder: the equations for the logarithms of sizes, sum power_j s_j + log = 0, and their least squares solution. */
#ifndef SGA_POINTS_SCALING_ROWS_H
#define SGA_POINTS_SCALING_ROWS_H

#include <stdbool.h>
#include <stddef.h>

struct scaling_rows {
    int *start, count; size_t start_cap;            /* count + 1 */
    int *unknown; double *power; size_t cap, power_cap;
    double *log; size_t log_cap;                    /* by row */
};

/* Room for about so many. */
void scaling_rows_init(struct scaling_rows *r, int rows);
void scaling_rows_clear(struct scaling_rows *r);
/* A row without powers is left out. */
void scaling_rows_add(struct scaling_rows *r, const int *unknown, const double *power, int count, double log);
/* log[] (n) of least squares, of least norm where the equations leave it open; robust: rows that are far from it count by their distance only. Cost n^3 up to some dozens of unknowns; beyond,
 * some hundred walks through the rows for what is nearly a chain. */
void scaling_rows_solve(const struct scaling_rows *r, int n, bool robust, double *log);

#endif
