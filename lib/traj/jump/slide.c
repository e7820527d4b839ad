/* Ways on from surfaces where equations jump: all that there may be, tried one by one. */
#include "slide_trial.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "derive.h"
#include "error.h"
#include "field.h"
#include "mem.h"
#include "ode.h"
#include "reduction.h"
#include "signals.h"
#include "system.h"
#include "tape.h"
#include "told.h"

/* Derivatives that are looked at: at once, and where those are 0; surfaces that are decided at once. */
enum { FIRST = 2, LAST = 5, MOST_TRIED = 3 };
/* Of a value: what of it is not told from 0; of a differentiated variable, by the size of all: what it may move onto a slide; of rates: what is no convex combination. */
static const double UNTOLD = 1e-9, STAYS = 1e-6, CONVEX = 1e-6, NEAR_END = 1e-6, GRAIN = 64 * DBL_EPSILON / 1e-9, LEAP = 1e4;   /* GRAIN: of UNTOLD, roundings; LEAP: of that, more than a start moves a surface's function by, */
static const double PART = 1e-6;      /* and of what the function changes by over the motion */

struct slide {
    struct ways *first;
};

bool slide_any(const struct traj_request *rq)
{
    return rq->modes && rq->modes->surfaces > 0;
}

struct slide *slide_new(void)
{
    return sga_calloc(1, sizeof(struct slide));
}

void slide_free(struct slide *s)
{
    for (struct ways *w = s ? s->first : NULL, *next; w; w = next) {
        next = w->next;
        num_tape_free(w->tape[0]);
        num_tape_free(w->tape[1]);
        free(w->root[0]);
        free(w->root[1]);
        if (w->ready)
            jump_clear(&w->jump);
        free(w);
    }
    free(s);
}

struct ways *slide_ways(struct slide *s, const struct traj_mode *m)
{
    struct ways *w = s->first;
    while (w && w->mode != m)
        w = w->next;
    if (!w) {
        w = sga_calloc(1, sizeof *w);
        *w = (struct ways){ .mode = m, .next = s->first };
        s->first = w;
    }
    return w;
}

static int order_of(int level) { return level ? LAST : FIRST; }

static struct num_tape *tape_of(struct ways *w, int level, struct sga_error *err)
{
    const struct traj_mode *m = w->mode;
    struct expr_store *st = m->sys->store;
    int surfaces = m->rq->modes->surfaces, order = order_of(level);
    if (w->tape[level])
        return w->tape[level];
    expr_id *root = w->root[level] = sga_calloc((size_t)surfaces * (size_t)(order + 1) + 1, sizeof *root);
    struct expr_flow flow;
    expr_flow_init(&flow, st);
    for (int k = 0; k < m->sys->variables; k++)
        expr_flow_determine(&flow, m->sys->variable[k].symbol, m->sol->field[k]);
    for (int k = 0; k < surfaces; k++)
        for (int i = 0; i <= order; i++)
            root[k * (order + 1) + i] = expr_flow_coefficient(&flow, m->sliding[k] < 0 ? m->surface[k] : st->symbol[m->sys->variable[m->sliding[k]].symbol].node, i);
    expr_flow_clear(&flow);
    if (!expr_store_ok(st)) {
        *err = *st->error;
        return NULL;
    }
    SGA_FREED int *inputs = field_inputs(m->sys);
    return w->tape[level] = num_tape_new(st, root, surfaces * (order + 1), inputs, m->sys->variables + 1, err);
}

