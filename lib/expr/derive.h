/* Derivatives, as nodes of the same store. */
#ifndef SGA_EXPR_DERIVE_H
#define SGA_EXPR_DERIVE_H

#include "expr.h"

/* The partial derivative of node e with respect to its k-th child, the other child
 * fixed (of abs: sign; of sign: 0; min and max: the step between their arguments).
 * Not for SOLVE nodes. */
expr_id expr_partial(struct expr_store *st, expr_id e, int k);

/* d e / d symbol. Cost: the part of e's cone that depends on the symbol. */
expr_id expr_diff(struct expr_store *st, expr_id e, int symbol);

struct expr_term {
    int symbol;
    expr_id value;
};

/* The gradient of f with respect to the symbols i with active[i] != 0 (active has
 * st->symbols entries), by one reverse sweep over the part of the cone that depends
 * on them. Terms that are the constant 0 are left out. Returns the number of terms;
 * *out is reallocated (the caller frees it) and sorted by symbol. */
int expr_gradient(struct expr_store *st, struct expr_cone *cone, expr_id f,
                  const unsigned char *active, struct expr_term **out, size_t *out_cap);

/* Taylor coefficients along a flow x' = X(x, t), by recurrences over the graph: the
 * k-th coefficient of a product is a convolution of its factors' coefficients, so the
 * k-th derivative costs k times the graph, where repeated differentiation would square
 * it. (Griewank & Walther, Evaluating Derivatives, ch. 13.) */
struct expr_flow {
    struct expr_store *st;
    expr_id *velocity;        /* by symbol: X_j, or EXPR_UNDEF while it is not determined */
    size_t velocity_cap;
    int velocities;
    expr_id **jet;            /* by node: coefficients 1, 2, ... known so far */
    int *jets;                /* by node: how many */
    size_t jet_cap, jets_cap;
    unsigned char *tainted;   /* by node: depends on a symbol that is not determined */
    size_t tainted_cap;
    int known;                /* nodes with a taint flag */
    expr_id *fleeting;        /* nodes whose jets hold only until the next symbol is determined */
    size_t fleeting_cap;
    int fleetings;
    struct { int solve, order, result; } *lift;   /* the solve that holds the order-th coefficients */
    size_t lift_cap;
    int lifts;
};

void expr_flow_init(struct expr_flow *f, struct expr_store *st);
void expr_flow_clear(struct expr_flow *f);
/* Say that the symbol's derivative along the flow is X. Coefficients that were
 * computed with an undetermined derivative (as if it were 0) are forgotten. */
void expr_flow_determine(struct expr_flow *f, int symbol, expr_id X);
bool expr_flow_tainted(struct expr_flow *f, expr_id e);
/* The k-th Taylor coefficient of e along the flow (k = 0: e itself). Undetermined
 * derivatives count as 0. */
expr_id expr_flow_coefficient(struct expr_flow *f, expr_id e, int k);

#endif
