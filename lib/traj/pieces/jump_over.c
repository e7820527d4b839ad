/* See jump_over.h. */
#include "jump_over.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ball.h"
#include "crossing_fine.h"
#include "jump_exact.h"
#include "jump_fine.h"
#include "jump_over_events.h"
#include "jump_set.h"
#include "mem.h"
#include "system.h"

/* The place passed, as the answer says it. */
static void add_passed(struct traj_result *r, const struct traj_result *piece, double t)
{
    static const char *const beyond = "the motion goes on along the curve that it has come on, which is analytic there as far as the tolerances tell";
    const char *colon = strrchr(piece->ended_detail, ':');
    int length = colon ? (int)(colon - piece->ended_detail) : (int)strlen(piece->ended_detail);
    size_t room = (size_t)length + strlen(beyond) + 3;
    r->passed = sga_realloc(r->passed, ((size_t)r->passes + 1) * sizeof *r->passed);
    r->passed[r->passes] = (struct traj_passed){ t, sga_malloc(room) };
    snprintf(r->passed[r->passes++].detail, room, "%.*s: %s", length, piece->ended_detail, beyond);
}

/* Sample i of the request. */
static num_dd time_of(const struct sys_system *sys, const struct traj_request *rq, int i)
{
    enum { BITS = 160 };
    arb_t a;
    arb_init(a);
    num_ball_constant(sys->store, rq->exact_time ? rq->exact_time[i] : EXPR_UNDEF, rq->times[i], BITS, a);
    num_dd t = jump_fine_ball(a);
    arb_clear(a);
    return t;
}

/* The same in double-double. */
static bool over_exactly(struct jump_pass *p, struct jump_piece *q, const struct jump *j, const struct traj_request *rq, const struct traj_result *piece, const struct crossing *c, double *t)
{
    struct crossing_fine f;
    struct traj_result *r = &p->r;
    double direction = p->direction;
    size_t columns = (size_t)q->columns, n = (size_t)c->n;
    if (!crossing_fine_find(j->sys, j->sol, &q->q, c, &f))
        return false;
    num_dd *x = sga_malloc((n + 1) * sizeof *x), *y = sga_malloc(((size_t)q->q.outputs + n + 1) * sizeof *y);
    unsigned char *given = sga_calloc(n + 1, 1);
    p->over_fine += f.error;
    jump_cut(p, f.from, direction);
    jump_over_events(p, q, rq, c, &f);
    for (int i = r->rows; i < rq->samples && direction * (rq->times[i] - f.to) <= 0; i++, r->rows++) {
        crossing_fine_at(&f, time_of(j->sys, rq, i), x, y);
        r->t[i] = rq->times[i];
        for (size_t k = 0; k < columns; k++) {
            r->value[(size_t)i * columns + k] = y[k].hi;
            r->digits[(size_t)i * columns + k] = num_dd_text(y[k], NUM_DD_DIGITS);
            p->each[(size_t)i * columns + k] = jump_over_error(p, q, piece, y[k].hi, (int)k);
        }
    }
    crossing_fine_at(&f, num_dd_of(f.to), x, NULL);
    for (size_t k = 0; k < n; k++) {
        q->x[k] = x[k].hi;
        given[k] = 1;
    }
    jump_exact_place(q, j->sys->store, f.to, given, x);
    memset(q->all_side, ODE_SIDE_FRESH, (size_t)rq->events);
    memset(q->stands, 0, (size_t)rq->events);
    add_passed(r, piece, c->at);
    *t = f.to;
    free(x);
    free(y);
    free(given);
    crossing_fine_clear(&f);
    return true;
}

/* The piece ended at a singular position: the samples around it, and where the next piece begins (*t). False: it ends there. */
bool jump_over(struct jump_pass *p, struct jump_piece *q, const struct jump *j, const struct traj_request *rq, const struct traj_result *piece, double *t)
{
    struct crossing c;
    struct traj_result *r = &p->r;
    double direction = rq->times[rq->samples - 1] < rq->start ? -1 : 1;
    size_t columns = (size_t)q->columns;
    if (!piece->stratum || r->passes >= JUMP_MOST || !crossing_find(j->sys, j->sol, &q->q, piece->ended_t, &c))
        return false;
    if (q->exact) {
        bool over = over_exactly(p, q, j, rq, piece, &c, t);
        crossing_clear(&c);
        return over;
    }
    double *x = sga_malloc((size_t)(c.n + 1) * sizeof *x), *y = sga_malloc((size_t)(q->q.outputs + 1) * sizeof *y);
    p->over += c.error;
    jump_cut(p, c.from, direction);
    jump_over_events(p, q, rq, &c, NULL);
    while (r->rows && direction * (r->t[r->rows - 1] - c.from) > 0)
        r->rows--;
    for (int i = r->rows; i < rq->samples && direction * (rq->times[i] - c.to) <= 0; i++, r->rows++) {
        crossing_at(&c, rq->times[i], x, y);
        r->t[i] = rq->times[i];
        for (size_t k = 0; k < columns; k++) {
            r->value[(size_t)i * columns + k] = y[k];
            p->each[(size_t)i * columns + k] = jump_over_error(p, q, piece, y[k], (int)k);
        }
    }
    memcpy(q->x, c.end, (size_t)c.n * sizeof *q->x);
    memset(q->all_side, ODE_SIDE_FRESH, (size_t)rq->events);
    memset(q->stands, 0, (size_t)rq->events);
    add_passed(r, piece, c.at);
    *t = c.to;
    free(x);
    free(y);
    crossing_clear(&c);
    return true;
}