bool slide_tell(struct ways *w, int level, double t, const double *x, const double *speed, struct told *out, struct sga_error *err)
{
    const struct traj_request *rq = w->mode->rq;
    struct num_tape *tape = tape_of(w, level, err);
    int n = w->mode->sys->variables, order = order_of(level);
    *out = (struct told){ .order = order };
    if (!tape)
        return false;
    size_t roots = (size_t)num_tape_roots(tape);
    assert(roots == (size_t)rq->modes->surfaces * (size_t)(order + 1));       /* the coefficients of each */
    double span = fabs(rq->times[rq->samples - 1] - rq->start), largest = 0;
    SGA_FREED double *in = sga_malloc(((size_t)n + 1) * sizeof *in), *moved = sga_malloc((roots + 1) * sizeof *moved);
    out->value = sga_calloc(3 * roots + 3, sizeof *out->value);
    out->doubt = out->value + roots + 1;
    out->rounding = out->doubt + roots + 1;
    memcpy(in, x, (size_t)n * sizeof *in);
    in[n] = t;
    for (int k = 0; k < n; k++)
        largest = fmax(largest, fabs(x[k]));
    struct traj_request ahead = *rq;
    ahead.start = t;
    signals_ahead(w->mode->sys, &ahead);
    num_tape_eval(tape, in, out->value);
    SGA_ENDS(told_end) struct told_place place;
    told_begin(&place, w->mode->sys, NULL, in);
    for (size_t i = 0; i < roots; i++) {
        out->rounding[i] = told_rounding(&place, w->root[level][i]);
        out->doubt[i] = 64 * DBL_EPSILON * fabs(out->value[i]) + out->rounding[i];
    }
    for (int k = 0; k <= n; k++) {
        double keep = in[k], size = k < n ? fmax(fmax(fabs(x[k]), fabs(rq->initial[k])), speed ? fabs(speed[k]) * span : 0) : fmax(fabs(t), span);
        in[k] = keep + UNTOLD * (size > 0 ? size : largest > 0 ? 1e-3 * largest : 1e-3);
        num_tape_eval(tape, in, moved);
        for (size_t i = 0; i < roots; i++)
            out->doubt[i] += isfinite(moved[i]) ? fabs(moved[i] - out->value[i]) : 0;
        in[k] = keep;
    }
    signals_between(w->mode->sys, NAN, NAN);
    return true;
}

/* Of all that is added up in its coefficients: stands for the one that is not known. */
static double largest_term(const struct told *v, int surface)
{
    double most = 0;
    for (int i = 0; i <= v->order; i++)
        most = fmax(most, v->rounding[(size_t)surface * (size_t)(v->order + 1) + (size_t)i] / DBL_EPSILON);
    return most;
}

/* The sign that a function with these coefficients has just after: 0: not told. */
static int heads_to(double shift, double factor, const struct told *v, int surface, int first, int along, double doubt)
{
    for (int i = first; i <= v->order; i++) {
        size_t at = (size_t)surface * (size_t)(v->order + 1) + (size_t)i;
        double c = factor * v->value[at] + (i ? 0 : shift);
        if (isnan(c))
            return 0;
        /* so small that roundings of what comes before decide whether that comes to 0 at all: it touches 0 */
        double before = i ? fmax(GRAIN * v->doubt[at - 1], v->rounding[at - 1]) : 0, next = i < v->order ? fabs(v->value[at + 1]) : largest_term(v, surface);
        bool touches = i && c * c <= 4 * next * before;
        if (fabs(c) > doubt * v->doubt[at] && !touches)
            return (c > 0 ? 1 : -1) * (along < 0 && i % 2 ? -1 : 1);
    }
    return 0;
}

/* The switch is so near to 1 or -1, and heads there, that roundings of the place make the difference. */
static bool is_brief(const struct decision *d, const struct told *v, int k)
{
    const double *c = v->value + (size_t)k * (size_t)(v->order + 1);
    return d->open[k] && 1 - fabs(c[0]) < NEAR_END && (c[0] > 0 ? 1 : -1) * d->along * c[1] > 0;
}

/* By this mode its function is elsewhere (a relay with hysteresis). */
static bool leaps(const struct decision *d, const struct told *v, int k)
{
    size_t at = (size_t)k * (size_t)(v->order + 1);
    return fabs(v->value[at]) > fmax(d->grain[k], LEAP * v->doubt[at]) && fabs(v->value[at] - d->was[k]) > 0.5 * fabs(v->value[at]);
}

/* Along one surface or on one side of it: whether the motion by this mode stays there. */
static enum way stays(const struct decision *d, const struct told *v, int k, int choice)
{
    int first = d->open[k] == AT_IT && !leaps(d, v, k);
    int a = choice == TRAJ_ALONG ? heads_to(1, -1, v, k, 0, d->along, d->doubt) : heads_to(0, choice == TRAJ_ABOVE ? 1 : -1, v, k, first, d->along, d->doubt);
    int b = choice == TRAJ_ALONG ? heads_to(1, 1, v, k, 0, d->along, d->doubt) : 1;
    return a < 0 || b < 0 ? NO_WAY : !a || !b ? NOT_TOLD : choice == TRAJ_ALONG && is_brief(d, v, k) ? BRIEF : IS_WAY;
}

