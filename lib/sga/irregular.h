/* Inside the sga folder: constraints that sampling finds to be irregular on their zeros. */
#ifndef SGA_SGA_IRREGULAR_H
#define SGA_SGA_IRREGULAR_H

#include "regular.h"

/* Sampling approached the point x (by variable) at time t, where e vanishes and its
 * differential depends on those of the earlier constraints. A proposal is a set of
 * functions that may take e's place near there; the caller samples their zeros near x and
 * asks whether e vanishes on them. */
struct proposal {
    expr_id *out; int count;
    /* The first derivatives of e along one variable, from the 0th. If those below order m
     * vanish on the zeros of out, and the m-th does not, e = unit * out^m near them
     * (Malgrange), so that the zeros agree. Empty: the second derivative is definite across
     * the zeros (Morse-Bott). */
    expr_id *derivative; int derivatives;
    expr_id whole;       /* out is one branch of this function's zeros; or EXPR_UNDEF */
    bool exact;          /* e is a function of out's one function alone: no zeros elsewhere */
};

enum { IRREGULAR_ORDER = 8 };

/* All proposals, the simplest first; returns how many. The caller frees each with
 * irregular_clear, and the list. */
int irregular_proposals(struct state *s, expr_id e, const double *x, double t, struct proposal **list);
void irregular_clear(struct proposal *p);

#endif
