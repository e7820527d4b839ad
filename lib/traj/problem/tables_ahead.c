/* See tables_ahead.h. */
#include "tables_ahead.h"

#include "error.h"
#include "signals.h"

bool tables_ahead_enter(struct tables_ahead *a, const struct sys_system *sys, const struct traj_request *q, slong bits)
{
    struct sga_error ignored = { 0 };
    *a = (struct tables_ahead){ 0 };
    if (!knots_init(&a->knots, sys, q, &ignored))
        return false;
    signals_ahead(sys, q);
    enc_tables_init(&a->balls, a->knots.table, a->knots.tables);
    enc_tables_round(&a->balls, bits);
    enc_tables_enter(&a->balls);
    return true;
}

void tables_ahead_leave(struct tables_ahead *a)
{
    enc_tables_clear(&a->balls);
    knots_clear(&a->knots);
}
