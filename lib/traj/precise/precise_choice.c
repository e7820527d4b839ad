/* The choice between series and implicit steps in double-double, while marching.
 *
 * Terms (h l)^k / k! of a fast part of size d e (e the error allowed) grow up to e where h l is about
 * (k!/d)^(1/k); parts that are of the size of the solution itself, and the tolerance with it, keep h l
 * some 6 times smaller for the orders k that belong to tolerances. So steps that stability limits show by
 * h times the largest eigenvalue l of the Jacobian, which is looked at after a number of steps
 * where many are left. Then, as in lib/ode/switch.c, it is tried: some implicit steps are made, and
 * those go on that come farther for their work. Work is counted, never measured, so that runs
 * repeat exactly. The way back: where the series is long enough, and the largest eigenvalue
 * would let steps of that size be stable. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "field.h"
#include "flow.h"
#include "lin_sparse.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "trajectory.h"

#define TRY_AFTER 30
#define MANY_LEFT 100.0        /* steps to the last time, for a trial to be worth its work */
#define TRIAL_FEWEST 4
#define TRIAL 16               /* implicit steps */
#define BACK_AFTER 40
#define GAIN 1.3               /* by which another method must be better */
#define FIRST_SIZE 3.0         /* of a trial, in sizes of the steps before */
#define MOST_WAIT 240          /* steps between looks */
/* h l over (k!)^(1/k): limited by stability, perhaps; stable with room. */
#define STIFF 0.4
#define STABLE 0.65
#define POWER_STEPS 12

enum { SERIES, IMPLICIT };
static const struct precise_method *const methods[] = { &precise_series, &precise_radau };

static void use(struct precise_march *m, int which)
{
    m->method = methods[which];
    if (!m->choice.state[which])
        m->choice.state[which] = m->method->alloc(m);
    m->state = m->choice.state[which];
    m->choice.size = m->choice.work = 0;
}

void precise_choice_begin(struct precise_march *m)
{
    const char *name = m->p->rq->method;
    m->choice.free = (!name || strcmp(name, "auto") == 0) && precise_radau_possible(m->p->flow->field);
    m->choice.try_at = m->choice.wait = m->choice.look = TRY_AFTER;
    m->choice.asked = name && strcmp(name, "radau") == 0;
    use(m, m->choice.asked ? IMPLICIT : SERIES);
}

void precise_choice_renew(struct precise_march *m)
{
    struct precise_choice *c = &m->choice;
    for (int k = 0; k < 2; k++) {
        if (c->state[k])
            methods[k]->free(c->state[k]);
        c->state[k] = NULL;
    }
    c->on_trial = false;
    use(m, m->method == &precise_radau);
}

void precise_choice_end(struct precise_march *m)
{
    const struct precise_choice *c = &m->choice;
    assert(c->steps[SERIES] + c->steps[IMPLICIT] == m->path->steps);
    m->path->method = c->steps[SERIES] && c->steps[IMPLICIT] ? "taylor, radau"
                      : c->steps[IMPLICIT] ? precise_radau.name : c->steps[SERIES] ? precise_series.name : m->method->name;
    for (int k = 0; k < 2; k++)
        if (c->state[k])
            methods[k]->free(c->state[k]);
}

/* The largest |eigenvalue| of the Jacobian here, by a power iteration; INFINITY where it has no value. */
static double spectral_radius(struct precise_march *m)
{
    struct field *f = m->p->flow->field;
    struct lin_sparse *J = f->pattern;
    int n = m->n, counted = 0;
    double *v = sga_malloc(3 * (size_t)n * sizeof *v), *w = v + n, *x = w + n, growth = 0;
    for (int j = 0; j < n; j++)
        x[j] = m->here.x[j].hi;
    bool ok = field_slope(f, m->here.t.hi, x, J->val);
    for (int j = 0; j < n; j++)
        v[j] = m->scale[j] * (1 + 0.5 * sin(1.0 + 2.3 * j));
    for (int k = 0; k < POWER_STEPS && ok; k++) {
        double before = 0, after = 0;
        lin_sparse_times(J, v, w);
        for (int j = 0; j < n; j++) {
            before = hypot(before, v[j] / m->scale[j]);
            after = hypot(after, w[j] / m->scale[j]);
        }
        if (!(after > 0) || !isfinite(after)) {
            ok = after == 0;
            break;
        }
        for (int j = 0; j < n; j++)
            v[j] = w[j] / after * before;
        if (k >= POWER_STEPS / 2) {
            growth += log(after / before);
            counted++;
        }
    }
    free(v);
    return ok ? counted ? exp(growth / counted) : 0 : INFINITY;
}

