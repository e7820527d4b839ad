/* Inside the traj folder: what derivatives of a motion do at an event that sets variables.
 *
 * Of a motion x(t, k) with derivatives S = dx/dk and an event at the time t*(k) with g(x, t*, k) = 0,
 *     tau = dt* / dk = -(g_x S- + g_k) / (g_x X- + g_t),
 * a value that is kept has the derivative S- + X- tau along the event, one that is set to h has h_x S- + h_k + (h_x X- + h_t) tau, and where the motion goes on
 * from x+, whose derivative along the event is s,
 *     S+ = s - X+ tau
 * (the saltation matrix: M. di Bernardo et al., Piecewise-smooth Dynamical Systems, Springer 2008, 2.5). Between what is set and x+ lies a nearest point, in the masses' metric
 * or tier by tier (tiers.h): its conditions are differentiated (jump_least.h).
 * There is no such derivative where the motion only touches g = 0 (the event's time moves without bound), where events that happen at one time are parted
 * by what is differentiated by, and where it goes on along another event's zero, from which that moves it. */
#ifndef SGA_TRAJ_JUMP_SLOPE_H
#define SGA_TRAJ_JUMP_SLOPE_H

#include "jump_set.h"
#include "least_rows.h"
#include "switches.h"

struct jump_slope {
    const struct jump *of;        /* borrowed */
    struct least_rows rows;       /* events, what they set, masses, then constraints */
    int sets, masses;
    struct num_switches switches;     /* of the field */
    struct num_tape *switching;       /* what they are signs of; NULL: there are none */
    signed char *side;
    struct num_tape *field, *slope;   /* slope: directions of events, of what they set, of masses */
    double *along;
};

struct jump_slope *jump_slope_new(const struct jump *j, struct sga_error *err);
void jump_slope_free(struct jump_slope *s);
/* After jump_land has found the start r in a way (0 to 2), from what was set (asked) and moved by impulses (to->x): to->slope gets the derivatives, direction by direction
 * (malloced, the caller's), or to->why the reason why there are none. turn->before->x: variables and derivatives. False with err: no memory or
 * time. Cost: as a start, times the variables where something moved. */
bool jump_slope_land(const struct jump_turn *turn, struct jump_to *to, const double *asked, const double *x, int way, struct sga_error *err);
/* Whether a motion that starts at x (with derivatives) stays clear of the events that set something, as what is differentiated by changes. False: the event that it
 * does not. */
bool jump_slope_starts(const struct jump *j, double t, const double *x, int *event);

/* The field from then on: with its switches on the sides that the motion came with to (t, x); on those that it goes on with from there, to its direction. x: of the motion's variables. */
void jump_slope_came(struct jump_slope *s, const struct jump_at *at);
void jump_slope_goes(struct jump_slope *s, double t, const double *x);
/* s->along at what was loaded into the rows last. */
bool jump_slope_directions(struct jump_slope *s);

#endif
