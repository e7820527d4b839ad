/* Inside the traj folder: the search for a start that meets relations, within bounds. */
#ifndef SGA_TRAJ_START_SEARCH_H
#define SGA_TRAJ_START_SEARCH_H

#include "arena.h"
#include "flow.h"

struct start_search {
    const struct sys_system *sys;
    const struct sga_solution *sol;
    const struct traj_request *rq;
    struct traj_request plain;    /* the same without relations and bounds */
    expr_id *relation;            /* functions of variables and time */
    int *by_name;                 /* n: the variables in the order of their names */
    bool few;                     /* few starts are tried, for what a refusal says */
    struct sga_arena mem;
};

/* A point of the final set where some relations hold. */
struct start_found {
    double *x;                    /* n; of the search's memory */
    double moved;                 /* as consistent_start's */
    double far;                   /* scaled distance of all variables from the guess */
};

/* Derivatives put in. False with err: GAUGE, or a relation that no point meets. */
bool start_search_init(struct start_search *s, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err);
void start_search_clear(struct start_search *s);

/* The nearest start that is found within the bounds where the relations of `use` (NULL: all) hold: from the guess first, then from others, the same each
 * time, which depend on the names of the variables and not on their order. *outside: the one that is least outside, where none is inside; x NULL: none at
 * all. freed: held variables may move. Cost: some thirty starts where the first one does not do. */
bool start_search_find(struct start_search *s, const unsigned char *use, bool freed, struct start_found *found, struct start_found *outside);
/* By how much x_j lies outside its bounds, beyond rounding; 0: inside. */
double start_outside(const struct traj_request *rq, const double *x, int j);
/* left - right of each relation. False: one has no value. */
bool start_residuals(const struct start_search *s, const double *x, double *residual);

/* start_culprit.c: err says what keeps a start from being found. `outside` as above. Returns false. */
bool start_culprit(struct start_search *s, const struct start_found *outside, struct sga_error *err);
/* start_exact.c: x, where relations and constraints hold in double, to the digits of longer numbers: constants of the store. False with err: it does not
 * come there. */
bool start_exact(struct start_search *s, const double *x, expr_id *exact, struct sga_error *err);
/* The constraints with the relations of `use`, and (at: by variable, -1 low, 1 high, or NULL) with variables at their bounds; *with borrows from the search's memory. */
void start_with(struct start_search *s, const unsigned char *use, const signed char *at, struct sga_solution *with);

#endif
