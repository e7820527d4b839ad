/* From the start to the last sample, step by step. */
#include "enclose.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "budget.h"
#include "share.h"
#include "lohner.h"
#include "mem.h"
#include "zeros.h"

/* Steps shorter than this part of the whole way are not made: what needs them is a pole, or as good as one. */
static const double SHORTEST = 0x1p-60;

struct walk {
    const struct enclose_path *path;
    struct enc_step step;
    struct enc_set set;
    struct enc_zeros zeros;
    arb_t base, past, t, s;  /* t0, or the last knot; since then, exact; base + past; from here to a sample or a knot */
    arb_t searched;          /* the time up to which nothing that is watched is left unseen */
    int piece;               /* knots passed */
    double way;              /* from t0 to the last time, about, signed */
};

static void to_time(struct walk *w, const arb_t t)
{
    arb_sub(w->s, t, w->base, w->path->prec + 64);
    arb_sub(w->s, w->s, w->past, w->path->prec + 64);
}

static void to_sample(struct walk *w, int i)
{
    to_time(w, w->path->times + i);
    if (i >= w->path->early)
        return;
    if (w->way < 0)
        arb_neg(w->s, w->s);
    arb_nonnegative_part(w->s, w->s);
    if (w->way < 0)
        arb_neg(w->s, w->s);
}

/* To where this piece ends. */
static void to_end(struct walk *w)
{
    to_time(w, w->piece < w->path->knots ? w->path->knot + w->piece : w->path->times + w->path->samples - 1);
}

/* A double, >= |a|. */
static double above(const arb_t a)
{
    SGA_ENDS(mag_end) mag_t m = { 0 };
    arb_get_mag(m, a);
    return mag_get_d(m) * (1 + 0x1p-40);
}

/* The samples within the step, all: those of the piece. */
static void fill(struct walk *w, bool all, const struct sga_budget *budget, arb_ptr box, struct enclose_end *end)
{
    int n = w->set.n;
    for (; end->samples < w->path->samples; end->samples++) {
        to_sample(w, end->samples);
        bool within = !w->path->knots || w->path->before[end->samples] <= w->piece;
        if (!within || !(all || above(w->s) <= fabs(w->step.h)) || !sga_budget_ok(budget, NULL))
            break;
        enc_step_at(&w->step, &w->set, w->s, box + (size_t)end->samples * (size_t)n);
    }
}

static void say_failure(const struct walk *w, struct enclose_end *end)
{
    bool vanishes = w->step.failure == ENC_STEP_SHORT && w->step.bad >= 0;
    end->why = vanishes ? ENCLOSE_MAY_VANISH : w->step.failure == ENC_STEP_SHORT ? ENCLOSE_NOT_SHOWN : ENCLOSE_WIDE;
    end->which = vanishes ? w->step.bad : -1;
}

/* Whether the step comes to the piece's end, which it may then be taken to; w->s: how far that is. */
static bool reaches_end(struct walk *w)
{
    to_end(w);
    return above(w->s) <= fabs(w->step.h);
}

/* Of a step: where it may end so that signs of what is watched are shown there; in the order of preference. */
static const double ENDS[] = { 1, 0.9375, 0.875, 0.8125 };

/* Whether the i-th happening and the last one may be at one time. */
static bool may_be_at_once(const struct walk *w, int i, int last)
{
    const struct enclose_happening *h = w->path->happened->list + i;
    const struct enclose_watch *watch = w->zeros.q->watch + h->which;
    bool counts = w->zeros.left[h->which] && !(watch->direction && h->shown && h->direction != watch->direction);
    return i != last && (counts || i < last) && arb_overlaps(&h->t, &w->path->happened->list[last].t);
}

/* The motion stops at the last happening. */
static void stop(struct walk *w, int last, struct enclose_end *end)
{
    struct enclose_happened *out = w->path->happened;
    for (int i = 0; i < out->count; i++)
        end->at_once |= may_be_at_once(w, i, last);
    while (out->count > last + 1)
        enclose_happened_cut(out, out->count - 1);
    end->why = out->list[last].shown ? ENCLOSE_EVENT : ENCLOSE_UNDECIDED;
    end->which = out->list[last].which;
    end->t = arf_get_d(arb_midref(&out->list[last].t), ARF_RND_NEAR);
}

/* What happens on the way to s, if it is to be walked. False: the motion stops there. */
static bool look(struct walk *w, const arb_t s, struct enclose_end *end)
{
    const struct enclose_problem *q = w->zeros.q;
    struct enc_span span = { &w->step, &w->set, w->t, s, end->steps == 0 && !w->piece };
    if (!q->watches)
        return true;
    int last = enc_zeros_along(&w->zeros, &span);
    struct enclose_happened *out = w->path->happened;
    for (int i = out->count - 1; i >= 0 && out->list[i].piece < 0; i--)
        out->list[i].piece = w->piece;
    if (last < 0) {
        arb_add(w->searched, w->t, s, w->path->prec + 64);
        return true;
    }
    stop(w, last, end);
    return false;
}

