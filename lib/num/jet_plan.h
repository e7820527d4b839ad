/* Inside this folder: a tape taken apart into steps that have a recurrence for series. */
#ifndef SGA_NUM_JET_PLAN_H
#define SGA_NUM_JET_PLAN_H

#include "dd.h"

struct expr_table;
struct num_tape;

enum jet_op {
    JET_ADD, JET_SUB, JET_NEG, JET_MUL, JET_SQUARE, JET_DIV,
    JET_AFFINE,      /* w = sign a + shift */
    JET_INVERSE,     /* w = 1/a */
    JET_DERIVATIVE,  /* w_k = k a_k */
    JET_EXP,         /* x = derivative of a */
    JET_TRIG,        /* w = sin a, y = cos a; x = derivative of a; sign +1: sinh, cosh */
    JET_TAN,         /* w, y = 1 + sign w^2; x = derivative of a; sign -1: tanh */
    JET_QUOTIENT,    /* w' x = sign a', value at order 0 by `function`; y = derivative of w */
    JET_ATAN2,       /* of a, b: x = a^2 + b^2, y = derivative of w, p, q = of a, b */
    JET_SQRT,
    JET_POWER,       /* w = a^b, b without dependence; x, y = derivatives of a, w; shift 3: cube root */
    JET_ABS, JET_SIGN, JET_MIN, JET_MAX,   /* x = what switches */
    JET_SOLVE,       /* linear solve a */
    JET_TABLE        /* w = derivative number b & 255 of table b >> 8 at the time a, of which it is a polynomial */
};

struct jet_code {
    int op, w, a, b, x, y, p, q;     /* rows */
    int sign, shift;
    enum expr_op function;
};

struct jet_solve {
    int m;
    int *matrix, *rhs, *y;      /* rows */
};

struct jet_plan {
    int inputs, roots, rows;
    int count, fixed;           /* code[0 .. fixed) depends on no input */
    struct jet_code *code;
    int *root;                  /* rows */
    int *turn; int turns;       /* rows whose changes of sign end the series */
    struct jet_solve *solve; int solves;
    const struct expr_table **table; int tables;      /* borrowed: they outlive the series */
    int constants, first_constant;    /* rows first_constant .. + constants */
    num_dd *constant;
    unsigned char *flat;        /* by row: depends on no input */
};

void jet_plan_make(struct jet_plan *p, const struct num_tape *t);
void jet_plan_clear(struct jet_plan *p);

#endif
