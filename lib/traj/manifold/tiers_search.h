/* Inside the traj folder: the search for a start in tiers (tiers.h): what it holds, descent from one point of the set, and the ways to some. */
#ifndef SGA_TRAJ_TIERS_SEARCH_H
#define SGA_TRAJ_TIERS_SEARCH_H

#include "tangent.h"
#include "tiers.h"

/* Towards the set, values that were not given move this much more easily. */
static const double LOOSE = 1e3;
/* Points as near as each other. */
static const double ALIKE = 1e-9;
/* In units: nothing but rounding. */
static const double ROUNDED = 1e-13;

struct tiers_search {
    const struct traj_request *rq;
    struct tangent t;
    double *unit, *loose;
    double *weight;
    unsigned char *kind;
    signed char *tier;
    int *by_name;
    const char **name;
    const double *elsewhere;
    double *filled;          /* the guess, with what equations say of values that were not given */
    int starts;
    int edges;               /* directions barred from the start: see edge_on */
    enum tiers_stage stage, found_in;
    bool dear;               /* in each tier those after it cost something */
};

struct tiers_found {
    double *x, score[TIERS];
    bool any;
    int ends;                /* tiers before the first without a nearest point; TIERS: each had one */
};

/* tiers_descent.c. The tangent space without what stays in the stage of the search, and with what edges bar. */
void tiers_stay(struct tiers_search *s);
/* From f->x, a point of the set, to the nearest one, tier by tier: its distances, and which tiers had a nearest one. */
void tiers_complete(struct tiers_search *s, struct tiers_found *f);
/* Negative: a is nearer, or as near in the tiers that have an end in both and has more of those; positive: b is; 0: as near as each other, and the
 * same in all names. */
int tiers_compare(const struct tiers_search *s, const struct tiers_found *a, const struct tiers_found *b);
void tiers_found_copy(const struct tiers_search *s, struct tiers_found *to, const struct tiers_found *from);

/* tiers_ways.c. The nearest point of those found from the guess and from places around it, or from a point of the set and from places on the way
 * to it, into best; next: room for another one. The stage and the tiers of the search are set. */
void tiers_from_guess(struct tiers_search *s, struct tiers_found *best, struct tiers_found *next);
void tiers_from_elsewhere(struct tiers_search *s, struct tiers_found *best, struct tiers_found *next);

#endif
