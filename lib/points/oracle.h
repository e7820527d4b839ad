/* The zero oracle: values of every node of the store at a few points of the present
 * constraint set, from which it decides whether a function is zero there.
 *
 * What an answer rests on:
 *  - NONZERO_PROVED: a ball at a point proved to lie on the set excludes 0. A theorem.
 *  - ZERO_EXACT: the node is the constant 0.
 *  - ZERO_ALGEBRAIC: zero at random points of the constraint variety modulo a 60-bit
 *    prime (or a power of a small one), with elementary functions as independent generators, and every ball contains
 *    0 with a small radius. True on the components sampled up to a probability of about
 *    degree / 2^60 per point. Where the variety has several components, or roots several values, that is some of the
 *    points and not all: the balls say which, and must be narrow (900 digits).
 *  - ZERO_NUMERIC: every ball contains 0 and is narrower than 10^-digits.
 *  - SPLIT: zero at some points and not at others, at any precision: the set has
 *    several branches.
 *  - UNKNOWN: no point gives a value, or balls stay too wide. */
#ifndef SGA_POINTS_ORACLE_H
#define SGA_POINTS_ORACLE_H

#include <flint/flint.h>

#include "points_space.h"

struct points_beyond;
struct points_modpoint;

enum points_basis {
    POINTS_EXACT, POINTS_NONZERO_PROVED, POINTS_NONZERO_NUMERIC,
    POINTS_ZERO_ALGEBRAIC, POINTS_ZERO_NUMERIC, POINTS_IS_SPLIT, POINTS_NO_VALUE,
    POINTS_BASES
};

struct points_decision {
    enum points_truth truth;
    enum points_basis basis;
    int digits;          /* of ZERO_*: at least so many decimal digits */
    int points;          /* real points that had a value */
    int modular;         /* modular points that agree */
};

/* A zero that was not exact, kept for the evidence. */
struct points_zero {
    expr_id expr;
    struct points_decision decision;
    int constraints;                         /* of the set that it was asked on */
};

enum { POINTS_REAL = 2, POINTS_MODULAR = 2, POINTS_MODULAR_MOST = 32 };

struct points_oracle {
    struct points_space space;               /* its lists are the next: own copies */
    int *variable, *parameter, *end;
    expr_id *constraint, *defined;
    signed char *cheap;
    double *near;
    struct points_point *real;               /* POINTS_REAL, the first `reals` in use */
    int reals;
    struct points_point *high;               /* the same points at more bits, when needed */
    slong high_bits;                         /* 0: not made */
    struct points_modpoint *modular;         /* POINTS_MODULAR_MOST; past the first POINTS_MODULAR only where those have no one opinion */
    int modulars;
    int prime;                               /* of the next of them */
    bool modular_over;                       /* no more can be found */
    struct expr_cone cone;
    double height;                           /* of the space's functions (points_height) at the first point; < 0: not asked */
    uint64_t random, chance;                 /* chance: of modular points, so that real ones do not depend on what was asked before */
    long count[POINTS_BASES];                /* decisions so far, by basis */
    struct points_zero *zero; int zeros; size_t zero_cap;   /* each expression once, the first SGA_MOST_ZEROS_LISTED */
    int least_digits;                        /* smallest digits of a ZERO_NUMERIC */
    struct points_side *side; int sides; size_t side_cap;   /* that zeros found so far depend on */
    int looked;                              /* nodes of the store seen ... */
    bool switches;                           /* ... and whether one of them has sides */
    struct points_beyond *beyond;            /* the set on other sides of its constraints' switches */
    double seconds_sampling;
};

void points_oracle_init(struct points_oracle *s, uint64_t seed);
void points_oracle_clear(struct points_oracle *s);
/* New points on the set of `space` (copied with its variables, parameters, constraints, guess and what moves cheaply; what
 * else it points to must stay). The first is
 * near space->near where there is one, the others are near the first, so that all lie on
 * one component as a rule. On failure the oracle has no points. */
enum points_status points_oracle_sample(struct points_oracle *s, const struct points_space *space);
/* Whether all points are proved to lie on the set, with independent differentials there. */
bool points_oracle_certified(const struct points_oracle *s);
/* Drop all points (they will not be starts for the next ones either). */
void points_oracle_forget(struct points_oracle *s);
/* s->high: the points once more, refined to `bits` where they have fewer (s->high_bits); false: they cannot be, and there are
 * none. What was raised is evaluated at full length by each decision that asks for it: lowered drops it. */
bool points_oracle_raise(struct points_oracle *s, slong bits);
void points_oracle_lower(struct points_oracle *s);
/* Decide whether e is zero on the set. Where that holds on one side of a surface only, the
 * side is added to s->side, and later points are taken on it alone. */
struct points_decision points_oracle_zero(struct points_oracle *s, expr_id e);
/* Whether a point modulo a prime says that e is zero: without one points_oracle_zero has digits at most, which cost more bits of all. */
bool points_oracle_modular_zero(struct points_oracle *s, expr_id e);
/* The height (needed_bits.h) of the constraints and of what is listed as defined, at the first point; worked out once for a set. */
double points_oracle_height(struct points_oracle *s);
/* The same for what need not be one thing on all sides: *mixed, where e is 0 here and not beyond a surface that the set
 * reaches, or (nonzero: asked too) the other way round. Then no side is added unless `accept`. */
struct points_decision points_oracle_cells(struct points_oracle *s, expr_id e, bool nonzero, bool accept, bool *mixed);
/* Whether the sides of some switches were not looked for, to keep within limits, since it was last forgotten. */
bool points_oracle_cut_short(const struct points_oracle *s);
void points_oracle_forget_cut(struct points_oracle *s);
/* Gives the memory of all values at the points back, until they are asked for. */
void points_oracle_release(struct points_oracle *s);
/* log2 of |e| at the first point (very negative for 0), for choosing pivots. */
double points_oracle_magnitude(struct points_oracle *s, expr_id e);

const char *points_basis_text(enum points_basis basis);

#endif
