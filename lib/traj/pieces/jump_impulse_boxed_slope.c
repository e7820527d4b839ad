/* Derivatives of velocities after an impulse, in balls: the equations of jump_impulse_boxed.c, differentiated along the event (jump_slope.h). They are linear in dv and dmu where
 * the conditions are linear in the velocities, and are asked to be. */
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "derive.h"
#include "error.h"
#include "field.h"
#include "jump_boxed_between.h"
#include "jump_impulse.h"
#include "jump_impulse_parts.h"
#include "mem.h"
#include "reduction.h"
#include "signal.h"
#include "system.h"

struct sloping {
    const struct between *w;
    const struct traj_mass *m;
    const struct traj_carried *own;
    struct impulse p;
    int q, n, roots;
    arb_ptr out;                  /* roots at where the motion goes on */
    arb_ptr along, by_time;       /* the same along one direction, with free velocities at rest; by time */
    struct sga_arena mem;
};

/* By condition: its constraint among those of the carried system. */
static int *rows_of(struct sloping *s)
{
    const struct sga_solution *sol = s->w->to->sol;
    unsigned char *is = sga_zeros(&s->mem, (size_t)sol->constraints + 1, 1);
    int *row = sga_zeros(&s->mem, (size_t)s->p.conditions + 1, sizeof *row), c = 0;
    jump_impulse_conditions(s->w->to, is);
    for (int i = 0; i < sol->constraints; i++)
        if (is[i])
            row[c++] = i * (1 + s->q);
    return row;
}

/* Roots along direction d (d = q: by time). False: a gradient changes with velocities. */
static bool write(struct sloping *s, const int *row, int d, expr_id *root)
{
    const struct sys_system *sys = s->own->sys;
    struct expr_store *st = sys->store;
    int place = 0;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int k = 0; k < s->m->entries; k++)
        root[place++] = d < s->q ? s->own->rq->slopes->mass[k * s->q + d] : expr_time_partial(st, s->own->rq->mass->value[k], sys->time);
    for (int i = 0; i < s->p.conditions; i++)
        root[place++] = d < s->q ? s->own->sol->constraint[row[i] + 1 + d].expr : expr_time_partial(st, s->own->sol->constraint[row[i]].expr, sys->time);
    for (int k = 0; k < s->p.terms; k++) {
        expr_id e = expr_diff(st, root[s->m->entries + s->p.row[k]], sys->variable[s->m->velocity[s->p.col[k]]].symbol);
        for (int i = 0; i < s->p.coordinates && d < s->q; i++)
            if (expr_depends(st, &cone, e, sys->variable[s->n + d * s->n + s->m->velocity[i]].symbol))
                return false;
        root[place++] = e;
    }
    return expr_store_ok(st);
}

/* The matrix, of unknowns dv of free velocities and dmu of conditions in use; place: by coordinate, then by condition, or -1. */
static void fill(const struct sloping *s, const int *place, arb_mat_t K)
{
    for (int k = 0; k < s->m->entries; k++)
        if (place[s->m->row[k]] >= 0 && place[s->m->col[k]] >= 0) {
            arb_ptr to = arb_mat_entry(K, place[s->m->row[k]], place[s->m->col[k]]);
            arb_add(to, to, s->out + k, s->w->b->piece.prec + 20);
        }
    for (int k = 0; k < s->p.terms; k++) {
        int v = place[s->p.col[k]], c = place[s->p.coordinates + s->p.row[k]];
        if (v < 0 || c < 0)
            continue;
        arb_srcptr g = s->out + s->m->entries + s->p.conditions + k;
        arb_set(arb_mat_entry(K, c, v), g);
        arb_neg(arb_mat_entry(K, v, c), g);
    }
}

/* to += a (d + e tau). */
static void add_change(const struct sloping *s, int root, arb_srcptr tau, const arb_t a, arb_t to)
{
    SGA_ENDS(arb_end) arb_t change = { 0 };
    arb_mul(change, s->by_time + root, tau, s->w->b->piece.prec + 20);
    arb_add(change, change, s->along + root, s->w->b->piece.prec + 20);
    arb_addmul(to, change, a, s->w->b->piece.prec + 20);
}

