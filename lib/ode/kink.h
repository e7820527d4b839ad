/* Inside the ode folder: what the files about kinks share. kink.c goes along with the march, kink_sides.c knows the
 * sides of surfaces at a point, kink_find.c finds what a step passes. */
#ifndef SGA_ODE_KINK_H
#define SGA_ODE_KINK_H

#include "march.h"

#define PROBE 1e-2             /* of a step: how far ahead the sides are tried */

enum { TURN = 1, REST };

struct ode_kinks {
    int count;
    signed char *side;         /* what is held; 0: nothing */
    unsigned char *fresh;      /* turned, and not yet seen off the surface */
    unsigned char *pending;    /* to be turned when the present step is committed; REST: not to be held from then on */
    unsigned char *led;        /* the motion led to the surfaces of these when some were turned last; others were turned by that */
    double *old, *least, *doubt, *was;     /* changes ahead, before a turn; see grains; arguments before a turn */
    double *g, *rate, *g1, *rate1;   /* at the step's ends: values, and their derivatives along the motion */
    double *theta;             /* where it leaves its side in the step; 2: nowhere */
    struct ode_way way;
    struct guard_table table;
    double *x, *f, *mid;       /* n each */
    double cut, limit;         /* the next step is no longer than this; 0: no matter. The second until a switch is turned, */
    double limit_t;            /* or this time, at which one was expected, is well behind */
    double short_h;            /* size of the last step that was to end at a surface, which is not near its end, or of one
                                * bounded by that; 0: no matter */
    int target, tries;         /* the switch that the step is to end at, or -1 */
    bool natural;              /* nothing is held in the present step */
    double turned_t;           /* where a switch was turned last (or the start), how many there, */
    int turned;
    double scale;              /* and a time over which the motion was the same before */
};

/* The problem holds its switches as kinks says. */
void kinks_hold(struct ode_march *m);

/* kink_sides.c. All arguments at (t, x). */
void kinks_values(struct ode_march *m, double t, const double *x, double *g);
/* k->least: how far from 0 roundings take each g, and errors far below the tolerance. k->doubt: errors as large as allowed. */
void kinks_grains(struct ode_march *m, double t, const double *x);
/* The present point after a step of size h, or before the first one: how far ahead may be looked. */
void kinks_set_scale(struct ode_march *m, double h);
/* After some were turned at (t, x), the arguments of others may have jumped to their other sides (max(1/2 - s, s) where s jumps): these
 * are turned too, and what that turns, until all have their values; x moves to the constraints of those sides. g (count): what the
 * arguments were; it becomes what they are. By k->doubt of kinks_grains. *on_set: x could be moved there. False: they turn each other without end. */
bool kinks_carry(struct ode_march *m, double t, double *x, double *g, bool *on_set);
/* All sides anew at the present point. False: no field there. */
bool kinks_take_sides(struct ode_march *m);
/* The pending switches at the present point. False: the motion ends. */
bool kinks_turn(struct ode_march *m);
/* A switch that was turned, or is not held, may be well off its surface by now. False: the motion ends. */
bool kinks_left(struct ode_march *m, int e);
/* Switch e is not held any more. False: the motion ends. */
bool kinks_let_go(struct ode_march *m, int e);

#endif
