/* See jump_joined.h. */
#include "jump_joined.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "arena.h"
#include "jump_boxed.h"
#include "jump_fine.h"
#include "mem.h"
#include "slide.h"
#include "system.h"
#include "tolerance.h"

/* Intervals of no time before they are said to have no end. */
enum { AT_ONCE = 3 };
/* Times have a limit where it is so near, by the whole way, and intervals shrink by the same factor, but for this part of what it is below 1. */
static const double LIMIT_NEAR = 1e-6, ALIKE = 0.02;
/* One that ended rows of shrinking intervals without time after it: what was between was smaller than errors. */
static const double UNSEEN = 1e-3;
/* The same, for an event whose function stood still after it and that happens again at once: by roundings that fall. */
static const double STANDS = 1e-4;

double jump_at_once(const struct jump_pass *p, const struct traj_request *rq, double t)
{
    return p->fine ? 0 : JUMP_SAME_TIME * fmax(fabs(t), fabs(t - rq->start));
}

void jump_pass_clear(struct jump_pass *p)
{
    traj_result_clear(&p->r);
    jump_fine_free(p->fine);
    jump_boxed_free(p->boxed);
    free(p->each);
    free(p->at);
    free(p->count);
    free(p->idle);
    *p = (struct jump_pass){ 0 };
}

double jump_over_error(const struct jump_pass *p, const struct jump_piece *q, const struct traj_result *piece, double value, int column)
{
    if (!(p->over > 0 || p->over_fine > 0))
        return 0;
    return p->over * sga_allowed((struct sga_tolerance){ q->q.rtol, q->q.atol }, piece->unit ? piece->unit[column] : 1, value) + p->over_fine * fmax(1, fabs(value));
}

/* For so many happenings. */
static void make_room(struct jump_pass *p, size_t happened)
{
    struct traj_result *r = &p->r;
    size_t wide = (size_t)r->columns + 1;
    if (happened + 1 <= p->happening_room)
        return;
    p->happening_room = 2 * happened + 1;
    r->happening = sga_realloc(r->happening, p->happening_room * sizeof *r->happening);
    r->happened_value = sga_realloc(r->happened_value, p->happening_room * wide * sizeof *r->happened_value);
    if (r->digits)
        r->happened_digits = sga_realloc(r->happened_digits, p->happening_room * wide * sizeof *r->happened_digits);
}

/* Rows and happenings of a piece are added. */
void jump_join(struct jump_pass *p, const struct jump_piece *q, struct traj_result *piece)
{
    struct traj_result *r = &p->r;
    size_t columns = (size_t)q->columns, wide = (size_t)piece->columns, happened = (size_t)(r->happened + piece->happened);
    for (int i = 0; i < piece->rows; i++, r->rows++) {
        double *value = r->value + (size_t)r->rows * columns, *each = p->each + (size_t)r->rows * columns;
        r->t[r->rows] = piece->t[i];
        memcpy(value, piece->value + (size_t)i * wide, columns * sizeof *value);
        for (size_t k = 0; k < columns && r->digits && piece->digits; k++) {
            r->digits[(size_t)r->rows * columns + k] = piece->digits[(size_t)i * wide + k];
            piece->digits[(size_t)i * wide + k] = NULL;
        }
        if (r->radius && piece->radius)
            memcpy(r->radius + (size_t)r->rows * columns, piece->radius + (size_t)i * wide, columns * sizeof *r->radius);
        for (size_t k = 0; k < columns; k++)
            each[k] = (piece->error ? fmin(piece->error[i], piece->column_error ? piece->column_error[k] : INFINITY) : INFINITY) + jump_over_error(p, q, piece, value[k], (int)k);
    }
    make_room(p, happened);
    for (int i = 0; i < piece->happened; i++, r->happened++) {
        r->happening[r->happened] = piece->happening[i];
        r->happening[r->happened].event = q->whole[piece->happening[i].event];
        memcpy(r->happened_value + (size_t)r->happened * columns, piece->happened_value + (size_t)i * wide, columns * sizeof(double));
        for (size_t k = 0; k <= columns && r->happened_digits; k++) {
            const char *digits = piece->happened_digits ? piece->happened_digits[(size_t)i * (wide + 1) + k] : NULL;
            r->happened_digits[(size_t)r->happened * (columns + 1) + k] = digits ? strcpy(sga_malloc(strlen(digits) + 1), digits) : NULL;
        }
    }
    r->residual = fmax(r->residual, piece->residual);
    r->steps += piece->steps;
    r->rejected += piece->rejected;
    r->evaluations += piece->evaluations;
    r->seconds += piece->seconds;
    r->method = piece->method;
    r->arithmetic = piece->arithmetic;
    r->gauge = piece->gauge;
    r->gauge_numeric = piece->gauge_numeric;
    r->inputs_examined = piece->inputs_examined;
    if (piece->shortfall)
        r->shortfall = piece->shortfall;
}