/* The right side, for derivatives v0_rate of velocities as they are set; fixed ones have theirs. */
static void right_side(const struct sloping *s, const int *place, arb_srcptr tau, arb_srcptr v0_rate, arb_mat_t b)
{
    const struct between *w = s->w;
    slong prec = w->b->piece.prec + 20;
    SGA_ENDS(arb_end) arb_t v = { 0 }, one = { 0 };
    arb_one(one);
    for (int k = 0; k < s->m->entries; k++) {
        int i = s->m->row[k], c = s->m->col[k];
        if (place[i] < 0)
            continue;
        arb_sub(v, w->struck.v0 + c, w->y + s->m->velocity[c], prec);
        add_change(s, k, tau, v, arb_mat_entry(b, place[i], 0));
        if (place[c] >= 0)       /* what is set moves with what it is set to */
            arb_addmul(arb_mat_entry(b, place[i], 0), s->out + k, v0_rate + c, prec);
    }
    for (int k = 0; k < s->p.terms; k++)
        if (place[s->p.col[k]] >= 0 && place[s->p.coordinates + s->p.row[k]] >= 0)
            add_change(s, s->m->entries + s->p.conditions + k, tau, w->struck.mu + s->p.row[k], arb_mat_entry(b, place[s->p.col[k]], 0));
    for (int i = 0; i < s->p.conditions; i++)
        if (place[s->p.coordinates + i] >= 0) {
            arb_ptr to = arb_mat_entry(b, place[s->p.coordinates + i], 0);
            add_change(s, s->m->entries + i, tau, one, to);
            arb_neg(to, to);
        }
}

/* y (q x n) of direction d. */
static bool solve(struct sloping *s, const int *place, int unknowns, int d, arb_srcptr tau, arb_ptr y)
{
    arb_ptr rate = arbs_take(&s->mem, s->p.coordinates);
    SGA_ENDS(arb_mat_end) arb_mat_t K, b;
    arb_mat_init(K, unknowns, unknowns);
    arb_mat_init(b, unknowns, 1);
    fill(s, place, K);
    for (int i = 0; i < s->p.coordinates; i++)
        arb_set(rate + i, y + d * s->n + s->m->velocity[i]);
    right_side(s, place, tau, rate, b);
    bool ok = arb_mat_solve(b, K, b, s->w->b->piece.prec + 20);
    for (int i = 0; i < s->p.coordinates && ok; i++)
        if (place[i] >= 0)
            arb_set(y + d * s->n + s->m->velocity[i], arb_mat_entry(b, place[i], 0));
    return ok;
}

static bool run(struct sloping *s, arb_srcptr tau, arb_ptr y)
{
    const struct between *w = s->w;
    int all = s->n * (1 + s->q), unknowns = 0;
    int *place = sga_zeros(&s->mem, (size_t)(s->p.coordinates + s->p.conditions) + 1, sizeof *place), *row = rows_of(s);
    expr_id *root = sga_zeros(&s->mem, (size_t)s->roots + 1, sizeof *root);
    arb_ptr in = arbs_take(&s->mem, all);
    for (int i = 0; i < s->p.coordinates; i++)
        place[i] = w->landed->changed[s->m->velocity[i]] ? -1 : unknowns++;
    for (int i = 0; i < s->p.conditions; i++)
        place[s->p.coordinates + i] = w->struck.use[i] ? unknowns++ : -1;
    s->out = arbs_take(&s->mem, s->roots);
    s->along = arbs_take(&s->mem, s->roots);
    s->by_time = arbs_take(&s->mem, s->roots);
    _arb_vec_set(in, w->y, s->n);
    bool ok = enclosed_values(w->to->sys, &w->b->t, w->y, s->p.root, s->roots, w->b->piece.prec, s->out) && write(s, row, s->q, root)
              && enclosed_values(s->own->sys, &w->b->t, in, root, s->roots, w->b->piece.prec, s->by_time);
    for (int d = 0; d < s->q && ok; d++) {
        _arb_vec_set(in + s->n, y, (slong)s->q * s->n);
        for (int i = 0; i < s->p.coordinates; i++)
            if (place[i] >= 0)
                arb_zero(in + s->n + d * s->n + s->m->velocity[i]);
        ok = write(s, row, d, root) && enclosed_values(s->own->sys, &w->b->t, in, root, s->roots, w->b->piece.prec, s->along) && solve(s, place, unknowns, d, tau + d, y);
    }
    return ok;
}

bool jump_impulse_boxed_slope(const struct between *w, arb_srcptr tau, arb_ptr y)
{
    struct sloping s = { .w = w, .m = w->to->rq->mass, .own = w->to->rq->carried, .n = w->to->n };
    struct sga_error ignored = { 0 };
    s.q = s.own->rq->slopes->directions;
    bool ok = jump_impulse_init(&s.p, w->to, &ignored);
    s.roots = s.m->entries + s.p.conditions + s.p.terms;
    if (ok && s.p.conditions)
        ok = run(&s, tau, y);
    jump_impulse_clear(&s.p);
    sga_arena_end(&s.mem);
    return ok;
}
