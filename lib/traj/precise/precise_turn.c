/* See precise_turn.h. */
#include "precise_turn.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "field.h"
#include "flow.h"
#include "jet.h"
#include "manifold.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "precise_series.h"
#include "switches.h"
#include "system.h"
#include "tape.h"
#include "trajectory.h"
#include "variation_turn.h"

/* Rounds of what is solved for and of what jumps, from doubles. */
enum { ROUNDS = 3 };

struct precise_turn {
    struct num_tape *tape;        /* roots: surfaces x directions, their rates along the motion, the motion's field */
    struct num_jet2 *jet;
    int base, directions, surfaces;
    num_dd *from, *field, *tau;   /* n; base; directions */
    double *at, *before;          /* n each: in double */
};

struct precise_turn *precise_turn_new(const struct precise *p, struct sga_error *err)
{
    const struct traj_turns *q = p->rq->turns;
    const struct num_switches *s = field_switches(p->flow->field);
    size_t n = (size_t)p->n, slopes = q ? (size_t)(q->surfaces * q->directions) : 0;
    if (!q || !q->jumps || !s || !p->flow->turn)
        return NULL;
    assert(n == (size_t)(q->base * (1 + q->directions)));
    struct precise_turn *w = sga_calloc(1, sizeof *w);
    *w = (struct precise_turn){ .base = q->base, .directions = q->directions, .surfaces = q->surfaces };
    SGA_FREED expr_id *root = sga_malloc((slopes + (size_t)(q->surfaces + q->base) + 1) * sizeof *root);
    SGA_FREED int *inputs = field_inputs(p->sys);
    memcpy(root, q->slope, slopes * sizeof *root);
    memcpy(root + slopes, q->rate, (size_t)q->surfaces * sizeof *root);
    memcpy(root + slopes + q->surfaces, p->flow->field->root, (size_t)q->base * sizeof *root);
    w->tape = num_tape_new_switched(p->sys->store, s, root, (int)slopes + q->surfaces + q->base, inputs, p->n + 1, err);
    w->jet = w->tape ? num_jet2_new(w->tape, 0) : NULL;
    w->from = sga_calloc(n + (size_t)(q->base + q->directions) + 1, sizeof *w->from);
    w->field = w->from + n;
    w->tau = w->field + q->base;
    w->at = sga_calloc(2 * n + 1, sizeof *w->at);
    w->before = w->at + n;
    if (w->jet)
        return w;
    precise_turn_free(w);
    return NULL;
}

void precise_turn_free(struct precise_turn *w)
{
    if (!w)
        return;
    num_jet2_free(w->jet);
    num_tape_free(w->tape);
    free(w->from);
    free(w->at);
    free(w);
}

/* The roots at m->here, with the sides that are held. */
static bool evaluate(struct precise_march *m)
{
    struct precise_turn *w = m->p->turn;
    num_tape_hold(w->tape, m->sides.natural ? NULL : m->sides.side);
    num_jet2_hold(w->jet, w->tape);
    for (int j = 0; j < m->n; j++)
        num_jet2_input(w->jet, j)[0] = m->here.x[j];
    num_jet2_input(w->jet, m->n)[0] = m->here.t;
    return num_jet2_next(w->jet, 0);
}

static num_dd field_of(const struct precise_turn *w, int j)
{
    return num_jet2_root(w->jet, w->surfaces * (1 + w->directions) + j)[0];
}

/* dt/dk of the first pending switch whose time moves; that all of them agree is seen in double. */
static void find_times(struct precise_march *m)
{
    struct precise_turn *w = m->p->turn;
    const struct variation_turn *v = m->p->flow->turn;
    bool found = false;
    for (int d = 0; d < w->directions; d++)
        w->tau[d] = num_dd_of(0);
    for (int e = 0; e < m->sides.count && !found; e++) {
        int i = v->surface_of[e];
        if (!m->sides.pending[e] || i < 0)
            continue;
        num_dd rate = num_jet2_root(w->jet, w->surfaces * w->directions + i)[0];
        for (int d = 0; d < w->directions; d++) {
            num_dd slope = num_jet2_root(w->jet, i * w->directions + d)[0];
            found |= slope.hi != 0;
            w->tau[d] = slope.hi != 0 ? num_dd_neg(num_dd_div(slope, rate)) : num_dd_of(0);
        }
    }
}

bool precise_turn_from(struct precise_march *m)
{
    struct precise_turn *w = m->p->turn;
    memcpy(w->from, m->here.x, (size_t)m->n * sizeof *w->from);
    bool ok = evaluate(m);
    for (int j = 0; j < m->n; j++) {
        w->at[j] = w->from[j].hi;
        w->before[j] = j < w->base ? field_of(w, j).hi : 0;
    }
    for (int j = 0; j < w->base && ok; j++)
        w->field[j] = field_of(w, j);
    find_times(m);
    return ok;
}

/* What has a derivative is what it was, derivatives along the directions with their jumps. */
static void put_in(struct precise_march *m)
{
    struct precise_turn *w = m->p->turn;
    for (int d = 0; d <= w->directions; d++)
        for (int j = 0; j < w->base; j++) {
            int i = d * w->base + j;
            if (!m->p->flow->moving[i])
                continue;
            m->here.x[i] = d ? num_dd_add(w->from[i], num_dd_mul(num_dd_sub(w->field[j], field_of(w, j)), w->tau[d - 1])) : w->from[i];
        }
}

bool precise_turn_to(struct precise_march *m, const struct expansion *near)
{
    struct precise_turn *w = m->p->turn;
    struct flow *f = m->p->flow;
    double moved, residual;
    int rounds = 0;
    do {        /* what jumps turns others, as precise_carry has it */
        memcpy(m->xd, w->at, (size_t)m->n * sizeof *m->xd);
        m->why = ODE_CONSTRAINT_LOST;
        if (f->manifold->c && !flow_jump(f, m->here.t.hi, m->xd))
            return false;
        for (int j = 0; j < m->n; j++)
            m->here.x[j] = num_dd_of(m->xd[j]);
        m->why = ODE_NOT_SMOOTH;
        if (rounds++ > precise_rounds(m))
            return false;
        precise_doubt_both(m, near);
        for (int e = 0; e < m->sides.count; e++)      /* here has the digits of double now */
            m->sides.doubt[e] = fmax(m->sides.doubt[e], m->sides.rounding[e] * (DBL_EPSILON / NUM_DD_EPSILON));
    } while (precise_turn_leapt(m));
    if (!variation_turned(f, m->here.t.hi, w->at, w->before, m->sides.pending, m->xd))
        return false;
    m->why = ODE_LEFT_DOMAIN;
    for (int j = 0; j < m->n; j++)
        m->here.x[j] = num_dd_of(m->xd[j]);
    for (int k = 0; k < ROUNDS; k++) {
        if (!evaluate(m))
            return false;
        put_in(m);
        precise_project(m->p, m->here.t, m->here.x, m->scale, f->moving, &moved, &residual);       /* what rests is judged at the end */
    }
    return precise_settle(m, &m->here);
}
