/* Algebraic variables that follow a table over one of its steps, in balls. */
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "enclosed.h"
#include "error.h"
#include "flow.h"
#include "mem.h"
#include "reduction.h"
#include "signals.h"
#include "system.h"

/* The proved point may be this far from where double arithmetic came to rest, beside 1 + |x|. */
static const double SAME_POINT = 1e-6;

/* Has e a variable that may jump? */
static bool free_in(const struct flow *f, struct expr_cone *cone, expr_id e)
{
    bool any = false;
    for (int j = 0; j < f->n && !any; j++)
        any = !f->moving[j] && expr_depends(f->sys->store, cone, e, f->sys->variable[j].symbol);
    return any;
}

bool enclosed_jumps(const struct flow *f, const struct sga_solution *sol)
{
    bool any = false;
    for (int i = 0; i < sol->constraints && !any; i++)
        any = signals_jump(f->sys, sol->constraint[i].expr);
    return any;
}

/* Where the midpoint goes to in double; false where that moves what must stay. */
static bool target(struct flow *f, const arb_t t, arb_srcptr x, double *near)
{
    SGA_FREED double *from = sga_malloc((size_t)(f->n + 1) * sizeof *from);
    for (int j = 0; j < f->n; j++)
        near[j] = from[j] = arf_get_d(arb_midref(x + j), ARF_RND_NEAR);
    bool ok = flow_jump(f, arf_get_d(arb_midref(t), ARF_RND_NEAR), near);
    for (int j = 0; j < f->n && ok; j++)
        ok = !f->moving[j] || near[j] == from[j];
    return ok;
}

bool enclosed_jump(struct flow *f, const struct enclose_problem *p, const struct sga_solution *sol, const arb_t t, slong prec, arb_ptr x)
{
    int n = f->n, functions = 0, unknowns = 0;
    SGA_FREED unsigned char *solved = sga_calloc((size_t)n + 1, 1);
    SGA_FREED expr_id *function = sga_malloc((size_t)(sol->constraints + 1) * sizeof *function);
    SGA_FREED double *near = sga_malloc((size_t)(n + 1) * sizeof *near);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < sol->constraints; i++)
        if (free_in(f, &cone, sol->constraint[i].expr))
            function[functions++] = sol->constraint[i].expr;
    for (int j = 0; j < n; j++)
        unknowns += solved[j] = !f->moving[j];
    if (functions != unknowns || !target(f, t, x, near))
        return false;
    for (int j = 0; j < n; j++)
        if (solved[j])
            arb_set_d(x + j, near[j]);
    struct sga_error ignored = { 0 };
    bool ok = enclose_zero(p, function, functions, t, solved, prec, x, &ignored);
    for (int j = 0; j < n && ok; j++)
        ok = !solved[j] || fabs(arf_get_d(arb_midref(x + j), ARF_RND_NEAR) - near[j]) <= SAME_POINT * (1 + fabs(near[j]));
    return ok;
}
