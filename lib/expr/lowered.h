/* Functions and conditions that are written by other operators as they are read: every node of the store is one of the table's (expr.h).
 *
 * A condition is a function that is 1 where it holds and 0 where it does not. With s = sign(x), step(x) is 1 + s (1 - s)/2, so that it is 1 at 0
 * too, x > 0 is s (1 + s)/2, x == 0 is 1 - s^2. if(c, a, b) is c a + (1 - c) b, where the branch that is not taken has a value all the same:
 * arguments of its functions that might lie outside of their domains, or be 0 in denominators, are c u + (1 - c) p in the place of u, with a point p of the
 * domain. So where the branch is taken it is what it says, and undefined where that is; derivatives, switches and whatever else is asked of nodes follow
 * from the operators that are there. */
#ifndef SGA_EXPR_LOWERED_H
#define SGA_EXPR_LOWERED_H

#include "expr.h"

/*    symbol, name, arguments at the least, at the most (0: any number) */
#define LOWERED_TABLE(X) \
    X(IF, "if", 3, 3) X(STEP, "step", 1, 1) X(HYPOT, "hypot", 2, 0) X(LOG10, "log10", 1, 1) X(LOG2, "log2", 1, 1)

enum lowered_kind {
#define X(symbol, name, least, most) LOWERED_##symbol,
    LOWERED_TABLE(X)
#undef X
    LOWERED_COUNT
};

struct lowered {
    enum lowered_kind kind;
    const char *name;
    int least, most;
};
extern const struct lowered lowered_table[LOWERED_COUNT];
/* By its name, or NULL. */
const struct lowered *lowered_function(const char *name, size_t length);

enum logic { LOGIC_NONE, LOGIC_LESS, LOGIC_LESS_EQUAL, LOGIC_GREATER, LOGIC_GREATER_EQUAL, LOGIC_EQUAL, LOGIC_NOT_EQUAL, LOGIC_AND, LOGIC_OR, LOGIC_NOT };

/* Of two numbers; of two conditions; of one (NOT: b is not looked at). */
expr_id lowered_logic(struct expr_store *st, enum logic logic, expr_id a, expr_id b);
/* Of a call, its arguments in order; the first of IF is a condition. Cost of IF: the branches. */
expr_id lowered_call(struct expr_store *st, enum lowered_kind kind, const expr_id *arg, int args);

#endif
