/* Which set is sampled for points, where from, what came of it, and what is known of a function being zero there. */
#ifndef SGA_POINTS_POINTS_SPACE_H
#define SGA_POINTS_POINTS_SPACE_H

#include <stdbool.h>
#include <stdint.h>

#include "expr.h"

struct points_point;
struct points_search;
struct sga_budget;

/* The answer holds where the function has this sign: 1 or -1. */
struct points_side {
    expr_id function;
    int sign;
    bool unseen;              /* what holds beyond is not known: no point of the set was found there */
};

enum { POINTS_BITS = 128 };    /* of points at which functions are asked first */

/* What is sampled. Nothing here is owned. */
struct points_space {
    const struct expr_store *st;
    const int *variable;   int variables;     /* symbols */
    const int *parameter;  int parameters;    /* symbols left symbolic */
    const signed char *parameter_sign;        /* by parameter, 1 or -1; NULL: positive first, then any */
    const double *parameter_value;            /* by parameter: instead of random ones; or NULL */
    const double *parameter_near;             /* by parameter: a guess, NAN where there is none; or NULL */
    int time;                                 /* symbol; -1: it is among the variables (points_find only) */
    const expr_id *constraint; int constraints;
    const int *end; int ends;                 /* of generations, ascending: later ones have variables that the earlier do not, as a rule. A hint alone */
    const expr_id *defined; int defineds;     /* functions that should have values at points, too: starts are chosen so */
    const double *near;                       /* by variable: a guess, or NULL */
    double near_time;
    const signed char *cheap;                 /* by variable: log2 of how much more easily it leaves the guess than others; or NULL */
    double near_spread;                       /* how far from the guess the oracle's points are drawn, relatively; 0: as from a guess that may be special */
    const struct points_point *before;        /* a point of a larger set: tried first, or NULL */
    const int *scale;                         /* by variable: log2 of its natural size, or NULL */
    double time_unit;                         /* over which equations change with time, where that is far from 1; 0: 1 */
    bool by_shape;                            /* the set is solved variable by variable (triangular.h) from the first start on,
                                               * and not by steps, which go to the part that is nearest */
    bool passing;                             /* the point is only where a search on a smaller set begins: of many constraints it is not proved */
    int starts;                               /* random ones to try; 0: the usual number */
    bool by_name;                             /* starts are drawn by the names of variables, whatever their order */
    long *steps;                              /* Newton steps left, counted down: none is found past them; NULL: any number */
    const struct points_side *side; int sides;   /* points on other sides are not taken */
    bool same_branches;                       /* nor, of the first few starts near a guess, those where abs, sign, min, max of the
                                               * constraints have another branch than at the start */
    struct points_search *search;             /* what searches for points of these very constraints share (search.h); NULL: each makes its own */
    const struct sga_budget *budget;
};

enum points_truth { POINTS_NONZERO, POINTS_ZERO, POINTS_UNKNOWN };

enum points_status {
    POINTS_OK,
    POINTS_NONE,        /* no start led to a point: not a proof that there is none */
    POINTS_IRREGULAR,   /* the differentials become dependent where the constraints vanish */
    POINTS_STOPPED      /* budget */
};

#endif
