/* Inside this folder: what the code of series is put together from: acts on sixteen registers and on slots, without
 * branches, to be performed by a loop (jet_machine.c) or made into machine code, with the same results to the bit. Registers:
 * 0 sums, 1 .. 3 are lost by them, 4 .. 6 scalars, 7 .. 14 the newest coefficients, in turn, 15 not used. */
#ifndef SGA_NUM_JET_MAKER_H
#define SGA_NUM_JET_MAKER_H

#include "jet_plan.h"

enum { JET_SPARE = 6, JET_RING = 7, JET_RING_END = 15, JET_ENDLESS = 1 << 20, JET_PAIRS_FROM = 3 };

enum jet_act_kind {
    ACT_MOVE,                  /* to = from */
    ACT_LOAD, ACT_STORE,       /* to, slot */
    ACT_ADD, ACT_SUB, ACT_MUL, ACT_DIV,                           /* to = to op from */
    ACT_ADD_SLOT, ACT_SUB_SLOT, ACT_MUL_SLOT, ACT_DIV_SLOT,       /* to = to op slot */
    ACT_SQRT, ACT_NEGATE, ACT_ZERO,                               /* to = sqrt from; to = -to; to = 0 */
    ACT_PRODUCT,               /* to = slot other, where number is 2 twice that; */
    ACT_ADD_PRODUCT, ACT_SUB_PRODUCT,      /* added to or subtracted from `to`, by way of register `from` */
    ACT_STORE_BOTH,            /* to, slot and other */
    ACT_PRODUCTS,              /* to = the sum of `number` products slot[i] other[i], of which `other` is even, see jet_machine.c */
    ACT_OUT,                   /* series[slot] = to */
    ACT_LEAVE,                 /* where `number` is the last order */
    ACT_CALL,                  /* register 0 = the function `number` of it; other registers are lost */
    ACT_REAL_POWER,            /* register 0 = that to the power of register 1; others are lost */
    ACT_SINCOS                 /* of register 0 to the two slots; registers are lost */
};

/* Slots of products may be registers: r - JET_REGISTERS. */
enum { JET_REGISTERS = 16 };
struct jet_act {
    unsigned char kind, to, from;
    short number;
    int slot, other;
};

struct jet_maker {
    struct jet_act *act;
    size_t count, cap;
    const struct jet_plan *p;
    int stride;                /* even */
    int k;                     /* the order that is being made */
    int *degree;               /* by row: coefficients beyond are 0 */
    int *reversed;             /* by row: the slot of coefficient 0 of its copy that runs downwards, or -1 */
    int *held;                 /* by row: the register that has coefficient k, or -1 */
    int *made;                 /* by row: when in order k it was made; 0: before */
    int holds[16];             /* by register: the row, or -1 */
    int ring, clock, turn;
    bool wide;                 /* an order takes so long that what the one before has stored is in memory */
    int at, *last;             /* the instruction; by row: the last one in an order that reads coefficient k */
    unsigned char *lasting;    /* by row: later orders read it too */
    unsigned char *owed;       /* by row: coefficient k is not in memory yet */
    int whole, reciprocal;     /* slots of 0, 1, 2, ... and of 1/1, 1/2, ... */
    int part;                  /* slots of scale/1, scale/2, ... */
};

/* The products a_i b_j of a sum with i + j fixed that wait for coefficients of the present order: at most two. */
struct jet_late { int count, a[2], i[2], b[2], j[2]; };

static inline int jet_slot(const struct jet_maker *m, int row, int i) { return row * m->stride + i; }

/* One act. */
void jet_do(struct jet_maker *m, enum jet_act_kind kind, int to, int from);
void jet_at(struct jet_maker *m, enum jet_act_kind kind, int to, int slot);
/* A new order: nothing is in registers. */
void jet_forget(struct jet_maker *m);
void jet_next_order(struct jet_maker *m);
int jet_fresh(struct jet_maker *m);                                    /* a register for a new coefficient */
void jet_hold(struct jet_maker *m, int reg, int row);                  /* has coefficient k of row */
void jet_put(struct jet_maker *m, int reg, int row);                   /* the same, and it is stored */
void jet_keep(struct jet_maker *m, int reg, int row, int i);           /* coefficient i is stored */
void jet_get(struct jet_maker *m, int to, int row, int i);             /* coefficient i */
/* op: ACT_ADD .. ACT_DIV. */
void jet_with(struct jet_maker *m, enum jet_act_kind op, int to, int row, int i);
/* sum_{i < n} a_{first_a + i} b_{first_b + n - 1 - i} into register `to`, save the late terms. False: nothing but these, and
 * `to` as it was. */
bool jet_sum(struct jet_maker *m, int to, int a, int first_a, int b, int first_b, int n, struct jet_late *late);
/* to = to op each late term (twice it); `begun` as jet_sum has said: where not, to is set, and must be added to. */
bool jet_add_late(struct jet_maker *m, enum jet_act_kind op, int to, bool begun, bool twice, const struct jet_late *late);
/* Twice a sum of products, and the square in the middle where k is even. */
bool jet_double(struct jet_maker *m, int to, bool begun, int a, int k);
/* to = 0 where nothing has begun. */
void jet_finish(struct jet_maker *m, int to, bool begun);

/* jet_first.c. Coefficient 0 of one instruction, with the bits that the recurrences have. False: it is left to these. */
bool jet_first(struct jet_maker *m, const struct jet_code *c, int inverse);

#endif