/* h |largest eigenvalue| over (k!)^(1/k). */
static double stiffness(struct precise_march *m, double h)
{
    double logs = 0;
    for (int k = 2; k <= m->p->order; k++)
        logs += log(k);
    return h * spectral_radius(m) / exp(logs / m->p->order);
}

/* Implicit steps so far: series from now on, if they come farther for their work. */
static bool back_to_series(struct precise_march *m)
{
    struct precise_choice *c = &m->choice;
    void *state = c->state[SERIES];
    double most = fabs(precise_rest(m).hi), size = c->size, work = c->work;
    if (!state)
        state = c->state[SERIES] = precise_series.alloc(m);
    if (!precise_series.begin(state, m, fmin(64 * size, most)))
        return false;
    double there = fabs(precise_series.size(state, m, 1).hi), cost = precise_series.cost(state, m);
    if (!(there / cost > GAIN * size / work))
        return false;
    there *= fmin(1, STABLE / fmax(stiffness(m, there), 1e-300));
    if (!(there / cost > GAIN * size / work))
        return false;
    use(m, SERIES);
    return true;
}

static void end_trial(struct precise_march *m)
{
    struct precise_choice *c = &m->choice;
    long made = m->path->steps - c->trial_from;
    assert(made > 0 && c->work > 0);
    double now = c->size / c->work;
    if (made >= TRIAL_FEWEST && now > GAIN * c->before) {
        c->on_trial = false;
        c->wait = TRY_AFTER;
        c->try_at = m->path->steps + BACK_AFTER;
    } else if (made >= TRIAL || (made >= TRIAL_FEWEST && now < 0.1 * c->before)) {
        c->on_trial = false;
        c->wait *= 2;
        c->try_at = m->path->steps + c->wait;
        use(m, SERIES);
        if (!m->method->begin(m->state, m, fabs(precise_rest(m).hi)))
            use(m, IMPLICIT);
    }
}

/* Other steps would take their sides anew here: not where they were just turned, or are not known. */
static bool beside_turn(const struct precise_march *m)
{
    const struct precise_sides *q = &m->sides;
    return q->count && (q->natural || (q->turned_t.hi == m->here.t.hi && q->turned_t.lo == m->here.t.lo));
}

void precise_choose(struct precise_march *m, double size)
{
    struct precise_choice *c = &m->choice;
    int which = m->method == &precise_radau;
    double cost = m->method->cost(m->state, m), keep = c->size > 0 ? 0.7 : 0;
    m->work += cost;
    if (m->n == 0 || beside_turn(m))
        return;
    if (c->asked && which == SERIES && m->path->steps > c->rescued) {      /* those have done what they were for */
        use(m, IMPLICIT);
        m->method->begin(m->state, m, size);
    }
    if (!c->free)
        return;
    c->size = keep * c->size + (1 - keep) * size;
    c->work = keep * c->work + (1 - keep) * cost;
    if (c->on_trial) {
        end_trial(m);
    } else if (m->path->steps >= c->try_at && which == IMPLICIT) {
        c->try_at = m->path->steps + (back_to_series(m) ? c->wait : BACK_AFTER);
    } else if (m->path->steps >= c->try_at && fabs(precise_rest(m).hi) > MANY_LEFT * c->size) {
        double first = FIRST_SIZE * c->size;
        if (stiffness(m, c->size) < STIFF) {
            c->look *= 2;
            c->try_at = m->path->steps + (c->look > MOST_WAIT ? MOST_WAIT : c->look);
            return;
        }
        c->before = c->size / c->work;
        c->on_trial = true;
        c->trial_from = m->path->steps;
        use(m, IMPLICIT);
        m->method->begin(m->state, m, first);
    }
}

bool precise_begin_without_series(struct precise_march *m, double size)
{
    if (!m->choice.free || m->method != &precise_series)
        return false;
    use(m, IMPLICIT);
    return m->method->begin(m->state, m, size);
}

bool precise_rescue(struct precise_march *m)
{
    struct precise_choice *c = &m->choice;
    if (!(c->free || (c->asked && m->sides.count)) || m->method == &precise_series || c->rescued == m->path->steps + 1)
        return false;
    c->rescued = m->path->steps + 1;
    c->rescued_why = m->why;
    c->on_trial = false;
    c->try_at = m->path->steps + c->wait;
    use(m, SERIES);
    if (m->method->begin(m->state, m, fabs(precise_rest(m).hi)))
        return true;
    use(m, IMPLICIT);
    return false;
}
