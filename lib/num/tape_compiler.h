/* Inside this folder: the compiler of straight-line code, for those who compile more than one tape at once.
 *
 * tape_jit.c has all of it. Slots from t->slots on are the caller's own: values that are read next of all. */
#ifndef SGA_NUM_TAPE_COMPILER_H
#define SGA_NUM_TAPE_COMPILER_H

#include <limits.h>

#include "x64.h"

enum { REGISTERS = 15, SCRATCH = 15, NONE = -1, NEVER = INT_MAX, OWN_SLOTS = 5 };

struct compiler {
    struct x64 code;
    struct num_tape *t;
    int *after_a, *after_b, *after;    /* by instruction: who reads its operands, and its value, next */
    int *next;                         /* by slot: the next instruction that reads it, or NEVER */
    int held[REGISTERS];               /* the slot whose value a register has, or NONE */
    signed char *where;                /* by slot: its register, or NONE */
    unsigned char *unsaved;            /* by slot: its value is not in memory */
    int *root, *next_root;             /* by slot, by root: the first (another) root that has this value, or NONE */
    unsigned char *delivered;          /* by root: stored among the results */
    bool stages;                       /* inputs come in registers, or are in their slots; the first roots stay for the caller */
    bool timed;                        /* calls are saved by keeping the timed slots from one time to the next */
    int rest_at;                       /* where this stage's rest begins */
};

void compiler_begin(struct compiler *c, struct num_tape *t);
void compiler_end(struct compiler *c);
/* c->next as before instruction `from`. With `stages` the first roots are read after the last one. */
void compiler_find_uses(struct compiler *c, int from);
/* c->code.leaf, c->timed, t->reads_inputs. */
void compiler_look(struct compiler *c);
void compiler_instruction(struct compiler *c, int i);
/* A register whose value is not needed any more, or last of all; not one of the two. */
int compiler_register(struct compiler *c, int not_this, int nor_this);
void compiler_bind(struct compiler *c, int reg, int slot);
void compiler_release(struct compiler *c, int reg);
void compiler_load(struct compiler *c, int reg, int slot);
/* Stores the value among the results, wherever it is one of them. */
void compiler_deliver(struct compiler *c, int reg, int slot);
/* Results that are inputs or constants, or that a call left in memory. */
void compiler_deliver_rest(struct compiler *c);

#endif