void jump_tell(struct jump_pass *p, struct traj_happening what, const double *value)
{
    struct traj_result *r = &p->r;
    size_t columns = (size_t)r->columns, at = (size_t)r->happened;
    make_room(p, at + 1);
    r->happening[at] = what;
    memcpy(r->happened_value + at * columns, value, columns * sizeof *value);
    for (size_t k = 0; k <= columns && r->happened_digits; k++)
        r->happened_digits[at * (columns + 1) + k] = NULL;
    r->happened++;
}

void jump_tell_digits(struct jump_pass *p, struct traj_happening what, num_dd t, const num_dd *value)
{
    size_t columns = (size_t)p->r.columns;
    SGA_FREED double *y = sga_malloc((columns + 1) * sizeof *y);
    for (size_t k = 0; k < columns; k++)
        y[k] = value[k].hi;
    jump_tell(p, what, y);
    char **digits = p->r.happened_digits ? p->r.happened_digits + (size_t)(p->r.happened - 1) * (columns + 1) : NULL;
    for (size_t k = 0; k <= columns && digits; k++)
        digits[k] = num_dd_text(k ? value[k - 1] : t, NUM_DD_DIGITS);
}

void jump_tell_again(struct jump_pass *p, int e, int direction)
{
    struct traj_result *r = &p->r;
    size_t columns = (size_t)r->columns, last = (size_t)r->happened - 1;
    assert(r->happened > 0);
    make_room(p, last + 2);
    r->happening[last + 1] = r->happening[last];
    r->happening[last + 1].event = e;
    r->happening[last + 1].direction = direction;
    memcpy(r->happened_value + (last + 1) * columns, r->happened_value + last * columns, columns * sizeof *r->happened_value);
    for (size_t k = 0; k <= columns && r->happened_digits; k++) {
        const char *digits = r->happened_digits[last * (columns + 1) + k];
        r->happened_digits[(last + 1) * (columns + 1) + k] = digits ? sga_strdup(digits) : NULL;
    }
    r->happened++;
}

/* Nothing is said beyond t. */
void jump_cut(struct jump_pass *p, double t, double direction)
{
    size_t columns = (size_t)p->r.columns;
    while (p->r.happened && direction * (p->r.happening[p->r.happened - 1].t - t) > 0) {
        p->r.happened--;
        for (size_t k = 0; k <= columns && p->r.happened_digits; k++)
            free(p->r.happened_digits[(size_t)p->r.happened * (columns + 1) + k]);
    }
    while (p->r.rows && direction * (p->r.t[p->r.rows - 1] - t) > 0) {
        p->r.rows--;
        for (size_t k = 0; k < columns && p->r.digits; k++)
            free(p->r.digits[(size_t)p->r.rows * columns + k]);
    }
    while (p->r.legs && direction * (p->r.leg[p->r.legs - 1].t - t) > 0)
        free(p->r.leg[--p->r.legs].impulse);
    while (p->r.slides && direction * (p->r.slide[p->r.slides - 1].from - t) > 0)
        p->r.slides--;
    for (int i = 0; i < p->r.slides; i++)
        if (direction * (p->r.slide[i].to - t) > 0)
            p->r.slide[i].to = NAN;
    while (p->r.passes && direction * (p->r.passed[p->r.passes - 1].t - t) > 0)
        free(p->r.passed[--p->r.passes].detail);
}