/* All surfaces, by the derivatives of one level. */
static bool look(const struct decision *d, struct ways *w, const int *choice, int level, const struct traj_initial *start, struct trial *out, struct sga_error *err)
{
    struct told v;
    if (!slide_tell(w, level, d->at->t, start->x, start->derivative, &v, err)) {
        free(v.value);
        return false;
    }
    out->way = IS_WAY;
    for (int k = 0; k < d->surfaces; k++) {
        enum way one = stays(d, &v, k, choice[k]);
        if (one == NO_WAY && !d->open[k])
            d->other[k] = 1;
        out->way = one == NO_WAY || out->way == NO_WAY ? NO_WAY : one > out->way ? one : out->way;
    }
    free(v.value);
    out->what = "the motion touches the surface so closely that derivatives do not tell to which side it goes";
    return true;
}

/* What has a derivative stays where it is. */
static bool moves(const struct decision *d, const struct jump *j, const struct traj_initial *start, const double *x, double span)
{
    double most = 0;
    for (int k = 0; k < j->n; k++)
        if (j->moving[k]) {
            *d->size = fmax(*d->size, fmax(fabs(x[k]), fabs(start->derivative[k]) * span));
            most = fmax(most, fabs(start->x[k] - x[k]));
        }
    return !(most <= STAYS * *d->size);
}

bool slide_try(const struct decision *d, const int *choice, struct trial *out, struct sga_error *err)
{
    const struct traj_modes *modes = d->from->rq->modes;
    const struct traj_mode *m = modes->enter(modes->ctx, choice, d->from, d->at->t, d->at->x, err);
    *out = (struct trial){ .way = NO_WAY, .mode = m };
    if (!m)
        return false;
    if (!m->sol) {
        out->way = m->why ? NOT_TOLD : NO_WAY;
        out->what = m->why;
        return true;
    }
    struct ways *w = slide_ways(d->s, m);
    if (!w->ready && !(w->ready = jump_init(&w->jump, m->sys, m->sol, m->rq, err)))
        return false;
    size_t n = (size_t)m->sys->variables, common = (size_t)modes->start->sys->variables;
    SGA_FREED double *x = sga_calloc(n + 1, sizeof *x);
    SGA_FREED unsigned char *flag = sga_calloc(2 * n + 2, 1);
    struct jump_to to = { .x = x, .changed = flag, .known = flag + n + 1, .turned = m != d->from };
    struct jump_at at = { .t = d->at->t, .x = x, .fired = d->at->fired, .crossing = d->at->crossing };
    struct sga_error why = { 0 };
    memcpy(x, d->at->x, common * sizeof *x);
    memset(to.known, 1, common);
    if (!(out->has_start = jump_start(&w->jump, &at, &to, &out->start, &why) >= 0))
        return sga_budget_ok(m->rq->budget, err);
    if (moves(d, &w->jump, &out->start, x, fabs(m->rq->times[m->rq->samples - 1] - m->rq->start)))
        return true;
    out->stays = true;
    if (!look(d, w, choice, 0, &out->start, out, err))
        return false;
    if (out->way == NOT_TOLD && !look(d, w, choice, 1, &out->start, out, err))
        return false;
    if (out->way != NO_WAY && m->sol->free_columns) {
        out->way = NOT_TOLD;
        out->what = "the equations leave free what the switch is while the motion slides";
    }
    return true;
}

void slide_trial_clear(struct trial *t)
{
    if (t->has_start)
        traj_initial_clear(&t->start);
    t->has_start = false;
}

/* Whether the rates of the slide are a convex combination of those of both sides: of what has a derivative in all three. */
static bool is_convex(const struct decision *d, const struct trial *trial)
{
    const struct trial *up = trial + TRAJ_ABOVE, *down = trial + TRAJ_BELOW, *on = trial + TRAJ_ALONG;
    if (!up->has_start || !down->has_start || !on->has_start)
        return true;              /* one side has no motion here: the equations alone say what is between */
    const unsigned char *moving = d->now->moving;
    double top = 0, square = 0, size = 0;
    for (int k = 0; k < d->from->rq->modes->start->sys->variables; k++) {
        double a = up->start.derivative[k], b = down->start.derivative[k], c = on->start.derivative[k];
        if (!moving[k])
            continue;
        top += (c - b) * (a - b);
        square += (a - b) * (a - b);
        size = fmax(size, fmax(fabs(a), fabs(b)));
    }
    double part = square > 0 ? top / square : 0;
    for (int k = 0; k < d->from->rq->modes->start->sys->variables; k++) {
        double a = up->start.derivative[k], b = down->start.derivative[k], c = on->start.derivative[k];
        if (moving[k] && fabs(c - b - part * (a - b)) > CONVEX * size)
            return false;
    }
    return part >= -CONVEX && part <= 1 + CONVEX;
}

