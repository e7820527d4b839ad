/* Inside jump_boxed_*.c: one event, between two pieces in balls. */
#ifndef SGA_TRAJ_JUMP_BOXED_BETWEEN_H
#define SGA_TRAJ_JUMP_BOXED_BETWEEN_H

#include "jump_boxed.h"
#include "jump_set.h"

struct tables_ahead;

/* An impulse: velocities as they are set, by coordinate; multipliers, and whether it is in use, by condition. */
struct boxed_struck { arb_ptr v0, mu; bool *use; };

struct between {
    struct jump_boxed *b;
    const struct jump *from, *to;
    const struct traj_mode *was, *mode;   /* of `from`, of `to` */
    const struct jump_at *at;
    const struct jump_to *landed;
    arb_srcptr x;                 /* before: variables of `from`, then derivatives, if any */
    arb_ptr asked, y;             /* of `to`: as set; where it goes on */
    unsigned char *stays;         /* of `to`: not set, and there before */
    unsigned char *solved, *used; /* of `to`: unknowns, and the constraints that they were solved from */
    struct boxed_struck struck;   /* where there are masses */
    bool happens;                 /* an event does; otherwise the motion begins, and its time stays */
    bool nearest;                 /* it is a nearest point instead, of this request; unit: by variable of `to`; steady: none of them follows a value */
    struct traj_request q;
    double *unit;
    bool steady;
    struct tables_ahead *ahead;   /* where the motion goes on; tables: whether it is known */
    bool tables;
    struct sga_arena *mem;
};

/* jump_impulse_boxed.c: x (n of `to`) with velocities as they are set becomes x after the impulse, near landed->x, and w->struck is set. False: that is not shown. */
bool jump_impulse_boxed(struct between *w, arb_ptr x);
/* jump_impulse_boxed_slope.c: y (directions x variables of `to`): derivatives along the event as values are set become those after the impulse, which left w->y; tau: of its
 * time. False: they are not shown. */
bool jump_impulse_boxed_slope(const struct between *w, arb_srcptr tau, arb_ptr y);
/* jump_boxed_slope.c. slope (directions x variables of `to`): derivatives where the motion goes on, at w->y. False: they are not shown. */
bool jump_boxed_slope(const struct between *w, arb_ptr slope);

#endif