/* The times have a limit at t, known to an error; nothing is said beyond. */
static bool end_at_limit(struct jump_pass *p, double t, double error, const char *how)
{
    assert(p->jumps > 0 && fabs(p->direction) == 1);
    jump_cut(p, t, p->direction);
    p->r.ended = true;
    p->r.ended_t = t;
    p->r.ended_reason = "accumulation";
    p->end_error = error;
    snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "%s: the motion beyond is not determined by them", how);
    return true;
}

/* Whether times of events have a limit: the last intervals shrink by one factor, and what is left of them is short; or there is no time between
 * them; or they are too short for their roundings to shrink any more. */
bool jump_accumulates(struct jump_pass *p, const struct traj_request *rq)
{
    static const char *const at_once = "events that set variables follow each other without time between";
    const double *t = p->at + p->jumps;
    double way = fabs(rq->times[rq->samples - 1] - rq->start);
    if (p->jumps > 1 && p->stood && fabs(t[-1] - t[-2]) <= STANDS * way)
        return end_at_limit(p, t[-2], JUMP_SAME_TIME * fabs(t[-2]), at_once);
    if (p->jumps > AT_ONCE && fabs(t[-1] - t[-1 - AT_ONCE]) <= JUMP_SAME_TIME * fabs(t[-1]))
        return end_at_limit(p, t[-1 - AT_ONCE], JUMP_SAME_TIME * fabs(t[-1]), at_once);
    if (p->jumps < 5)
        return false;
    double d0 = t[-4] - t[-5], d1 = t[-3] - t[-4], d2 = t[-2] - t[-3], d3 = t[-1] - t[-2], q0 = d1 / d0, q1 = d2 / d1, q2 = d3 / d2;
    double most = 1 - fmax(q1, q2), left = d3 * q2 / (1 - q2), before = d2 * q1 / (1 - q1) - d3;
    bool alike = most > 0 && q0 > 0 && q1 > 0 && q2 > 0 && q0 < 1 && fabs(q2 - q1) <= ALIKE * most && fabs(q1 - q0) <= 2 * ALIKE * most;
    if (alike && fabs(left) <= LIMIT_NEAR * way) {
        char how[120];
        snprintf(how, sizeof how, "the times of events that set variables have a limit here, intervals shrinking by %.6g each", q2);
        /* roundings of times are in the factor, and what is left of it beyond one more step of it */
        return end_at_limit(p, t[-1] + left, 2 * fabs(left - before) + 8 * DBL_EPSILON * fabs(t[-1]) * (1 + fabs(left / d3)) / (1 - q2), how);
    }
    /* between the last two the motion was too small to be seen, and so it would go through: the one before was the last of a row */
    if (fabs(d3) <= JUMP_SAME_TIME * fabs(t[-1]) && q0 > 0 && q1 > 0 && q0 < 1 && q1 < 1 && fabs(d2) <= UNSEEN * way) {
        double rest = d2 * q1 / (1 - q1);
        return end_at_limit(p, t[-2] + rest, 2 * fabs(rest) + JUMP_SAME_TIME * fabs(t[-2]), "the times of events that set variables have a limit here, the last intervals too short to be told");
    }
    bool shrink = fabs(d3) < fabs(d2) && fabs(d2) < fabs(d1);
    if (!shrink && fabs(t[-1] - t[-4]) <= LIMIT_NEAR * way)
        return end_at_limit(p, t[-4], INFINITY, "events that set variables follow each other so fast that roundings decide when");
    return false;
}

