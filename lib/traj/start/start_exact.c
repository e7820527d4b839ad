/* A start in longer numbers: Newton's method with the differentials of doubles and residuals of many bits. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <flint/fmpq.h>

#include "arb_ends.h"
#include "ball.h"
#include "error.h"
#include "manifold.h"
#include "normal.h"
#include "reduction.h"
#include "start_search.h"
#include "system.h"
#include "table_balls.h"

/* Bits of the residuals and of the result, steps, and the residual (of scaled constraints) that counts as 0: below double-double's. */
enum { BITS = 320, KEPT = 200, STEPS = 40 };
static const double DONE = 1e-38, NEAR = 1e-8;

/* The symbols of tables get their values at the start. */
static void set_tables(const struct start_search *s, struct num_ball *b)
{
    const struct sys_system *sys = s->sys;
    SGA_ENDS(arb_end) arb_t v = { 0 };
    for (int i = 0; i < sys->parameters && sys->signals; i++) {
        const struct expr_symbol *p = sys->store->symbol + sys->parameter[i];
        if (p->table) {
            num_table_around(v, p->table, p->order, b->symbol + sys->time, BITS);
            num_ball_set(b, sys->parameter[i], v);
        }
    }
}

/* Scaled residuals at x in m->r, by what m->big was; the largest, or -1. */
static double residuals(struct start_search *s, const struct sga_solution *with, struct manifold *m, arb_srcptr x)
{
    struct num_ball b;
    double worst = 0;
    arf_t v;
    arf_init(v);
    num_ball_init(&b, s->sys->store, BITS);
    for (int j = 0; j < m->n; j++)
        num_ball_set(&b, s->sys->variable[j].symbol, x + j);
    if (s->rq->exact_start) {
        num_ball_extend(&b);
        arb_t t;
        arb_init(t);
        arb_set(t, num_ball_value(&b, s->rq->exact_start));
        num_ball_forget(&b);
        num_ball_set(&b, s->sys->time, t);
        arb_clear(t);
    } else {
        num_ball_set_d(&b, s->sys->time, s->rq->start);
    }
    set_tables(s, &b);
    num_ball_extend(&b);
    for (int i = 0; i < m->c && worst >= 0; i++) {
        arb_srcptr r = num_ball_value(&b, with->constraint[i].expr);
        m->r[i] = arb_is_finite(r) ? arf_get_d(arb_midref(r), ARF_RND_NEAR) / m->big[i] : 0;
        worst = arb_is_finite(r) ? fmax(worst, fabs(m->r[i])) : -1;
    }
    num_ball_clear(&b);
    arf_clear(v);
    return worst;
}

/* Variables of `kept` stay. False: the residuals do not come down; x may have moved. */
static bool come(struct start_search *s, const struct sga_solution *with, struct manifold *m, const double *near, const unsigned char *kept, arb_ptr x)
{
    double last = INFINITY;
    if (manifold_residual(m, s->rq->start, near, NULL, kept) < 0)
        return false;
    arf_t d;
    arf_init(d);
    bool ok = false;
    for (int k = 0; k < STEPS && !ok; k++) {
        double worst = residuals(s, with, m, x);
        ok = worst >= 0 && worst < DONE;
        if (ok || worst < 0 || worst > NEAR || worst > 0.5 * last || normal_step(m->step, m->r, m->d) == 0)
            break;
        last = worst;
        for (int j = 0; j < m->n; j++) {
            if (kept[j])
                continue;
            arf_set_d(d, m->d[j] * m->unit[j]);
            arf_add(arb_midref(x + j), arb_midref(x + j), d, BITS, ARF_RND_NEAR);
        }
    }
    arf_clear(d);
    return ok;
}

/* Given values that stayed are meant as they were written. */
static void begin(struct start_search *s, const double *near, unsigned char *kept, arb_ptr x, bool all)
{
    struct num_ball b;
    num_ball_init(&b, s->sys->store, BITS);
    if (s->rq->exact_initial)
        num_ball_extend(&b);
    for (int j = 0; j < s->sys->variables; j++) {
        bool held = s->rq->held && s->rq->held[j], stays = near[j] == s->rq->initial[j] && (s->rq->given[j] || held);
        expr_id e = stays && s->rq->exact_initial ? s->rq->exact_initial[j] : EXPR_UNDEF;
        kept[j] = held || (stays && !all);
        if (e && arb_is_finite(num_ball_value(&b, e)))
            arb_set(x + j, num_ball_value(&b, e));
        else
            arb_set_d(x + j, near[j]);
        mag_zero(arb_radref(x + j));
    }
    num_ball_clear(&b);
}

bool start_exact(struct start_search *s, const double *near, expr_id *exact, struct sga_error *err)
{
    int n = s->sys->variables;
    struct sga_solution with;
    struct flow f;
    start_with(s, NULL, NULL, &with);
    struct traj_request rq = s->plain;
    rq.no_motion = true;
    bool ok = flow_init(&f, s->sys, &with, &rq, err);
    assert(n > 0);
    if (ok) {
        arb_ptr x = _arb_vec_init(n);
        unsigned char *kept = sga_zeros(&s->mem, (size_t)n + 1, 1);
        ok = false;
        for (int all = 0; all < 2 && !ok; all++) {
            begin(s, near, kept, x, all);
            ok = come(s, &with, f.manifold, near, kept, x);
        }
        fmpq_t q;
        fmpq_init(q);
        for (int j = 0; j < n && ok; j++) {
            bool stays = near[j] == s->rq->initial[j] && kept[j] && s->rq->exact_initial && s->rq->exact_initial[j];
            arf_set_round(arb_midref(x + j), arb_midref(x + j), KEPT, ARF_RND_NEAR);
            arf_get_fmpq(q, arb_midref(x + j));
            exact[j] = stays ? s->rq->exact_initial[j] : expr_fmpq(s->sys->store, q);
        }
        fmpq_clear(q);
        _arb_vec_clear(x, n);
        if (!ok)
            sga_fail_at(err, SGA_E_INITIAL, "/accuracy/arithmetic", "the start that meets the start's equations is not found to more than a double's digits: they touch the constraints there; use "
                        "\"double\", or give the start itself in trajectory.initial");
    }
    flow_clear(&f);
    return ok && expr_store_ok(s->sys->store);
}