/* h := the step's length, or less. */
static void end_of_step(struct walk *w, arb_t h)
{
    SGA_ENDS(arb_end) arb_t whole = { 0 };
    struct enc_span span = { &w->step, &w->set, w->t, h, false };
    arb_set(whole, h);
    for (size_t k = 0; k < sizeof ENDS / sizeof *ENDS && w->zeros.q->watches; k++) {
        arb_set_d(h, ENDS[k]);
        arb_mul(h, h, whole, ARF_PREC_EXACT);
        if (enc_zeros_told(&w->zeros, &span))
            return;
    }
    arb_set(h, whole);
}

/* The step, but not beyond the piece's end by what a ball does not tell. */
static void go_on(struct walk *w, struct enclose_end *end)
{
    SGA_ENDS(arb_end) arb_t h = { 0 };
    SGA_ENDS(mag_end) mag_t left = { 0 };
    arb_get_mag_lower(left, w->s);
    arb_set_d(h, w->step.h);
    if (!(fabs(w->step.h) < mag_get_d(left)))
        arb_mul_2exp_si(h, h, -1);
    end_of_step(w, h);
    if (!look(w, h, end))
        return;
    if (!enc_step_take(&w->step, &w->set, h))
        end->why = ENCLOSE_WIDE;
    arb_add(w->past, w->past, h, ARF_PREC_EXACT);
}

/* What jumps at the knot, base, does. */
static bool jump(struct walk *w)
{
    int n = w->set.n;
    SGA_ARENA(mem);
    arb_ptr box = arbs_take(&mem, n);
    enc_set_hull(&w->set, box);
    if (!w->path->jump(w->path->ctx, w->base, box))
        return false;
    enc_set_box(&w->set, box);
    return true;
}

/* To the knot, w->s away, and into the piece beyond. */
static void pass_knot(struct walk *w, struct enclose_end *end)
{
    if (!look(w, w->s, end))
        return;
    if (!enc_step_take(&w->step, &w->set, w->s)) {
        end->why = ENCLOSE_WIDE;
        return;
    }
    arb_set(w->base, w->path->knot + w->piece++);
    arb_zero(w->past);
    if (w->zeros.q->watches)
        enc_zeros_begin(&w->zeros, &w->set, w->base);
    w->path->enter(w->path->ctx, w->piece);
    end->t = arf_get_d(arb_midref(w->base), ARF_RND_NEAR);
    if (w->path->jump && !jump(w)) {
        end->why = ENCLOSE_JUMPS;
    } else if (w->zeros.q->watches) {
        int last = enc_zeros_beyond(&w->zeros, &w->set, w->base, w->piece, w->way < 0);
        if (last >= 0)
            stop(w, last, end);
    }
}

static bool stopped(const struct walk *w, const struct sga_budget *budget, struct enclose_end *end)
{
    if (!sga_budget_ok(budget, NULL) || (w->path->most_steps && end->steps >= w->path->most_steps))
        end->why = ENCLOSE_STOPPED;
    return end->why == ENCLOSE_STOPPED;
}

/* The next step, within the piece. False: there is none. */
static bool make_step(struct walk *w, const struct sga_budget *budget, struct enclose_end *end)
{
    const struct enclose_path *path = w->path;
    double least = SHORTEST * fabs(w->way);
    to_end(w);
    double most = fmax(above(w->s), 2 * least);
    if (enc_step_make(&w->step, &w->set, w->t, w->way < 0 ? -most : most, least, path->prec))
        return true;
    if (sga_budget_ok(budget, NULL))
        say_failure(w, end);
    else
        end->why = ENCLOSE_STOPPED;       /* what failed may have been stopped */
    return false;
}

static void march(struct walk *w, const struct sga_budget *budget, arb_ptr box, struct enclose_end *end)
{
    const struct enclose_path *path = w->path;
    for (;;) {
        arb_add(w->t, w->base, w->past, path->prec + 64);
        end->t = arf_get_d(arb_midref(w->t), ARF_RND_NEAR);
        to_sample(w, path->samples - 1);
        sga_share_tell(budget, fabs(w->way) > 0 ? 1 - above(w->s) / fabs(w->way) : 1, end->t);
        if (stopped(w, budget, end) || !make_step(w, budget, end))
            break;
        bool whole = reaches_end(w);
        fill(w, whole, budget, box, end);
        to_end(w);
        if (end->samples == path->samples) {
            if (look(w, w->s, end))
                end->t = arf_get_d(arb_midref(path->times + path->samples - 1), ARF_RND_NEAR);
            break;
        }
        if (stopped(w, budget, end))
            break;
        if (whole && w->piece < path->knots)
            pass_knot(w, end);
        else
            go_on(w, end);
        if (end->why != ENCLOSE_DONE)
            break;
        end->steps++;
    }
}

