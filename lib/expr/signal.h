/* Functions of time that are given from outside, u(t): symbols of kind EXPR_SIGNAL, one for u
 * and one for each of its derivatives, named u', u'', ... To algebra they are arbitrary: nothing
 * is known of their values, only that the time derivative of one is the next. Numbers come
 * in where a tape is evaluated (table.h). */
#ifndef SGA_EXPR_SIGNAL_H
#define SGA_EXPR_SIGNAL_H

#include "expr.h"

enum { EXPR_SIGNAL_ORDERS = 64 };      /* derivatives of a signal, at most */

/* A new signal with its values (borrowed), or NULL. EXPR_UNDEF where the name is taken. */
expr_id expr_signal_add(struct expr_store *st, const char *name, struct expr_table *table);
/* The time derivative of a signal's symbol; it is added to the store where it is missing, unless
 * st->signals_fixed: then, or past EXPR_SIGNAL_ORDERS, the store's error is set. */
expr_id expr_signal_rate(struct expr_store *st, int symbol);
/* The symbol of that derivative; -1 where the store has none. */
int expr_signal_next(const struct expr_store *st, int symbol);
/* The m-th Taylor coefficient in time, m >= 1. */
expr_id expr_signal_coefficient(struct expr_store *st, int symbol, int m);

/* The derivative of e with respect to time at fixed variables and parameters: by the symbol
 * `time`, and by the signals times their rates. */
expr_id expr_time_partial(struct expr_store *st, expr_id e, int time);

#endif
