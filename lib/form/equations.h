/* Implicit equations F(x, x', x'', ..., t) = 0 of any order, brought to first order.
 *
 * r(x) is the highest order of x over all equations. The state is x, x', ...,
 * x^(r-1), with rows (x^(k-1))' = x^(k). An equation that is linear in the highest
 * derivatives jointly gives the row  sum (dF/dx^(r)) (x^(r-1))' = -F at x^(r) = 0.
 * A variable whose highest derivative is not linear somewhere is prolonged: v = x^(r)
 * joins the state with the row (x^(r-1))' = v, and v may then stand anywhere (0 = F(x, v)).
 * Two derivatives that are multiplied with one another are both prolonged, so that the
 * outcome does not depend on the order of variables or equations. A variable of order 0
 * is a state variable without a row.
 *
 * Linearity is decided on the structure of the derivatives: an equation that is linear
 * only after expansion is prolonged, which is right, only larger.
 *
 * The derivative symbols are named x', x'', ...: they are EXPR_VELOCITY while equations are
 * read, and those that join the state become EXPR_VARIABLE. */
#ifndef SGA_FORM_EQUATIONS_H
#define SGA_FORM_EQUATIONS_H

#include "system.h"

enum { FORM_MAX_ORDER = 64 };

struct form_unknown {
    int symbol[FORM_MAX_ORDER + 1];   /* of x, x', ...; -1: not made yet */
    int order;                        /* highest in the equations */
    bool prolonged;
};

struct form_equations {
    struct expr_store *store;         /* not owned */
    struct form_unknown *unknown; int unknowns;  size_t unknown_cap;
    expr_id *equation;            int equations; size_t equation_cap;
    int *owner;                       /* symbol -> unknown, or -1 */
    int *rank;                        /* symbol -> order of derivative */
    int known;                        /* length of owner and rank */
};

void form_equations_init(struct form_equations *f, struct expr_store *st);
void form_equations_clear(struct form_equations *f);
void form_equations_unknown(struct form_equations *f, int symbol);
/* For struct expr_grammar: ctx is a struct form_equations. EXPR_UNDEF if the symbol is
 * not an unknown or the order is past FORM_MAX_ORDER. */
expr_id form_equations_derivative(void *ctx, int symbol, int order);
/* Likewise: d e / dt by the chain rule, with the next derivatives of the unknowns. */
expr_id form_equations_total(void *ctx, expr_id e);
void form_equations_add(struct form_equations *f, expr_id left_minus_right);

/* Fills s; rows are named "equations[i]" and "definition of x'". Fails with
 * LIMIT_VARIABLES where the state would have more than max_variables, or with the
 * store's error. Cost: one derivative for each highest derivative in each equation. */
bool form_equations_reduce(struct form_equations *f, struct sys_system *s, int max_variables,
                           struct sga_error *err);

#endif
