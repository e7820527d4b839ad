/* Values of the whole store at one point, in ball arithmetic (Arb): the authority for
 * zero and rank decisions. A ball encloses the exact value of the node for every
 * choice of the symbols inside their balls; so a ball that excludes 0 at a point that
 * is proved to lie on P_k proves that the function is not zero there. */
#ifndef SGA_NUM_BALL_H
#define SGA_NUM_BALL_H

#include <arb.h>
#include <stdbool.h>

#include "expr.h"

struct num_ball {
    const struct expr_store *st;
    slong prec;                    /* bits */
    arb_ptr symbol; int symbols;   /* values of the symbols, set by the caller */
    arb_ptr value;  int nodes;     /* values of the nodes known so far */
    size_t symbol_cap;
    unsigned char *used; size_t used_cap;   /* by block of values: some node of it was evaluated; the others are all zeros, and never touched */
    unsigned char *asked, round;   /* by node: the round in which num_ball_ask gave it its value; values of earlier rounds are forgotten */
    expr_id *wanted; size_t wanted_cap;     /* room of num_ball_ask */
    arb_ptr *solution;             /* by linear solve: its solution, once computed; */
    arb_ptr *inverse;              /* and its matrix's inverse, row by row, once a gradient asks */
    int solutions; size_t solution_cap, inverse_cap;
};

void num_ball_init(struct num_ball *b, const struct expr_store *st, slong prec);
void num_ball_clear(struct num_ball *b);
/* Set a symbol's value (the symbol must exist in the store). Values of nodes are
 * forgotten by num_ball_forget only. */
void num_ball_set(struct num_ball *b, int symbol, const arb_t v);
void num_ball_set_d(struct num_ball *b, int symbol, double v);
void num_ball_forget(struct num_ball *b);
/* Forgets them and gives their memory back; they are made again when they are asked for. */
void num_ball_release(struct num_ball *b);
/* Values for every node that the store has now. Cost: 0.1 to 1 microseconds a node. */
void num_ball_extend(struct num_ball *b);
/* For e and what it is made of, where they have none since values were forgotten. Cost: what of its cone was not asked for before. */
void num_ball_ask(struct num_ball *b, expr_id e);
/* Values of the nodes of one list only, in order (children first). */
void num_ball_list(struct num_ball *b, const expr_id *list, int count);
static inline arb_ptr num_ball_value(struct num_ball *b, expr_id e) { return b->value + e; }

/* The value of a constant expression of the store, or of a double where it is EXPR_UNDEF. Cost: its nodes. */
void num_ball_constant(const struct expr_store *st, expr_id e, double otherwise, slong prec, arb_t r);

/* A bound of log2 |x|, x finite; sums of a few of them stay in a word, however large or small x is. */
static inline slong num_ball_log2(const arf_t x)
{
    const slong most = WORD_MAX / 16;
    slong e = arf_abs_bound_lt_2exp_si(x);
    return e > most ? most : e < -most ? -most : e;
}

/* x 2^-exponent, rounded to nearest: what is beyond the range of doubles is infinite or 0. Without the way by MPFR that arf_get_d takes. */
double num_ball_double(const arf_t x, slong exponent);
/* The same to the bits of long double: at most LDBL_EPSILON off, relatively. */
long double num_ball_long(const arf_t x, slong exponent);

/* The inverse of a solve's matrix, m x m, row by row: borrowed until values change. Indeterminate where the matrix may be singular.
 * Some m^3 once for a point. */
arb_srcptr num_ball_inverse(struct num_ball *b, int solve);
/* What sweeps need beside values, kept from one to the next: { 0 } at first, ended by num_ball_room_clear. */
struct num_ball_room {
    int *place; size_t place_cap;      /* by node of the list that is swept: where it stands; others are undefined */
    arb_ptr bar; int bars;             /* by place: all 0 between sweeps */
};
void num_ball_room_clear(struct num_ball_room *room);
/* Gradient of `root` by one reverse sweep over `list` (its cone, values known): adds
 * nothing, overwrites grad[col_of_symbol[s]] for symbols with col_of_symbol[s] >= 0.
 * A solve of m unknowns costs m^2 a sweep, beside its inverse. */
void num_ball_gradient(struct num_ball *b, expr_id root, const expr_id *list, int count,
                       const int *col_of_symbol, arb_ptr grad, struct num_ball_room *room);

#endif