/* Samples at the start need no step. */
static void at_start(struct walk *w, arb_ptr box, struct enclose_end *end)
{
    int n = w->set.n;
    for (; end->samples < w->path->samples; end->samples++) {
        to_sample(w, end->samples);
        if (!arb_is_zero(w->s))
            break;
        _arb_vec_set(box + (size_t)end->samples * (size_t)n, w->path->start, n);
    }
}

/* Where it ended before its time: no samples that may lie beyond what stopped it, or beyond what has been searched. */
static void rows_before(const struct walk *w, struct enclose_end *end)
{
    if (!w->zeros.q->watches || end->why == ENCLOSE_DONE)
        return;
    bool stopped = end->why == ENCLOSE_EVENT || end->why == ENCLOSE_UNDECIDED;
    const arb_struct *t = stopped ? &w->path->happened->list[w->path->happened->count - 1].t : w->searched;
    while (end->samples > 0 && (stopped ? !(w->way < 0 ? arb_gt(w->path->times + end->samples - 1, t) : arb_lt(w->path->times + end->samples - 1, t))
                                        : w->way < 0 ? arb_lt(w->path->times + end->samples - 1, t) : arb_gt(w->path->times + end->samples - 1, t)))
        end->samples--;
}

void enclose_happened_cut(struct enclose_happened *h, int i)
{
    assert(i >= 0 && i < h->count);
    arb_clear(&h->list[i].t);
    _arb_vec_clear(h->list[i].x, h->n);
    memmove(h->list + i, h->list + i + 1, (size_t)(h->count - i - 1) * sizeof *h->list);
    h->count--;
}

void enclose_happened_clear(struct enclose_happened *h)
{
    while (h->count)
        enclose_happened_cut(h, h->count - 1);
    free(h->list);
    h->list = NULL;
}

bool enclose_run(const struct enclose_problem *q, const struct enclose_path *path, arb_ptr box,
                 struct enclose_end *end, struct sga_error *err)
{
    assert(q->n > 0 && q->nonzeros >= 0);
    int n = q->n, roots = n + q->nonzeros;
    SGA_ENDS(enc_program_clear) struct enc_program p;
    SGA_FREED expr_id *root = sga_malloc((size_t)(roots + 1) * sizeof *root);
    memcpy(root, q->field, (size_t)n * sizeof *root);
    if (q->nonzeros)
        memcpy(root + n, q->nonzero, (size_t)q->nonzeros * sizeof *root);
    *end = (struct enclose_end){ .which = -1 };
    bool ok = enc_program_init(&p, &(struct enc_of){ q->st, q->variable, n, q->time, q->tables }, root, roots, err);
    if (ok) {
        struct walk w = { .path = path };
        enc_step_init(&w.step, &p, n);
        enc_set_init(&w.set, n);
        enc_set_box(&w.set, path->start);
        arb_init(w.base);
        arb_init(w.searched);
        arb_set(w.searched, path->t0);
        arb_init(w.past);
        arb_init(w.t);
        arb_init(w.s);
        arb_set(w.base, path->t0);
        to_time(&w, path->times + path->samples - 1);
        w.way = path->early < path->samples ? arf_get_d(arb_midref(w.s), ARF_RND_NEAR) : path->backward ? -above(w.s) : above(w.s);
        at_start(&w, box, end);
        end->t = arf_get_d(arb_midref(path->t0), ARF_RND_NEAR);
        w.zeros.strict = path->strict;
        ok = !q->watches || enc_zeros_init(&w.zeros, q, path->happened, path->prec, err);
        w.zeros.q = q;
        if (ok && q->watches)
            enc_zeros_begin(&w.zeros, &w.set, path->t0);
        if (ok && end->samples < path->samples)
            march(&w, q->budget, box, end);
        if (ok)
            rows_before(&w, end);
        end->evaluations = w.step.runs;
        arb_clear(w.base);
        arb_clear(w.searched);
        arb_clear(w.past);
        arb_clear(w.t);
        arb_clear(w.s);
        enc_zeros_clear(&w.zeros);
        enc_set_clear(&w.set);
        enc_step_clear(&w.step);
    }
    return ok;
}
