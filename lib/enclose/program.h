/* Inside the enclose folder: a vector field as straight-line code whose steps have simple rules
 * for power series.
 *
 * Each slot is one function of time along a solution. Slots 0 .. n-1 are the variables, slot n
 * is time, the others follow their operands. What is not rational is reduced to one rule: for
 * u = f(x) another slot g holds f'(x), so that u' = g x' (g may depend on u itself: exp, tan).
 * Griewank & Walther, Evaluating Derivatives, 2nd ed., section 13.2. */
#ifndef SGA_ENCLOSE_PROGRAM_H
#define SGA_ENCLOSE_PROGRAM_H

#include <arb.h>
#include <stdbool.h>

#include "expr.h"

enum enc_op {
    ENC_INPUT,
    ENC_INTEGER,    /* a itself */
    ENC_CONSTANT,   /* number a of the store; -1: pi */
    ENC_PIECE,      /* number a of the tables' pieces, constant in each */
    ENC_ADD, ENC_SUB, ENC_NEG, ENC_MUL, ENC_DIV, ENC_SQRT,
    ENC_FUN,        /* u = fun(a): u' = sign g a'; fun POW: of exponent b, a constant slot */
    ENC_ATAN2,      /* u = atan2(a, b): u' = g a' - g2 b' */
    ENC_CHOICE,     /* abs, sign, min, max */
    ENC_SOLVE       /* component b of system a */
};

struct enc_code {
    enum enc_op op;
    enum expr_op fun;
    int a, b, g, g2, sign;
    bool aux;                /* only for the derivatives of others */
    bool varies, state;      /* depends on an input; on a variable */
    bool scaled;             /* k times the k-th coefficient is wanted */
};

struct enc_system {
    int m;
    int *matrix, *rhs;       /* slots */
    int first;               /* slot of the first component; the others follow */
};

struct enc_program {
    const struct expr_store *st;
    const struct enc_tables *tables;     /* NULL: there are none */
    int n;                   /* variables */
    int slots; struct enc_code *code; size_t cap;
    struct enc_system *system; int systems; size_t system_cap;
    int roots, *root;        /* slots */
};

/* What a program is of: functions of the symbols variable[0..n), of time and of tables. */
struct enc_of {
    const struct expr_store *st;
    const int *variable; int n, time;
    const struct enc_tables *tables;     /* borrowed; or NULL */
};

/* The program of roots[0..count). False with err where a root has no value (EXPR_UNDEFINED) or uses another symbol (EXPR_NAME). Store and
 * tables must outlive the program. */
bool enc_program_init(struct enc_program *p, const struct enc_of *of, const expr_id *roots, int count, struct sga_error *err);
void enc_program_clear(struct enc_program *p);

/* The value of a step that does not depend on its operands' derivatives, from its operands':
 * everything but inputs and SOLVE. Not finite where the function has no value on the balls. */
void enc_value(arb_t r, const struct enc_program *p, const struct enc_code *c, arb_srcptr x, arb_srcptr y, slong prec);

#endif
