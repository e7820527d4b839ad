/* Inside the sga folder: the branches of products, and the special points of a system that
 * contradicts itself at general ones. */
#ifndef SGA_SGA_PRODUCT_ROUTES_H
#define SGA_SGA_PRODUCT_ROUTES_H

#include "error.h"
#include "state.h"

struct components;

/* What is known of the routes tried. */
struct routes {
    struct route now, best;
    int final;                 /* the largest dimension that a route led to; -1: none yet */
    int tried, failed;
    int products;              /* of those tried, routes through products */
    bool left;                 /* some were not tried */
    struct sga_error error;    /* the first failure of a branch */
    uint64_t seed;
    bool explore;              /* other components are looked for */
    struct components *components; /* owned; NULL before the first run */
    int best_at, now_at;       /* the place that `best` and `now` are near, or -1 */
    int best_run;              /* its run among the components', or -1 */
    enum sga_verdict verdict;  /* of the best */
    bool ended;                /* the last run led to points */
    bool others;               /* a run before did, near the guess, and this one takes another branch, which may be nearer */
    bool beside;               /* some run ended empty on constraints that are known near a point only: elsewhere they may hold more */
    expr_id *pivot; int pivots; size_t pivot_cap;   /* what runs that ended empty divided by, where it may vanish */
};

/* Run routes until one leads to points (with a guess) or all are known (without: the
 * largest set is the generic one). The caller sets final to -1 and the seed. False: a
 * failure that ends the job. */
bool routes_explore(struct routes *r, const struct sys_system *system, const struct reduction_options *options,
                    struct points_oracle *oracle, struct sga_solution *solution, struct sga_error *err);
/* The options near a place of the components; -1: as they are. */
struct reduction_options routes_options(const struct routes *r, const struct reduction_options *options, int place);
/* Back to the state before a run. */
void routes_restart(struct points_oracle *oracle, uint64_t seed, struct sga_solution *solution);
/* Failures of one branch, which say nothing about another. */
bool routes_local(enum sga_code code);
void routes_clear(struct routes *r);

/* All routes of `above` ended empty, which says something of general points only. The
 * zero sets of what was divided by are looked at, and theirs in turn: where one holds
 * solutions, the largest of them (the one the guess lies on, if there is one) becomes the
 * solution; where none does, the contradiction stands. False: not known of some of them. */
bool special_points_solve(const struct routes *above, const struct sys_system *system, const struct reduction_options *options,
                          struct points_oracle *oracle, struct sga_solution *solution, struct sga_error *err);

#endif
