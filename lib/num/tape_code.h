/* Inside this folder: what a tape is made of. Executors (the interpreter, machine code)
 * and derivatives read it; tape.c and jacobian_code.c build it. */
#ifndef SGA_NUM_TAPE_CODE_H
#define SGA_NUM_TAPE_CODE_H

#include <stdint.h>

#include "tape.h"

/* Beyond the operators of the store: */
enum {
    TAPE_SQUARE = EXPR_OP_COUNT,   /* a^2 and a^3, the usual powers */
    TAPE_CUBE,
    TAPE_SINCOS,      /* sin a here, cos a in the next slot, which is a TAPE_PAIRED */
    TAPE_PAIRED,      /* written by the instruction before */
    TAPE_FACTOR,      /* factor linear solve a, and solve it; the slot itself is unused */
    TAPE_COMPONENT,   /* component b of the solution of linear solve a */
    TAPE_SIGNAL,      /* derivative number b & 255 of table b >> 8 at the time a */
    TAPE_SLOPE_A,     /* the partial derivative of the instruction whose slot is a by its first operand, */
    TAPE_SLOPE_B      /* by its second */
};

/* Instruction i writes slot `code_slot + i`; a and b are slots, or what the operator says. */
struct tape_code {
    int32_t op, a, b;
};

struct tape_solve {
    int m, slot;               /* slot of its TAPE_FACTOR */
    int *matrix, *rhs;         /* slots, m*m by rows and m */
    double *lu, *y, *work;     /* the factors, the solution, m words */
    int *perm;
    int factored;              /* an earlier solve with the same matrix, whose lu and perm these are; -1: its own */
    bool singular;
};

struct num_tape {
    int ninputs, nroots;
    int code_slot;             /* inputs, then constants, come before the code */
    int ncode, nstatic;        /* code[0 .. nstatic) does not depend on inputs, */
    int ntimed;                /* code[nstatic .. ntimed) depends on time alone */
    struct tape_code *code;
    int slots;                 /* code_slot + ncode */
    double *value;             /* by slot; then the time that machine code has the timed slots for */
    double *low;               /* by constant: what its double leaves of it */
    int *root;                 /* slots */
    struct tape_solve *solve;
    int nsolves;
    /* Switches: which, the first of its three constants (num_tape_hold), and the slot of its sign or 0. */
    struct tape_switch { int of, slot, sign; } *held;
    int nheld;
    const struct expr_table **table;   /* borrowed */
    int ntables;
    struct sga_exec *memory;   /* for machine code, borrowed; NULL: interpreted for good */
    long runs;                 /* interpreted so far */
    /* Or NULL; in `memory`. The last input is in its slot, and so are the others unless reads_inputs;
     * `in` has them all but the last. The roots' values go to out and, from first_roots on, to rest. */
    void (*compiled)(double *value, double *out, double *rest, const double *in);
    bool reads_inputs;         /* the machine code does, from `in` */
    int first_roots;
    struct tape_stages *stages[2]; /* machine code of whole steps, plain and aside, once they were asked for; or NULL */
    bool keep_all;             /* machine code leaves all values in their slots */
};

/* The value of an instruction TAPE_SIGNAL, or with `more` 1 its derivative by time. */
double tape_signal(const struct num_tape *t, const struct tape_code *c, int more);

/* The instruction reads slots a and b, or slot a alone (not for TAPE_PAIRED and what belongs to linear solves). */
static inline bool tape_reads_two(int op)
{
    return op < EXPR_OP_COUNT && expr_op_args((enum expr_op)op) == 2;
}

/* The timed slots are not those of any time. */
void tape_forget_time(struct num_tape *t);
/* Run code[from .. to) on t->value. */
void tape_run(struct num_tape *t, int from, int to);
/* What libm does not have: x^n by squaring; NaN in, NaN out, on either side; NaN for a negative base. */
double tape_power(double x, int n);
double tape_least(double x, double y);
double tape_greatest(double x, double y);
double tape_sign(double x);
double tape_real_power(double x, double y);
/* jacobian_partials.c: the partial derivative of the instruction with this slot by its first or
 * second operand, at the values that the slots have. */
double tape_slope(const struct num_tape *t, int slot, bool by_second);
/* As num_tape_eval, the roots from t->first_roots on to `rest`. */
bool tape_eval_parts(struct num_tape *t, const double *in, double *out, double *rest);
/* As num_tape_eval, and every slot has its value afterwards. */
bool tape_eval_all(struct num_tape *t, const double *in, double *out);

#endif
