/* Why and where a solution ended.
 *
 * A march that cannot go on shrinks its steps until they are at the rounding of t: that
 * is the bisection of the time of the ending. What remains is to say which kind it is. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>

#include "kink.h"
#include "march.h"

/* |x'| T above this many times |x|, T the time passed, when steps have shrunk to
 * nothing: x changes on a scale of its own that goes to 0. */
#define GROWTH 1e3
/* A state this much larger than the start's has blown up, whatever stopped it. */
#define HUGE_STATE 1e50
/* Of the way made: a sample this near to an ending is not asked for. */
#define AT_ENDING 1e-7
/* Beyond this nobody can tell what is unbounded from what is large. */
#define END_OF_RANGE 1e290

static const char *const texts[] = {
#define X(sym, text, what) text,
    ODE_REASON_TABLE(X)
#undef X
};
static const char *const whats[] = {
#define X(sym, text, what) what,
    ODE_REASON_TABLE(X)
#undef X
};

const char *ode_reason_text(enum ode_reason r) { return texts[r]; }

const char ode_slides[] = "the field jumps where the argument of a sign changes its sign, and points there from both sides: "
                          "the motion would have to slide along that surface, which the equations do not determine";
const char ode_no_sides[] = "a switch jumps here and turns others, which turn it, or each other, back: on no sides do all arguments "
                            "have the signs that their switches are taken with";
const char ode_by_errors[] = "errors end it: solutions of other tolerances end at quite other times, so that nothing tells how far the motion goes; ask for smaller "
                             "tolerances, of atol below the smallest values that matter";
const char *ode_reason_what(enum ode_reason r) { return whats[r]; }

double ode_end_error(double apart, double rtol, double way)
{
    static const double ALLOWANCE = 10, LEAST = 0.1;
    return ALLOWANCE * apart + LEAST * rtol * fabs(way);
}

bool ode_reason_placed(enum ode_reason r)
{
    return r != ODE_NONE && r != ODE_TOLERANCE && r != ODE_STEP_LIMIT && r != ODE_TIME_LIMIT && r != ODE_CANCELLED;
}

void ode_end_by_errors(struct ode_end *end)
{
    end->reason = ODE_TOLERANCE;
    end->variable = -1;
    snprintf(end->detail, sizeof end->detail, "%s", ode_by_errors);
}

double ode_largest(const struct ode_march *m, const double *v, int *which)
{
    double most = 0;
    *which = -1;
    for (int j = 0; j < m->p->n; j++)
        if (fabs(v[j]) / m->unit[j] > most) {
            most = fabs(v[j]) / m->unit[j];
            *which = j;
        }
    return most;
}

void ode_end_at(struct ode_march *m, enum ode_reason reason, const char *detail)
{
    struct ode_end *end = &m->res->end;
    assert(reason > ODE_NONE && reason < ODE_REASON_COUNT);      /* else it would pass for the last time */
    end->reason = reason;
    end->t = m->t;
    end->variable = -1;
    snprintf(end->detail, sizeof end->detail, "%s", detail);
}

/* Near a singularity steps are proportional to the distance from it, so accepted times
 * tend to it geometrically: their limit by Aitken's rule. */
static double limit_time(const struct ode_march *m)
{
    double a = m->last_times[1] - m->last_times[0], b = m->t - m->last_times[1];
    double ratio = b / a;
    if (!(ratio > 0 && ratio < 0.95))
        return m->t;
    return m->t + b * ratio / (1 - ratio);
}

/* And not only its derivative. From 0 every size is far. */
static bool state_grows(const struct ode_march *m)
{
    int which;
    double size = ode_largest(m, m->x, &which);
    return size > 1e3 * (m->start_size + 1) || (m->start_size > 0 && size > 1e6 * m->start_size);
}

/* How long what grows most may go on growing as it does: by its rate there, and by the last step, as on a slow manifold that it comes to the rate of a point
 * with its errors is another. */
static double left_to_grow(const struct ode_march *m)
{
    int by_rate;
    double rate = ode_largest(m, m->f, &by_rate), step = m->t - m->last_times[1];
    if (!(rate > 0))
        return 0;
    double x = m->x[by_rate], grown = step != 0 ? x - m->last[by_rate] : 0;
    return fmax(ode_left_to_grow(x, m->f[by_rate]), x * grown > 0 ? ode_left_to_grow(x, grown / step) : 0);
}

static void blow_up(struct ode_march *m)
{
    int by_state, by_rate;
    double size = ode_largest(m, m->x, &by_state), rate = ode_largest(m, m->f, &by_rate);
    char text[200];
    bool grown = state_grows(m);
    if (size > END_OF_RANGE)
        snprintf(text, sizeof text, "the solution grows beyond the range of numbers (size %.3g at the end)", size);
    else if (grown)
        snprintf(text, sizeof text, "the solution grows without bound (size %.3g at the end)", size);
    else
        snprintf(text, sizeof text,
                 "the derivative grows without bound (size %.3g) while the solution stays at size %.3g",
                 rate, size);
    ode_end_at(m, ODE_BLOW_UP, text);
    m->res->end.variable = grown ? by_state : by_rate;
    m->res->end.t = limit_time(m);
    m->res->end.left = left_to_grow(m);
}