/* What the trials came to. */
struct verdict {
    int ways, brief, bent;
    const char *not_told;
};

/* All values of the surfaces that are open. best: the way found last. */
static bool try_all(const struct decision *d, const int *choice, struct verdict *v, int *best, struct sga_error *err)
{
    int open[MOST_TRIED], count = 0, all = 1;
    SGA_FREED int *mine = sga_malloc(((size_t)d->surfaces + 1) * sizeof *mine);
    *v = (struct verdict){ 0 };
    memset(d->other, 0, (size_t)d->surfaces);
    for (int k = 0; k < d->surfaces; k++)
        if (d->open[k]) {
            assert(count < MOST_TRIED);
            open[count++] = k;
            all *= 3;
        }
    struct trial *trial = sga_calloc((size_t)all, sizeof *trial);
    bool ok = true;
    for (int i = 0; ok && i < all; i++) {
        memcpy(mine, choice, (size_t)d->surfaces * sizeof *mine);
        for (int k = 0, rest = i; k < count; k++, rest /= 3)
            mine[open[k]] = rest % 3;
        ok = sga_budget_ok(d->from->rq->budget, err) && slide_try(d, mine, trial + i, err);
        if (ok && trial[i].way == IS_WAY) {
            v->ways++;
            memcpy(best, mine, (size_t)d->surfaces * sizeof *mine);
        } else if (ok && trial[i].way == BRIEF && !v->ways && !v->brief++) {
            memcpy(best, mine, (size_t)d->surfaces * sizeof *mine);
        } else if (ok && trial[i].way == NOT_TOLD) {
            v->not_told = trial[i].what;
        }
    }
    v->ways = v->ways ? v->ways : v->brief == 1;
    if (ok && count == 1 && v->ways == 1 && best[open[0]] == TRAJ_ALONG && !is_convex(d, trial))
        v->bent = 1;
    for (int i = 0; i < all; i++)
        slide_trial_clear(trial + i);
    free(trial);
    return ok;
}

static bool ends(char *why, const char *text)
{
    snprintf(why, 256, "%s", text);
    return false;
}

/* Those that are asked from the beginning: they happen, or the point lies on them; the others are as the point says. */
static bool open_at_point(const struct decision *d, int *choice, struct sga_error *err)
{
    struct told v;
    const struct traj_modes *modes = d->from->rq->modes;
    const struct traj_request *rq = d->from->rq;
    double span = fabs(rq->times[rq->samples - 1] - rq->start);
    bool ok = slide_tell(slide_ways(d->s, d->from), 0, d->at->t, d->at->x, NULL, &v, err);
    for (int k = 0; ok && k < d->surfaces; k++) {
        size_t at = (size_t)k * (size_t)(v.order + 1);
        d->was[k] = v.value[at];
        d->grain[k] = choice[k] == TRAJ_ALONG ? INFINITY : fmax(LEAP * v.doubt[at], PART * (fabs(v.value[at + 1]) * span + v.rounding[at] / DBL_EPSILON));
        bool now = d->at->fired[modes->own + 2 * k] || d->at->fired[modes->own + 2 * k + 1];
        d->open[k] = now || (choice[k] != TRAJ_ALONG && !(fabs(v.value[at]) > v.doubt[at]));
        if (choice[k] == TRAJ_AS_WRITTEN)
            choice[k] = v.value[at] > 0 ? TRAJ_ABOVE : TRAJ_BELOW;
    }
    free(v.value);
    return ok;
}

