/* Inside the enclose folder: the zeros of functions along one step of the solution, each in a ball of time that is proved to hold exactly
 * one, or where nothing is proved a ball that is said not to be decided.
 *
 * For s in a ball the set gives a box (enc_step_at); there the function g and its derivative d along the field are evaluated. Without 0 in
 * g there is no zero; without 0 in d there is one at most, and signs at the ends say which; both with 0: halves. What is found is made small
 * by Newton's method in intervals, s in m - g(m) / d. (Moore, Interval Analysis, 1966, section 7.3; for solutions of differential equations
 * Nedialkov, von Mohrenschildt, Rigorous simulation of hybrid dynamic systems, HSCC 2002, is near.) */
#ifndef SGA_ENCLOSE_ZEROS_H
#define SGA_ENCLOSE_ZEROS_H

#include "lohner.h"

struct enc_zeros {
    const struct enclose_problem *q;
    struct enclose_happened *out;
    struct enc_program p;        /* the field, then for each function its value and its rate */
    struct enc_series at;
    /* Where functions jump, of which their rates say nothing: by function and by rate (2 watches + 1) the first place in this list, of roots a (that jumps where its value is 0) and b (and
     * this is negative; -1: no matter). */
    struct enc_jump { int a, b; } *jump;
    int *jumps;
    signed char *side;           /* by function: its sign where the next step begins; 0: not shown */
    int *left;                   /* by function: how often it still counts; -1: always */
    slong prec;
    bool strict;                 /* as enclose_path's */
};

/* A step that is to be taken to s, from the set at time t. */
struct enc_span {
    const struct enc_step *step;
    const struct enc_set *set;
    const arb_struct *t, *s;
    bool first;                  /* from the start: a zero there does not count */
};

/* False with err where a function does not compile. */
bool enc_zeros_init(struct enc_zeros *z, const struct enclose_problem *q, struct enclose_happened *out, slong prec, struct sga_error *err);
void enc_zeros_clear(struct enc_zeros *z);
/* The signs at the start, the set at t. */
void enc_zeros_begin(struct enc_zeros *z, const struct enc_set *set, const arb_t t);
/* Beyond a knot at t, before which enc_zeros_begin was at the same place: functions that jump there past 0 happen at t (not decided where a sign is not shown). The answer is
 * that of enc_zeros_along. */
int enc_zeros_beyond(struct enc_zeros *z, const struct enc_set *set, const arb_t t, int piece, bool backward);
/* Whether the sign of every function is shown at the end of the span. */
bool enc_zeros_told(struct enc_zeros *z, const struct enc_span *span);
/* The zeros of the span, in the order of the motion, behind those in z->out. The place there of the first that stops the motion, or may; -1. Cost: for
 * each function at least one box, for each zero some twenty. */
int enc_zeros_along(struct enc_zeros *z, const struct enc_span *span);

#endif
