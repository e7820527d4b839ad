/* Inside the sga folder: the echelon form of rows over node handles. */
#ifndef SGA_SGA_ECHELON_H
#define SGA_SGA_ECHELON_H

#include "expr.h"

struct expr_facts;
struct points_oracle;
struct sga_budget;
struct sys_entry;

struct ech_op {
    int pivot;             /* index of the pivot row that was subtracted ... */
    expr_id factor;        /* ... times this */
};

struct ech_row {
    struct sys_entry *entry; int entries; size_t cap;
    expr_id rhs;
    expr_id rest;          /* a right side that was found to vanish, before it became the constant 0 */
    int source;            /* row of the system, or rows + index of the constraint whose tangency it is */
    struct ech_op *op; int ops; size_t op_cap;
};

struct ech_pivot {
    int col;
    expr_id value;
    int generation;
    struct ech_row row;    /* still holds the pivot entry */
};

/* A dense block: its pivot rows are S^-1 times the rows that they came from. */
struct ech_dense {
    int first, size;       /* of its pivots */
    struct expr_rows matrix;   /* S, size x size, in the order of the pivots */
};

struct echelon {
    int cols;
    struct ech_pivot *pivot; int pivots; size_t pivot_cap;
    int *pivot_of;         /* by column: index, or -1 */
    expr_id *work;         /* by column, 0 between uses */
    unsigned char *mark;
    int *touched;
    struct ech_dense *block; int blocks; size_t block_cap;   /* their determinants are assumed not 0 */
};

/* What the elimination asks of its surroundings. */
struct ech_context {
    struct expr_store *st;
    struct expr_facts *facts;
    struct points_oracle *oracle;
    const double *near; double near_time;    /* by variable: where a motion is to start; or NULL */
    const unsigned char *near_given;         /* by variable: that value was given; NULL: all were */
    bool near_pivots;      /* entries that are small there, beside what they are in general, are pivots only where there are no others */
    bool wait;             /* ... and not yet: rows that have no others are left with their entries */
    const struct sga_budget *budget;
    bool record;           /* keep the operations, for the combinations */
    struct sga_error *err;
};

void ech_init(struct echelon *e, int cols);
void ech_clear(struct echelon *e);
/* Each pivot has its column to itself and its row still holds it; blocks are of pivots. Linear in the pivots. */
bool ech_sane(const struct echelon *e);
void ech_row_clear(struct ech_row *row);
void ech_row_push(struct ech_row *row, int col, expr_id value);

/* 1 zero on the present set, 0 not, -1 undecided (err is filled). */
int ech_zero(const struct ech_context *c, expr_id e);

/* Reduce the rows by the pivots so far, then by each other: pivots are chosen sparse
 * first, constants before functions, and only among entries decided not to be zero. Rows
 * that get a pivot move into the echelon form (emptied in `row`); the others end without
 * entries: where their right side is not zero on the present set they are left with it,
 * otherwise rhs is the constant 0. Where c->wait, rows may be left that wait for better pivots. False: undecided or out of budget. */
bool ech_eliminate(struct echelon *e, const struct ech_context *c, struct ech_row *row, int rows, int generation);

#endif
