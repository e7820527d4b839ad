/* Slides of motions that are differentiated: see vary_slides.h. */
#include "vary_slides.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "system.h"
#include "variation.h"
#include "vary_copies.h"
#include "vary_motion.h"

/* A mode of the general system, and what is made of it. */
struct reached {
    const struct traj_mode *general;
    struct variation variation;
    struct vary_copies copies;
    bool varied, copied;
    struct traj_mode mode;        /* of the copies */
    struct reached *next;
};

struct vary_slides {
    struct job *j;
    struct vary_model *model;
    struct slides *slides;        /* of the model's job */
    const struct variation_by *by; int directions;
    const struct traj_modes *general;
    struct traj_modes of;
    struct traj_mode start;
    const struct vary_at *at;
    struct reached *first, **last;
    struct sga_arena mem, own;    /* own: of one motion */
};

/* By surface its function in the copies: those of its events, where the motion does not slide along it. */
static const expr_id *surfaces_of(struct vary_slides *s, struct expr_store *st, const struct traj_request *rq, const int *sliding)
{
    expr_id *g = sga_zeros(&s->own, (size_t)s->general->surfaces + 1, sizeof *g);
    assert(rq->events == s->general->own + 2 * s->general->surfaces);       /* as struct traj_modes has them */
    for (int k = 0; k < s->general->surfaces; k++)
        g[k] = sliding[k] < 0 ? rq->event[s->general->own + 2 * k].expression : expr_int(st, 1);
    return g;
}

static bool make(struct vary_slides *s, struct reached *r, struct sga_error *err)
{
    const struct traj_mode *m = r->general;
    struct request *q = &s->model->request;
    size_t n = (size_t)m->sys->variables, all = n * (size_t)s->directions;
    expr_id *guess = sga_zeros(&s->own, all + 1, sizeof *guess);
    for (size_t k = 0; k < all; k++)
        guess[k] = expr_int(&q->store, 0);
    r->varied = true;
    if (!variation_make(&r->variation, m->sys, m->sol, m->rq, s->by, s->directions, guess, err))
        return false;
    memcpy(r->variation.initial, m->rq->initial, n * sizeof *m->rq->initial);
    memcpy(r->variation.given, m->rq->given, n);
    r->variation.request.single = s->start.rq->single;
    r->copied = true;
    if (!vary_copies_make(&r->copies, &r->variation, &(struct vary_copied){ q, m->sys, m->sol, m->rq, s->at->parameter }, err))
        return false;
    struct sweep_case *own = &r->copies.own;
    r->copies.c.request.programs = s->model->programs;
    own->request.modes = &s->of;
    r->mode.sys = &own->system;
    r->mode.sol = &own->solution;
    r->mode.rq = &own->request;
    r->mode.surface = surfaces_of(s, &own->store, &own->request, m->sliding);
    return true;
}

static const struct traj_mode *enter(void *ctx, const int *choice, const struct traj_mode *from, double t, const double *x, struct sga_error *err)
{
    struct vary_slides *s = ctx;
    (void)from;
    const struct traj_mode *m = s->general->enter(s->general->ctx, choice, s->general->start, t, x, err);
    struct reached *r = s->first;
    while (r && r->general != m)
        r = r->next;
    if (!m || r)
        return m ? &r->mode : NULL;
    r = sga_zeros(&s->own, 1, sizeof *r);
    *s->last = r;
    s->last = &r->next;
    r->general = m;
    r->mode = (struct traj_mode){ .choice = m->choice, .place = m->place, .sliding = m->sliding, .why = m->why };
    return !m->sol || make(s, r, err) ? &r->mode : NULL;
}

static const struct traj_mode *general_of(const struct vary_slides *s, const struct traj_mode *mode)
{
    const struct reached *r = s->first;
    while (r && &r->mode != mode)
        r = r->next;
    return r ? r->general : s->general->start;
}

static bool meets(void *ctx, const struct traj_mode *from, const struct traj_mode *to, int surface)
{
    const struct vary_slides *s = ctx;
    return s->general->meets(s->general->ctx, general_of(s, from), general_of(s, to), surface);
}

/* The reduction for general values of the parameters is that at these. */
static bool landed(void *ctx, const struct traj_mode *mode, double t, const double *x, struct sga_error *err)
{
    struct vary_slides *s = ctx;
    struct reached *r = s->first;
    while (r && &r->mode != mode)
        r = r->next;
    if (!r)
        return true;
    r->copies.own.request.start = t;
    return sweep_case_holds(&r->copies.own, x, NULL)
           || sga_fail(err, SGA_E_NOT_SUPPORTED, "at %.10g the motion comes to a surface from which it goes on by a reduction for general values of the parameters that does not hold at these, or is not "
                       "shown to: the values are special; leave parameters out", t);
}

bool vary_slides_new(struct job *j, struct vary_model *model, struct traj_request *rq, const struct variation_by *by, int directions, struct vary_slides **out)
{
    *out = NULL;
    if (!j->slides.begin)
        return true;
    struct vary_slides *s = *out = sga_calloc(1, sizeof *s);
    *s = (struct vary_slides){ .j = j, .model = model, .by = by, .directions = directions };
    s->last = &s->first;
    model->job.slides.in_balls = j->slides.in_balls;
    if (!j->slides.begin(&model->job, model->solution, rq, &s->mem, &s->slides))
        return false;
    s->general = rq->modes;
    if (s->general) {
        s->of = *s->general;
        s->of.start = &s->start;
        s->of.enter = enter;
        s->of.landed = landed;
        s->of.meets = meets;
        s->of.ctx = s;
    }
    return true;
}

void vary_slides_start(struct vary_slides *s, const struct vary_at *at, struct vary_copies *start)
{
    if (!s->general)
        return;
    assert(!s->first);        /* one motion, or two from one start: copies of modes are for its parameters */
    struct sweep_case *own = &start->own;
    s->at = at;
    s->start = *s->general->start;
    s->start.sys = &own->system;
    s->start.sol = &own->solution;
    s->start.rq = &own->request;
    s->start.surface = surfaces_of(s, &own->store, &own->request, s->general->start->sliding);
    own->request.modes = &s->of;
}

void vary_slides_again(struct vary_slides *s)
{
    if (!s)
        return;
    for (struct reached *r = s->first; r; r = r->next) {
        if (r->copied)
            vary_copies_clear(&r->copies);
        if (r->varied)
            variation_clear(&r->variation);
    }
    s->first = NULL;
    s->last = &s->first;
    sga_arena_end(&s->own);
}

void vary_slides_free(struct vary_slides *s)
{
    if (!s)
        return;
    vary_slides_again(s);
    s->j->slides.end(s->slides, false);
    sga_arena_end(&s->mem);
    free(s);
}
