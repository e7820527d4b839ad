/* Inside the traj folder: Taylor series at the points of a march in double-double. precise_series.c makes steps of them,
 * precise_sides.c holds switches (abs, sign, min, max) on sides along each. */
#ifndef SGA_TRAJ_PRECISE_SERIES_H
#define SGA_TRAJ_PRECISE_SERIES_H

#include "dd.h"

struct precise_march;
struct precise_point;

/* At a point of the march, in s = (time from there) / scale. */
struct expansion {
    num_dd *series;            /* of the state: (order + 1) x n */
    num_dd *argument;          /* of the switches' arguments: count x order */
    num_dd reach;              /* up to where switches that are not held stay on their branches */
    double scale;
};

struct expansions {
    int n, order, count;
    struct expansion here, there;
    double far;                /* up to which s from here the last terms are within tolerance */
    num_dd *change;            /* by switch: where its side is left from here, within far; INFINITY: nowhere */
    num_dd to;                 /* the step that ends at the first change */
    num_dd *slope, *part;      /* n; order */
    double *work;              /* 3 order */
};

/* The series at a point on a scale near the size, or below where it overflows there. False: there is none. */
bool precise_expand(struct expansions *w, struct precise_march *m, const struct precise_point *at, struct expansion *q, double size);
/* Up to which s from 0 the last three of `order` + 1 terms, in units of what is allowed, are within tolerance: term(i) is
 * the size of the one before last by i. */
double precise_terms(const double last[3], int order);

/* How far the next step from here may go: w->far, w->change. */
void precise_look_ahead(struct expansions *w, struct precise_march *m);

/* precise_sides.c. All sides anew at here, whose series are there, and are made anew. False: there are none. */
bool precise_take_sides(struct expansions *w, struct precise_march *m);
/* The series go on from here, where the last step came to. False: the march ends (precise_end was called). */
bool precise_sides_pass(struct expansions *w, struct precise_march *m);
/* Changes that come at once are made at here; and how far steps may go from there (precise_look_ahead). False: as above. */
bool precise_sides_settle(struct expansions *w, struct precise_march *m, double size);
/* From here on nothing is held until the next step is made. False: the field has no series then, and all is as it was. */
bool precise_let_go(struct expansions *w, struct precise_march *m, double size);
/* Everything that has switches holds them as m->sides says; after those pending changed sides. */
void precise_hold(struct precise_march *m);
void precise_flip_pending(struct precise_march *m);

/* precise_jump.c. Sides were turned at here, whose arguments before were noted, and m->sides.doubt found: here lands, and the switches that turn by that are turned too,
 * and what that turns, as kinks_carry does in double. near: as precise_grains. False: m->why; ODE_NOT_SMOOTH: they turn each other without end. */
bool precise_carry(struct precise_march *m, const struct expansion *near);
/* m->sides.doubt: by the sides before, as it is, or by those that hold now. */
void precise_doubt_both(struct precise_march *m, const struct expansion *near);

/* precise_change.c. w->far is made smaller where arguments ask for it; w->change. */
void precise_find_changes(struct expansions *w, struct precise_march *m);
/* A step ends at there, at the first change (`turns`) or not. The sides there are what they should be, and the change is near enough?
 * Where that only needs another try, *cut is 1. */
bool precise_sides_agree(struct expansions *w, struct precise_march *m, bool turns, double *cut);
/* By how much rounding in x changes each argument at a point (m->sides.rounding), and errors in x as large as allowed (doubt). */
void precise_grains(struct precise_march *m, const struct precise_point *at, const struct expansion *near);
/* A time that is 0 to rounding at a point. */
double precise_grain(const struct precise_march *m, const struct precise_point *at);
static inline const num_dd *precise_argument(const struct expansions *w, const struct expansion *q, int e)
{
    return q->argument + (size_t)e * (size_t)w->order;
}
/* Up to which s, at most far, the argument's last terms are as small against it as the state's against that. */
double precise_argument_far(const struct expansions *w, const struct precise_march *m, const num_dd *g, double far);
/* w->part: the argument over s / far. Returns the sum of the coefficients' sizes. */
double precise_spread(struct expansions *w, const num_dd *g, double far);
/* Where w->part leads to from 0 (coefficient 0 left out): 1, -1, or 0 where it does not lead away. */
int precise_direction(const struct expansions *w);

#endif
