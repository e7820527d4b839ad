/* Smoothness of what depends on tables, and their knots. */
#include "signals.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ball.h"
#include "buf.h"
#include "error.h"
#include "mem.h"
#include "print.h"
#include "reduction.h"
#include "system.h"
#include "table.h"

/* The first symbol among roots that is a derivative of a table higher by more than `beyond` than what
 * has no jumps; NULL where there is none. *root: whose. */
static const struct expr_symbol *jumping(const struct expr_store *st, const expr_id *root, int roots, int beyond, int *which)
{
    const struct expr_symbol *found = NULL;
    struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < roots && !found; i++) {
        expr_cone_of(st, &cone, root + i, 1);
        for (int k = 0; k < cone.count && !found; k++) {
            const struct expr_node *n = st->node + cone.list[k];
            const struct expr_symbol *s = n->op == EXPR_SYM ? st->symbol + n->a : NULL;
            if (s && s->table && s->order > expr_table_smooth(s->table) + beyond)
                found = s;
        }
        *which = i;
    }
    expr_cone_clear(&cone);
    return found;
}

static bool refuse(const struct expr_store *st, const struct expr_symbol *s, const char *what, expr_id e, struct sga_error *err)
{
    struct sga_buf text = { 0 };
    int base = 0;
    if (e && !expr_print(st, e, 160, &text))
        sga_buf_free(&text);
    for (int i = 0; i < st->symbols; i++)
        if (st->symbol[i].table == s->table && st->symbol[i].order == 0)
            base = i;
    char pointer[200];
    snprintf(pointer, sizeof pointer, "/system/tables/%.150s/interpolation", st->symbol[base].name);
    const char *kind = s->table->kind == EXPR_LINEAR ? "linear" : "cubic";
    if (s->table->steps)
        sga_fail_at(err, SGA_E_NOT_SUPPORTED, pointer, "%s%s%.160s depends on %.60s, which has %s, so that the motion would jump there; put samples beside each other in the place of each step, or "
                    "end the motion at the step and begin another one", what, text.len ? " " : "", text.len ? text.data : "", s->name, s->order ? "no values at the table's steps" : "steps");
    else
        sga_fail_at(err, SGA_E_NOT_SUPPORTED, pointer, "%s%s%.160s depends on %.60s, which with %s interpolation %s at the knots, so "
                    "that the motion would jump there; %s", what, text.len ? " " : "", text.len ? text.data : "", s->name, kind,
                    s->order > expr_table_smooth(s->table) + 1 ? "has no values" : "jumps",
                    s->table->kind == EXPR_LINEAR ? "use \"cubic\", which has two continuous derivatives"
                                                  : "a table has two continuous derivatives at most: give the function as an expression");
    memcpy(err->stage, "trajectory", 11);
    sga_buf_free(&text);
    return false;
}

/* One list against its rule. */
static bool smooth(const struct sys_system *sys, const expr_id *root, int roots, int beyond, const char *what, struct sga_error *err)
{
    int which = 0;
    const struct expr_symbol *s = jumping(sys->store, root, roots, beyond, &which);
    return !s || refuse(sys->store, s, what, root[which], err);
}

bool signals_jump(const struct sys_system *sys, expr_id e)
{
    int which;
    return jumping(sys->store, &e, 1, 0, &which) != NULL;
}

static bool has_knot(const struct expr_table *u, double t)
{
    bool has = false;
    for (int k = 1; k + 1 < u->knots; k++)
        has |= fabs(u->time[k] - t) <= 4 * DBL_EPSILON * fabs(t);
    return has;
}

bool signals_bend(const struct sys_system *sys, expr_id e, int more, double t)
{
    const struct expr_store *st = sys->store;
    struct expr_cone cone;
    bool bends = false;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    for (int k = 0; k < cone.count && !bends; k++) {
        const struct expr_node *n = st->node + cone.list[k];
        const struct expr_symbol *s = n->op == EXPR_SYM ? st->symbol + n->a : NULL;
        bends = s && s->table && s->order + more > expr_table_smooth(s->table) && has_knot(s->table, t);
    }
    expr_cone_clear(&cone);
    return bends;
}