/* With derivatives told from 0, or as they are; other surfaces that would be left join in. True: decided, one way or the other. */
static bool decide(struct decision *d, int *choice, struct verdict *v, char *why, bool *ok, struct sga_error *err)
{
    SGA_FREED int *best = sga_calloc((size_t)d->surfaces + 1, sizeof *best);
    for (;;) {
        int count = 0, more = 0;
        for (int k = 0; k < d->surfaces; k++)
            count += d->open[k] != 0;
        if (count > MOST_TRIED) {
            const char *not_told = NULL;
            memcpy(best, choice, (size_t)d->surfaces * sizeof *best);
            memset(d->other, 0, (size_t)d->surfaces);
            *v = (struct verdict){ 0 };
            *ok = slide_many(d, best, &v->ways, &not_told, err);
            if (*ok && not_told)
                *ok = ends(why, not_told);
        } else {
            *ok = try_all(d, choice, v, best, err);
        }
        if (!*ok)
            return true;
        if (v->ways) {
            memcpy(choice, best, (size_t)d->surfaces * sizeof *choice);
            return true;
        }
        for (int k = 0; k < d->surfaces; k++) {
            if (!d->other[k] || d->open[k])
                continue;
            d->open[k] = choice[k] == TRAJ_ALONG ? AT_IT : TURNED;
            more++;
        }
        if (!more)
            return false;
    }
}

bool slide_choose(struct slide *s, struct jump *now, const struct traj_mode *from, const struct jump_at *at, int *choice, char *why, struct sga_error *err)
{
    const struct traj_request *rq = from->rq;
    size_t surfaces = (size_t)rq->modes->surfaces;
    SGA_FREED unsigned char *flag = sga_calloc(3 * surfaces + 3, 1);
    SGA_FREED double *was = sga_calloc(2 * surfaces + 1, sizeof *was);
    struct decision d = { .s = s, .was = was, .grain = was + surfaces, .now = now, .from = from, .at = at, .surfaces = rq->modes->surfaces, .along = rq->times[rq->samples - 1] < rq->start ? -1 : 1, .doubt = 1,
                          .open = flag, .other = flag + surfaces + 1 };
    struct verdict v = { 0 };
    double size = 0;
    bool ok = true;
    d.size = &size;
    why[0] = '\0';
    if (!open_at_point(&d, choice, err))
        return false;
    memcpy(flag + 2 * surfaces + 2, d.open, surfaces);
    if (!decide(&d, choice, &v, why, &ok, err) && !v.not_told) {       /* a derivative that is small may still decide */
        memcpy(d.open, flag + 2 * surfaces + 2, surfaces);
        d.doubt = 0;
        decide(&d, choice, &v, why, &ok, err);
    }
    if (!ok)
        return false;
    if (v.ways > 1)
        return ends(why, "at a surface where a switch jumps more than one motion goes on: the equations do not say which");
    if (v.bent)
        return ends(why, "the motion would slide along a surface where a switch jumps that enters the equations nonlinearly: between both sides its values and convex combinations of the fields "
                    "give different motions");
    if (!v.ways && v.not_told)
        return ends(why, v.not_told);
    for (size_t k = 0; k < surfaces; k++)
        assert(choice[k] == TRAJ_ABOVE || choice[k] == TRAJ_BELOW || choice[k] == TRAJ_ALONG);
    return v.ways || ends(why, "at a surface where a switch jumps no motion goes on: neither side leads away from it, and no value of the switch from -1 to 1 keeps the motion on it");
}

bool slide_sides(struct slide *s, const struct traj_mode *m, double t, const double *x, signed char *side, struct sga_error *err)
{
    const struct traj_modes *modes = m->rq->modes;
    struct told v;
    if (!slide_tell(slide_ways(s, m), 0, t, x, NULL, &v, err)) {
        free(v.value);
        return false;
    }
    for (int k = 0; k < modes->surfaces; k++) {
        size_t at = (size_t)k * (size_t)(v.order + 1);
        signed char *low = side + modes->own + 2 * k, *high = low + 1;
        double value = v.value[at], doubt = v.doubt[at];
        *low = *high = ODE_SIDE_TOLD;
        if (m->choice[k] != TRAJ_ALONG && (fabs(value) <= doubt || (m->choice[k] == TRAJ_ABOVE) != (value > 0)))      /* beside it by dust, whose size says nothing */
            *low = m->choice[k] == TRAJ_ABOVE ? 1 : -1;
        if (m->choice[k] == TRAJ_ALONG) {
            *low = fabs(value - 1) <= doubt ? -1 : ODE_SIDE_TOLD;
            *high = fabs(value + 1) <= doubt ? 1 : ODE_SIDE_TOLD;
        }
    }
    free(v.value);
    return true;
}
