/* Inside the follow folder: the surfaces at which a system jumps, and the system with its switches there at given values. */
#ifndef SGA_RUN_SURFACES_H
#define SGA_RUN_SURFACES_H

#include "switches.h"

struct sga_arena;
struct sga_budget;
struct sga_solution;
struct sys_system;

struct surfaces {
    const struct sys_system *sys;
    struct num_switches w;
    int count;
    expr_id *function;        /* by surface: its sign is the switch */
    int *of; signed char *sign;   /* by switch of w: its surface, and the sign that its argument has beside it; or -1: it stays as it is written */
};

/* Those of sign, and of abs in a divisor (functions of time too: where they jump, slides may end): arguments that are multiples of each other have one surface. Switches of abs, min
 * and max with the same surface are of it too, and those of expressions beside the system. every (or NULL): all switches have one, and those are one that are multiples where the constraints hold, as they are at the
 * point x (or NULL) at time t. In mem, but for w. */
struct surfaces_every { const struct sga_solution *sol; const double *x; double t; const struct sga_budget *budget; };
void surfaces_find(struct surfaces *s, const struct sys_system *sys, const expr_id *beside, int besides, const struct surfaces_every *every, struct sga_arena *mem);
void surfaces_clear(struct surfaces *s);
/* Expressions with the switch of each surface replaced by value[surface], in place (EXPR_UNDEF: it stays as it is). */
void surfaces_put(const struct surfaces *s, const expr_id *value, expr_id *e, int count);
/* e, which has values for symbol = 1 and -1, is made linear in the symbol between them. */
expr_id surfaces_chord(struct expr_store *st, expr_id e, int symbol);

#endif
