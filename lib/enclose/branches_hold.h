/* Inside the enclose folder: what must not come to 0 while the solution moves from s = 0 to h.
 *
 * The formal solution follows the branches of abs, sign, min, max and atan2 that hold at the start. It is the
 * solution if those hold along it: |a|, max(a, b) where a, a - b do not come to 0, atan2(y, x) where always y is not 0 or x > 0. Shown for
 * all starts of the series, by the norm (|f_0| > |f - f_0|) or on parts of the way. */
#ifndef SGA_ENCLOSE_BRANCHES_HOLD_H
#define SGA_ENCLOSE_BRANCHES_HOLD_H

#include "tail.h"

/* Whether branches hold for s from 0 to h, |h| <= R, and the roots after `fields` do not vanish. If not, bad is the
 * number of such a root, or -1. */
bool enc_branches_hold(const struct enc_tail *t, double h, int fields, int *bad);

#endif