/* A piece begins. */
void jump_add_leg(struct jump_pass *p, double t, int mode, const char *how, double moved, double *impulse, int coordinates)
{
    SGA_RESERVE(p->r.leg, p->leg_room, p->r.legs + 1);
    p->r.leg[p->r.legs++] = (struct traj_leg){ .t = t, .mode = mode, .how = how, .moved = moved, .impulse = impulse, .coordinates = coordinates };
}

/* Values of switches of slides from a list of all variables. One that jumped past its ends, with a table, has left its slide. */
static void widen(struct traj_result *r, int surface, double value)
{
    static const double JUST = 1e-6;
    if (fabs(value) > 1 + JUST)
        return;
    for (int i = r->slides - 1; i >= 0; i--)
        if (r->slide[i].surface == surface && isnan(r->slide[i].to)) {
            r->slide[i].least = fmin(r->slide[i].least, value);
            r->slide[i].most = fmax(r->slide[i].most, value);
        }
}

/* Of the samples of a piece, and of its end. */
void jump_note_switches(struct jump_pass *p, const struct jump_piece *q, const struct traj_mode *m, const struct traj_result *piece)
{
    for (int k = 0; slide_any(m->rq) && k < m->rq->modes->surfaces; k++) {
        if (m->sliding[k] < 0)
            continue;
        size_t wide = (size_t)piece->columns, at = (size_t)q->q.outputs - (size_t)jump_carried(m).sys->variables + (size_t)m->sliding[k];
        for (int i = 0; i < piece->rows; i++)
            widen(&p->r, k, piece->value[(size_t)i * wide + at]);
        if (piece->happened)
            widen(&p->r, k, piece->happened_value[(size_t)(piece->happened - 1) * wide + at]);
    }
}

/* Slides that end at t, and those that begin there, at x of the mode `to`. */
void jump_note_slides(struct jump_pass *p, const struct traj_mode *was, const struct traj_mode *to, double t, const double *x)
{
    struct traj_result *r = &p->r;
    for (int k = 0; slide_any(to->rq) && k < to->rq->modes->surfaces; k++) {
        bool before = was->choice[k] == TRAJ_ALONG, now = to->choice[k] == TRAJ_ALONG;
        for (int i = r->slides - 1; before && !now && i >= 0; i--)
            if (r->slide[i].surface == k && isnan(r->slide[i].to)) {
                r->slide[i].to = t;
                r->slide[i].left = to->choice[k] == TRAJ_ABOVE ? 1 : -1;
            }
        if (!before && now) {
            SGA_RESERVE(r->slide, p->slide_room, r->slides + 1);
            r->slide[r->slides++] = (struct traj_slide){ .surface = k, .mode = to->place, .from = t, .to = NAN, .least = x[to->sliding[k]], .most = x[to->sliding[k]] };
        } else if (now) {
            widen(r, k, x[to->sliding[k]]);
        }
    }
}

void jump_drop_turns(struct traj_result *r, const struct traj_request *rq)
{
    int kept = 0;
    for (int i = 0; i < r->happened; i++) {
        size_t wide = (size_t)r->columns + 1;
        for (size_t k = 0; k < wide && r->happened_digits && rq->event[r->happening[i].event].turns; k++)
            free(r->happened_digits[(size_t)i * wide + k]);
        if (rq->event[r->happening[i].event].turns)
            continue;
        if (r->happened_digits)
            memmove(r->happened_digits + (size_t)kept * wide, r->happened_digits + (size_t)i * wide, wide * sizeof *r->happened_digits);
        r->happening[kept] = r->happening[i];
        memmove(r->happened_value + (size_t)kept * (size_t)r->columns, r->happened_value + (size_t)i * (size_t)r->columns, (size_t)r->columns * sizeof(double));
        kept++;
    }
    r->happened = kept;
}