/* It has a variable that may jump, and jumps itself at knots, no worse. */
static bool may_follow(const struct sys_system *sys, expr_id e, const unsigned char *moving)
{
    struct expr_cone cone;
    bool may = false;
    int which;
    if (jumping(sys->store, &e, 1, 1, &which))
        return false;
    expr_cone_init(&cone);
    for (int j = 0; j < sys->variables && !may; j++)
        may = !moving[j] && expr_depends(sys->store, &cone, e, sys->variable[j].symbol);
    expr_cone_clear(&cone);
    return may;
}

/* Variables that may jump have derivatives between the knots only. */
static bool smooth_field(const struct sys_system *sys, const expr_id *field, const unsigned char *moving, struct sga_error *err)
{
    bool ok = true;
    for (int j = 0; j < sys->variables && ok; j++)
        ok = smooth(sys, field + j, 1, moving && !moving[j] ? 2 : 1, "the derivative of a variable,", err);
    return ok;
}

bool signals_continuous(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                        const expr_id *field, const unsigned char *moving, struct sga_error *err)
{
    int checked = 0;
    if (!sys->signals)
        return true;
    size_t most = (size_t)(sol->constraints + rq->events + rq->rates) + 1;
    expr_id *root = sga_malloc(most * sizeof *root);
    for (int i = 0; i < sol->constraints; i++)
        if (!moving || !may_follow(sys, sol->constraint[i].expr, moving))
            root[checked++] = sol->constraint[i].expr;
    bool ok = smooth(sys, root, checked, 0, "the constraint", err);
    for (int i = 0; i < rq->events; i++)
        root[i] = rq->event[i].expression;
    ok = ok && smooth(sys, root, rq->events, 0, "the event", err);
    for (int i = 0; i < rq->rates; i++)
        root[i] = rq->rate[i].rate;
    ok = ok && smooth(sys, root, rq->rates, 1, "the rate", err)
         && smooth_field(sys, field, moving, err)
         && smooth(sys, rq->output, rq->outputs, 1, "the output", err);
    free(root);
    return ok;
}

void signals_set(const struct sys_system *sys, double t, struct num_ball *b)
{
    for (int i = 0; i < sys->parameters && sys->signals; i++) {
        const struct expr_symbol *s = sys->store->symbol + sys->parameter[i];
        if (s->table)
            num_ball_set_d(b, sys->parameter[i], expr_table_value(s->table, s->order, t));
    }
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double *signals_knots(const struct sys_system *sys, const struct traj_request *rq, int *count)
{
    double *knot = NULL;
    size_t cap = 0;
    int n = 0;
    *count = 0;
    if (!sys->signals || !rq->samples || !rq->times)
        return NULL;
    double stop = rq->times[rq->samples - 1], low = fmin(rq->start, stop), high = fmax(rq->start, stop);
    double apart = 64 * DBL_EPSILON * fmax(fabs(low), fabs(high));     /* of 0.1 * 3 and 0.3 one is enough */
    for (int k = 0; k < sys->signals; k++) {
        const struct expr_table *u = sys->store->symbol[sys->signal[k]].table;
        for (int i = 0; i < u->knots; i++)
            if (u->time[i] > low + apart && u->time[i] < high - apart) {
                SGA_RESERVE(knot, cap, n + 1);
                knot[n++] = u->time[i];
            }
    }
    if (n)
        qsort(knot, (size_t)n, sizeof *knot, ascending);
    for (int i = 0; i < n; i++)
        if (!*count || knot[i] > knot[*count - 1] + apart)
            knot[(*count)++] = knot[i];
    for (int i = 0; stop < rq->start && i < *count / 2; i++) {
        double other = knot[*count - 1 - i];
        knot[*count - 1 - i] = knot[i];
        knot[i] = other;
    }
    for (int i = 0; i < *count; i++)       /* steps end at them one after the other */
        assert((knot[i] - (i > 0 ? knot[i - 1] : rq->start)) * (stop - rq->start) > 0);
    return knot;
}

void signals_between(const struct sys_system *sys, double from, double to)
{
    for (int k = 0; k < sys->signals; k++) {
        struct expr_table *u = sys->store->symbol[sys->signal[k]].table;
        u->at = isnan(from) ? -1 : expr_table_interval(u, from + (to - from) / 2);
    }
}

void signals_ahead(const struct sys_system *sys, const struct traj_request *rq)
{
    int count;
    double *knot = signals_knots(sys, rq, &count);
    if (sys->signals)
        signals_between(sys, rq->start, count ? knot[0] : rq->times[rq->samples - 1]);
    free(knot);
}
