/* Inside this folder: how a Jacobian is accumulated.
 *
 * Only the instructions that depend on a column take part. They and the columns have
 * ids: column j is id j, the i-th such instruction is id cols + i (in tape order), and
 * one last id, `sink`, stands for every operand that depends on no column. */
#ifndef SGA_NUM_JACOBIAN_PLAN_H
#define SGA_NUM_JACOBIAN_PLAN_H

#include "arena.h"
#include "tape_code.h"

struct num_jacobian;

struct jacobian_step {
    int32_t op, slot;
    int32_t a, b;        /* ids of the operands; TAPE_FACTOR and TAPE_COMPONENT: a is the
                            index in `solve`, b the component */
    double pa, pb;       /* partial derivatives at the last point */
};

/* The operands of a linear solve that depend on a column. */
struct jacobian_solve {
    struct tape_solve *of;
    int id;                                /* of its TAPE_FACTOR step, or sink */
    int edges;
    struct { int row, col, id; } *edge;    /* col -1: in the right-hand side */
    double *bar, *work;                    /* m each; bar is 0 between uses */
};

/* Lists of step numbers, increasing: list l is item[start[l]] .. item[start[l+1]-1],
 * or, where all[l], every step. */
struct jacobian_lists {
    int *start, *item;
    unsigned char *all;
};

struct num_jacobian_plan {
    struct sga_arena mem;      /* of all vectors below but lists.item */
    struct num_tape *tape;
    int steps, sink;
    struct jacobian_step *step;
    struct jacobian_solve *solve;
    int solves;
    int *root;                    /* id of each row's root, or sink */
    bool forward;
    struct jacobian_lists lists;  /* by row, or by column if forward */
    int *by_col, *entry_row, *entry;   /* the pattern by columns: row and place in CRS */
    double *sweep;                /* by id: adjoints or tangents; 0 between uses */
    double *out;                  /* the roots' values, where the caller wants none */
    struct sga_exec *memory;      /* for machine code, borrowed; NULL: swept for good */
    long runs;                    /* swept so far */
    struct num_tape *code;        /* all of it written out, as machine code; or NULL */
};

/* Fill tape's steps, solves, roots and sink. columns as in num_jacobian_new. */
void jacobian_steps(struct num_jacobian *j, const int *columns);
/* pa and pb of every step, at the point that the tape was evaluated last. */
void jacobian_partials(struct num_jacobian_plan *p);

/* jacobian_code.c: the roots, then the values, as one tape. Not where there are linear solves, or
 * where it would be very long. */
bool jacobian_may_be_code(const struct num_jacobian *j);
struct num_tape *jacobian_code(const struct num_jacobian *j);

#endif
