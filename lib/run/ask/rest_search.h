/* Inside the ask folder: a search for equilibria on its way. */
#ifndef SGA_RUN_REST_SEARCH_H
#define SGA_RUN_REST_SEARCH_H

#include "ask_work.h"
#include "equilibria.h"
#include "equilibria_shape.h"

struct request_equilibria;
struct sga_solution;

struct rest {
    struct job *j;
    const struct request_equilibria *ask;
    struct ask_work s;         /* for its request, writer and arena */
    struct linearization base;
    expr_id *held_zero; int helds;   /* functions that vanish where what is held has its value */
    unsigned char *input, *held;   /* by variable */
    double *near;
    int certified;             /* of the points written */
    bool finite;               /* algebra says that equilibria are finitely many */
    struct rest_point *point; int points;   /* by point found */
};

/* Of a point where differentials are dependent, and which is exact: what equilibria are about it. */
struct rest_point {
    struct linear_place place;
    bool placed;               /* place is to be cleared */
    struct equilibrium_shape shape;
    bool left_out;             /* another point of its family is shown */
};

/* Fills r->point. Cost: that of equilibria_shape.h for each such point. */
void rest_families(struct rest *r, const struct equilibria *e);
void rest_families_clear(struct rest *r);
/* Whether the families that are shown, and the isolated points, are all equilibria. */
bool rest_families_are_all(struct rest *r, const struct equilibria *e, int *families, long *beside);

/* The coordinates that the rates were proved to vanish in are free at the point. */
bool rest_certified(const struct equilibrium *p, const struct linearization *l);
/* The constraints' zeros have other parts, or may have: the answer is that of one. */
bool rest_has_parts(const struct sga_solution *s);
/* The search that is asked for. */
struct equilibria_request rest_request(const struct rest *r, const struct equilibria_algebra *a);
/* Whether what was found is all, and why it is or may not be: the text is appended. Warns where nothing was found. */
bool rest_complete(struct rest *r, const struct equilibria *e, const struct equilibria_algebra *a, struct sga_buf *why);

#endif
