/* What becomes of functions from step to step: each passage of 0 and each touch of it, told once, whatever the arithmetic of the steps is. A track is what
 * is known of one function where a step begins; the table of the step's way (guard.h) says how it goes on. Where in the step a zero is, to how many
 * digits, and what it means, is for those to say who watch. */
#ifndef SGA_GUARD_TRACK_H
#define SGA_GUARD_TRACK_H

#include "guard.h"
#include "guard_beside.h"

struct guard_track {
    signed char sign;          /* of the last value that was not 0; 0: none yet */
    bool touched;              /* 0 was touched, and not left yet */
    bool carried;              /* sign is what the motion before says; no value was far enough from 0 to tell since */
    bool jumps;                /* at the start: its value there is that of one side of a jump, or between */
    double least;              /* values up to this do not tell from 0, at the start or a touch */
    double kept;               /* values up to this at both ends of a step, on what constraints it is brought back to, are 0 all along it, while there is no sign */
    double before;             /* the last value before the present point */
};

/* What arguments may be off by: what is allowed; roundings of what is told; what a start is found to; and around an event's place, where jumps are looked for. */
enum guard_errors { GUARD_ALLOWED, GUARD_TOLD, GUARD_FOUND, GUARD_PLACE };

/* One function at a point. Its arguments are the state and, last, time. */
struct guard_point {
    struct guard_beside beside;
    double (*error)(void *ctx, int j, enum guard_errors which);        /* of argument j; ctx: beside's */
    double rounding;           /* of its value, as a part */
};

/* By how much errors of the state change it. *jumps (or NULL): true where it jumps among them. Cost: guard_beside_change for each variable. */
double guard_doubt(const struct guard_point *p, enum guard_errors which, bool *jumps);
/* Where a motion begins. side: 1 or -1, the sign that a motion before it left with; otherwise 0. fresh: it is a start of its own, known to what is allowed; otherwise to roundings. */
void guard_track_start(struct guard_track *k, const struct guard_point *p, int side, bool fresh);

/* A least value between two nodes of a table, of one sign: d's last bracket, and the nodes beside it. */
struct guard_low { struct guard_dip d; double left, left_value, right, right_value; };

struct guard_scan {
    const struct guard_table *table;
    const struct guard_way *way;
    void *of;
    /* By how much what is allowed, and roundings of the time where the way begins, change function e there; last: where it ends. */
    double (*doubt)(void *of, int e, bool last);
    /* It changes its sign to `sense` between a and b, with values of these signs; b = 0: where the way begins. */
    void (*change)(void *of, int e, double a, double ga, double b, double gb, int sense);
    /* It touches 0 where the way begins. */
    void (*touch)(void *of, int e);
    /* A least value: two passages, a touch, or none. By how much the value is unsure where it is a touch; negative otherwise. */
    double (*low)(void *of, const struct guard_low *low);
};

/* Function e along the way, whose table is monotone; k becomes the track at its end. */
void guard_scan(const struct guard_scan *s, int e, struct guard_track *k);

#endif