static bool grows_now(const struct ode_march *m)
{
    int which;
    double size = ode_largest(m, m->x, &which), rate = ode_largest(m, m->f, &which);
    size = fmax(fmax(size, m->start_size), 1e-300);   /* x may tend to 0, */
    double way = rate * fabs(m->t - m->start->t);
    return way > GROWTH * size && way > m->o->atol;     /* and rest there */
}

bool ode_grows(const struct ode_march *m)
{
    int which;
    return grows_now(m) && ode_largest(m, m->f, &which) > GROWTH * m->start_rate;
}

/* The motion comes from a surface beyond which the constraints are others and has made no step there: what its field is at a point off these tells nothing. */
static bool thrown_off(const struct ode_march *m, enum ode_refusal cause)
{
    return cause == MANIFOLD_REFUSED && m->manifold_why == ODE_CONSTRAINT_LOST && m->kinks && m->kinks->turned_t == m->t;
}

/* The same where it is a variable that has grown by far, on a scale of its own that goes to 0; else 0. */
static double left_of_grown(const struct ode_march *m)
{
    int which;
    double size = ode_largest(m, m->x, &which), left = left_to_grow(m);
    bool own = which >= 0 && fabs(m->f[which]) / m->unit[which] * fabs(m->t - m->start->t) > GROWTH * size;
    return own && state_grows(m) ? left : 0;
}

void ode_end_refused(struct ode_march *m, enum ode_refusal cause)
{
    int which;
    bool grows = grows_now(m) && !thrown_off(m, cause);
    bool huge = ode_largest(m, m->x, &which) > HUGE_STATE * (m->start_size + 1);
    /* Near the edge of the domain some steps are refused for their error. */
    if (cause == ERROR_TOO_LARGE && !grows && m->field_refused &&
        fabs(m->t - m->field_refused_t) <= 1e-8 * fmax(fabs(m->t), fabs(m->t - m->start->t)))
        cause = FIELD_REFUSED;
    enum ode_reason why = cause == FIELD_REFUSED ? m->field.why : m->manifold_why;
    if (huge || (grows && (cause != FIELD_REFUSED || why == ODE_LEFT_DOMAIN)))
        blow_up(m);
    else if (cause == ERROR_TOO_LARGE)
        ode_end_at(m, ODE_NOT_SMOOTH,
                   "no step is small enough for the tolerance here: the field is not smooth, "
                   "or the tolerance is too tight");
    else if (why == ODE_LEFT_DOMAIN)
        ode_end_at(m, why, "the vector field has no finite value beyond this time");
    else if (why == ODE_CONSTRAINT_LOST && cause == MANIFOLD_REFUSED && ode_settle_trembles(m))
        ode_end_at(m, why, "roundings of double in the constraints move points by more than the tolerances allow here, however short the steps: ask for the arithmetic "
                   "\"double-double\", or for larger tolerances");
    else if (why == ODE_CONSTRAINT_LOST)
        ode_end_at(m, why, "no point near the solution satisfies the constraints beyond this time");
    else
        ode_end_at(m, why, "a rank drops here: the field or the constraints are singular");
    if (why == ODE_SINGULAR && m->res->end.reason == why)
        m->res->end.left = left_of_grown(m);
}

bool ode_is_over(struct ode_march *m)
{
    double t, near = fmax(AT_ENDING, 0.1 * m->o->rtol) * fabs(m->t - m->start->t);
    if (!m->p->over || !m->p->over(m->p->ctx, &t) || (t - m->start->times[m->next]) * m->direction > near || (t - m->t) * m->direction < 0)
        return false;
    ode_end_at(m, ODE_SINGULAR, "a rank drops here: the field or the constraints are singular");
    m->res->end.t = t;
    return true;
}

/* Samples past the time of the ending are taken back. */
static void end_earlier(struct ode_march *m, double t)
{
    m->res->end.t = t;
    while (m->next > 0 && (m->start->times[m->next - 1] - t) * m->direction > 0)
        m->next--;
    while (m->res->happened > 0 && (m->res->happening[m->res->happened - 1].t - t) * m->direction > 0)
        m->res->happened--;
}

/* Steps can become and stay tiny for other causes than stability: where the tolerance is
 * too coarse to see a singularity, the solution trembles at it; where the field leaves
 * the manifold, each step is as long as the correction may be. */
void ode_end_steps(struct ode_march *m, bool foreseen)
{
    if (m->manifold_refused > m->res->stats.steps / 10) {
        ode_end_at(m, ODE_CONSTRAINT_LOST,
                   "the vector field leads away from the constraints: corrections are far larger than "
                   "the error of the steps");
        return;
    }
    if (m->hopeless > 0 && ode_grows(m)) {
        blow_up(m);
        m->res->end.left += fabs(m->t - m->slow_since);
        end_earlier(m, m->slow_since);
        return;
    }
    const struct ode_stats *s = &m->res->stats;
    bool stiff = s->stiff_steps > s->steps / 4;
    char text[256];
    snprintf(text, sizeof text, "%s after %ld steps%s; %s",
             foreseen ? "the last time is out of reach" : "the limit of steps was reached",
             s->steps + s->refused,
             stiff ? ", their size being set by stability: the system is stiff" : "",
             stiff ? "ask for an earlier stop, or for the implicit method \"radau\""
                   : "ask for an earlier stop, a larger tolerance or more steps");
    ode_end_at(m, ODE_STEP_LIMIT, text);
}
