/* See jump_piece.h. */
#include "jump_piece.h"

#include <math.h>

#include "jump_exact.h"
#include "mem.h"
#include "ode.h"
#include "system.h"

/* Of a motion that is differentiated: variables and derivatives. */
struct traj_mode jump_carried(const struct traj_mode *m)
{
    const struct traj_carried *c = m->rq->carried;
    return c ? (struct traj_mode){ .sys = c->sys, .sol = c->sol, .rq = c->rq } : *m;
}

void jump_piece_init(struct jump_piece *p, const struct traj_mode *mode, double tighter, double rows_until)
{
    const struct traj_mode of = jump_carried(mode);
    const struct sys_system *sys = of.sys;
    const struct traj_request *rq = of.rq;
    size_t n = (size_t)sys->variables, events = (size_t)rq->events;
    *p = (struct jump_piece){ .q = *rq, .columns = rq->outputs ? rq->outputs : sys->variables };
    p->output = sga_malloc((n + (size_t)rq->outputs + 1) * sizeof *p->output);
    for (int k = 0; k < rq->outputs; k++)
        p->output[k] = rq->output[k];
    for (size_t k = 0; k < n; k++)
        p->output[(size_t)rq->outputs + k] = sys->store->symbol[sys->variable[k].symbol].node;
    p->event = sga_calloc(events + 1, sizeof *p->event);
    p->side = sga_calloc(2 * events + 2, 1);
    p->all_side = p->side + events + 1;
    memset(p->all_side, ODE_SIDE_FRESH, events);
    p->stands = sga_calloc(events + 1, 1);
    p->whole = sga_calloc(events + 1, sizeof *p->whole);
    p->x = sga_calloc(n + 1, sizeof *p->x);
    p->n = p->before = sys->variables;
    p->exact = jump_is_exact(mode->rq) ? sga_calloc(n + 1, sizeof *p->exact) : NULL;
    p->given = sga_calloc(2 * n + 1, 1);
    p->held = p->given + n;
    memset(p->given, 1, n);
    p->q.output = p->output;
    p->q.outputs = (int)n + rq->outputs;
    p->q.event = p->event;
    p->q.event_side = p->side;
    p->q.ends_there = true;
    p->q.sized_by = rq->sized_by ? rq->sized_by : rq;
    p->q.integrals = 0;
    p->q.rows_until = rows_until;
    p->q.beside = NULL;
    p->q.carried = NULL;
    p->q.exact_start = EXPR_UNDEF;
    p->q.exact_initial = p->q.exact_time = NULL;
    p->q.modes = NULL;
    p->q.single |= mode->rq->single;
    p->q.arithmetic = p->exact ? TRAJ_DOUBLE_DOUBLE : mode->rq->arithmetic == TRAJ_BALL ? TRAJ_BALL : TRAJ_DOUBLE;
    p->q.rtol = fmax(tighter * rq->rtol, fmin(rq->rtol, p->exact ? 1e-30 : 1e-14));
    p->q.atol = tighter * rq->atol;
}

bool jump_piece_start(const struct jump_piece *p, const struct traj_mode *mode, struct traj_result *r, struct sga_error *err)
{
    const struct traj_mode of = jump_carried(mode);
    struct traj_request rq = p->q;
    expr_id start[] = { of.rq->exact_start };
    rq.samples = 1;
    rq.times = &of.rq->start;
    rq.exact_time = rq.exact_time || start[0] ? start : NULL;
    rq.events = 0;
    return traj_run(of.sys, of.sol, &rq, r, err);
}

/* In the next mode: what is known of the events stays. */
void jump_piece_turn(struct jump_piece *p, const struct traj_mode *to, double tighter)
{
    struct jump_piece old = *p;
    size_t events = (size_t)to->rq->events;
    jump_piece_init(p, to, tighter, old.q.rows_until);
    memcpy(p->all_side, old.all_side, events);
    memcpy(p->stands, old.stands, events);
    p->before = old.n;
    free(old.exact);
    free(old.output);
    free(old.event);
    free(old.side);
    free(old.whole);
    free(old.stands);
    free(old.x);
    free(old.given);
}

void jump_piece_clear(struct jump_piece *p)
{
    free(p->exact);
    free(p->output);
    free(p->event);
    free(p->side);
    free(p->whole);
    free(p->stands);
    free(p->x);
    free(p->given);
}

/* Events that have not acted as often as they may. */
void jump_piece_events(struct jump_piece *p, const struct traj_request *rq, const int *count)
{
    p->q.events = 0;
    for (int e = 0; e < rq->events; e++) {
        const struct traj_event *from = rq->event + e;
        if ((from->most && count[e] >= from->most) || (p->idle && p->idle[e]))
            continue;
        p->whole[p->q.events] = e;
        p->side[p->q.events] = p->all_side[e];
        p->event[p->q.events++] = (struct traj_event){ .expression = from->expression, .direction = from->direction, .stop = from->stop || from->sets || from->turns,
                                                           .from_zero = p->zero && p->zero[e], .from_flat = p->flat && p->flat[e] };
    }
}
