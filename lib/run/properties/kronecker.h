/* The Kronecker structure of a system that is linear with constant coefficients. */
#ifndef SGA_RUN_KRONECKER_H
#define SGA_RUN_KRONECKER_H

#include "expr.h"

struct job;
struct pencil;

/* Where the reduced system is A x' = B x + c(t), with functions of `restrict` as rows of B, and A, B
 * free of variables and time: its coefficients, each a rational number or an expression in the symbolic
 * parameters. */
struct kronecker_coefficient {
    int row, col;
    bool b;                    /* of B, otherwise of A */
    expr_id value;
};
struct kronecker_system {
    struct kronecker_coefficient *c;
    int count;
    size_t cap;
    int rows, cols;
    char reason[512];          /* why the system is not of this kind; "" where it is */
};

/* Reads the coefficients off the request's reduced system. What cannot be shown to be linear or constant
 * gives a reason, never a guess. Cost: one gradient for each row. */
void kronecker_read(struct job *j, struct kronecker_system *k);
void kronecker_system_clear(struct kronecker_system *k);

/* The pencil with symbolic parameters replaced: value[i] stands for parameter i of the system. False:
 * a coefficient is undefined there, or no rational number; then reason says which, and p is left empty. */
bool kronecker_pencil(struct job *j, struct kronecker_system *k, const fmpz *value, struct pencil *p);

/* *text, which the caller frees, is the JSON value of the member `kronecker`: an object with the structure, or {"reason"} where
 * the system has none. *has tells which. False: the budget ended (j->err is filled). */
bool kronecker_text(struct job *j, char **text, bool *has);

#endif
