/* Validated integration: boxes that are proved to hold the solution of x' = X(t, x).
 *
 * Taylor series in ball arithmetic, whose convergence and tails are proved from their first coefficients
 * (tail.h), and Lohner's parallelepipeds against wrapping (lohner.h). What is
 * proved: for every start in the given balls and every time t0 and sample time in theirs, the solution
 * exists from t0 to the sample and its value lies in the box. Arb's rounding is outward throughout. */
#ifndef SGA_ENCLOSE_ENCLOSE_H
#define SGA_ENCLOSE_ENCLOSE_H

#include <arb.h>
#include <stdbool.h>

#include "expr.h"

struct enc_tables;

/* A function whose zeros along the solution are looked for. */
struct enclose_watch {
    expr_id value, rate;                 /* rate: its derivative along the field; of the variables, time and tables */
    int direction;                       /* +1: up as time grows, -1: down, 0: any */
    bool stop;                           /* the solution is followed to the first that counts */
    int most;                            /* so many count; 0: all */
    bool zero;                           /* it is 0 at the start exactly (of a strict path) */
    expr_id second;                      /* and so is its rate, whose derivative along the field this is; or EXPR_UNDEF */
};

/* The ball t holds exactly one time at which function `which` is 0 and changes its sign (shown); or it is not decided whether there is any. */
struct enclose_happening {
    int which, direction;                /* of the change as time grows; 0: not shown */
    bool shown;
    int piece;                           /* knots before it */
    arb_struct t; arb_ptr x;             /* the solution there, n */
    int before, slope; bool open;        /* inside the enclose folder: it lies at the end of what has been searched */
};

struct enclose_happened {
    struct enclose_happening *list; int count;   /* in the order of the motion */
    int n;
};

void enclose_happened_clear(struct enclose_happened *h);
/* Without the i-th. */
void enclose_happened_cut(struct enclose_happened *h, int i);

struct enclose_problem {
    const struct expr_store *st;
    const int *variable; int n;          /* symbols */
    int time;                            /* symbol */
    const expr_id *field;                /* n: X, of the variables and time */
    const expr_id *nonzero; int nonzeros;   /* must be shown not to vanish along the solution */
    const struct enc_tables *tables;     /* that it depends on too, as the polynomials that are in use; or NULL */
    const struct enclose_watch *watch; int watches;
    const struct sga_budget *budget;
};

struct enclose_path {
    arb_srcptr start;                    /* n balls */
    const arb_struct *t0;
    arb_srcptr times; int samples;       /* in the order of the motion */
    /* Knots of the tables strictly inside, in the order of the motion, each once: steps end there, and beyond one the next piece is entered: problem->tables
     * hold its polynomials then. before: by sample, how many knots come before it. The first piece has been entered. */
    arb_srcptr knot; int knots;
    const int *before;
    void (*enter)(void *ctx, int piece);
    bool (*jump)(void *ctx, const arb_t t, arb_ptr box);      /* the solutions in box (n) go on as others beyond a knot at t: into box; false: that cannot be shown. NULL: none do */
    void *ctx;
    slong prec;                          /* bits; the boxes lose what the problem's conditioning costs */
    bool strict;                         /* what may be 0 at the start is 0 there exactly (enclose_watch.zero), or it is undecided whether it happens; what changes
                                          * its sign in the direction that does not count never happens */
    bool backward;                       /* time falls along the motion */
    int early;                           /* so many samples may lie before the start: their boxes are those of the solution if they do not */
    long most_steps;                     /* 0: as many as the budget allows */
    struct enclose_happened *happened;   /* empty at first; NULL only where nothing is watched */
};

enum enclose_why {
    ENCLOSE_DONE,
    ENCLOSE_NOT_SHOWN,      /* no step forward for which existence, or that X is analytic, could be shown */
    ENCLOSE_MAY_VANISH,     /* the same, and nonzero[which] is what may vanish */
    ENCLOSE_WIDE,           /* the set grew too large: more bits help if the start is known well enough */
    ENCLOSE_JUMPS,          /* path->jump failed */
    ENCLOSE_EVENT,          /* watch[which] stopped it: the last of the happenings */
    ENCLOSE_UNDECIDED,      /* it cannot be shown whether watch[which] stops it at the last of the happenings */
    ENCLOSE_STOPPED         /* budget, or most_steps */
};

struct enclose_end {
    enum enclose_why why;
    int which;
    bool at_once;           /* EVENT: another one may happen at the same time */
    int samples;            /* boxes that are filled, from the first */
    double t;               /* how far the solution is enclosed */
    long steps, evaluations;
};

/* box: samples x n balls. False only where the field cannot be compiled, with err. Cost for each step: about
 * (0.5 prec)^2 / 2 multiplications of prec bits for each operation of the field, and n times 100 to 200 of 64 bits. Steps are
 * some quarter of the radius of convergence. evaluations: Taylor series, two for each step and few more. */
bool enclose_run(const struct enclose_problem *problem, const struct enclose_path *path, arb_ptr box,
                 struct enclose_end *end, struct sga_error *err);

/* The point where functions vanish, by interval Newton (Krawczyk 1969; Rump, Verification methods,
 * Acta Numerica 2010, theorem 13.2): x (n balls) holds values; those with solved[j] are replaced by balls that are
 * proved to hold exactly one common zero of the functions, for all values of the others in their balls. count of the
 * solved ones = count of the functions. False where that cannot be shown with prec bits. */
bool enclose_zero(const struct enclose_problem *problem, const expr_id *function, int functions, const arb_t t,
                  const unsigned char *solved, slong prec, arb_ptr x, struct sga_error *err);

/* x as a decimal text (malloced; a JSON number) with the digits that its radius leaves, prec bits at most, and a
 * bound of |v - text| for all v in x. NULL and INFINITY where x is not finite. */
char *enclose_decimal(const arb_t x, slong prec, double *radius);
/* A double >= m; 0 for 0 only. */
double enclose_above(const mag_t m);

#endif
