/* Inside the traj folder: tables as balls where a motion goes on. */
#ifndef SGA_TRAJ_TABLES_AHEAD_H
#define SGA_TRAJ_TABLES_AHEAD_H

#include "enc_tables.h"
#include "knots.h"

/* Each table is its polynomial from the start of a request on, in double and in balls. */
struct tables_ahead {
    struct knots knots;
    struct enc_tables balls;
};

/* bits: of coefficients. False: a table has times that are not exact. tables_ahead_leave, after which tables are themselves, is due all the same. */
bool tables_ahead_enter(struct tables_ahead *a, const struct sys_system *sys, const struct traj_request *q, slong bits);
void tables_ahead_leave(struct tables_ahead *a);

#endif
