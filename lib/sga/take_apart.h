/* Inside the sga folder: what an equation f = 0 says of the parts of f.
 *
 * Outer functions that have an inverse are taken off (log(u) = 0: u = 1; asin(u) = 0:
 * u = 0), and where a value is at an end of the range of what takes it, each part is at its
 * own end: 2 - cos x - cos y = 0 means cos x = 1 and cos y = 1, which means sin(x/2) = 0
 * and sin(y/2) = 0. Exact: ranges have constants as ends, and two ends are taken as equal
 * only where that is shown. */
#ifndef SGA_SGA_TAKE_APART_H
#define SGA_SGA_TAKE_APART_H

#include "state.h"

/* One way in which f can vanish: functions that vanish together. */
struct take_apart_option {
    expr_id *out; int count; size_t cap;
};

struct take_apart {
    struct take_apart_option *option; int options;   /* none: f has no real zero */
    bool changed;                              /* not just f itself */
};

/* Nothing is found out of functions with large cones: then the only option is f. The
 * caller clears it. */
struct take_apart take_apart_of(struct state *s, expr_id f);
void take_apart_clear(struct take_apart *e);

#endif
