/* See jump_fine.h. */
#include "jump_fine.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "ball.h"
#include "enclosed.h"
#include "error.h"
#include "flint_ends.h"
#include "jump_turn.h"
#include "mem.h"
#include "precise.h"
#include "slide.h"
#include "system.h"

enum { BITS = 256 };

num_dd jump_fine_ball(const arb_t a)
{
    SGA_ENDS(fmpq_end) fmpq_t q = { 0 };
    if (!arb_is_finite(a))
        return num_dd_of(NAN);
    arf_get_fmpq(q, arb_midref(a));
    return num_dd_of_fmpq(q);
}

static num_dd of_text(const char *s)
{
    SGA_ENDS(arb_end) arb_t a = { 0 };
    return s && !arb_set_str(a, s, BITS) ? jump_fine_ball(a) : num_dd_of(NAN);
}

expr_id jump_fine_constant(struct expr_store *st, num_dd v)
{
    return expr_add(st, expr_double(st, v.hi), expr_double(st, v.lo));
}

bool jump_fine_any(const struct traj_request *rq)
{
    bool any = false;
    for (int e = 0; e < rq->events; e++)
        any |= rq->event[e].sets > 0;
    return rq->arithmetic == TRAJ_DOUBLE_DOUBLE && (slide_any(rq) ? rq->carried != NULL : any);
}

struct jump_fine *jump_fine_new(const struct sys_system *sys, const struct traj_request *rq, double wrong)
{
    if (!jump_fine_any(rq))
        return NULL;
    struct jump_fine *f = sga_calloc(1, sizeof *f);
    f->wrong = wrong;
    f->time = sga_calloc((size_t)rq->samples + 1, sizeof *f->time);
    SGA_ENDS(arb_end) arb_t a = { 0 };
    for (int i = 0; i < rq->samples; i++) {
        num_ball_constant(sys->store, rq->exact_time ? rq->exact_time[i] : EXPR_UNDEF, rq->times[i], BITS, a);
        f->time[i] = jump_fine_ball(a);
    }
    return f;
}

void jump_fine_free(struct jump_fine *f)
{
    if (!f)
        return;
    free(f->time);
    free(f->x);
    free(f->exact);
    free(f->sample);
    free(f);
}

void jump_fine_first(struct jump_piece *q, const struct traj_request *rq)
{
    q->q.exact_start = rq->exact_start;
    q->q.exact_initial = rq->exact_initial;
    q->q.exact_time = rq->exact_time;
}

bool jump_fine_start(struct jump_fine *f, const struct jump_piece *q, const struct traj_mode *mode, struct sga_error *err)
{
    const struct traj_mode of = jump_carried(mode);
    struct traj_result r;
    SGA_ENDS(arb_end) arb_t t = { 0 };
    int all = of.sys->variables;
    if (!jump_piece_start(q, mode, &r, err))
        return false;
    num_ball_constant(of.sys->store, of.rq->exact_start, of.rq->start, BITS, t);
    f->t = jump_fine_ball(t);
    f->x = sga_realloc(f->x, ((size_t)all + 1) * sizeof *f->x);
    bool ok = r.rows == 1 && r.digits;
    for (int k = 0; k < all && ok; k++) {
        f->x[k] = of_text(r.digits[r.columns - all + k]);
        ok = isfinite(f->x[k].hi);
    }
    traj_result_clear(&r);
    return ok || sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/initial", "the start has no digits beyond those of a double; use \"double\"");
}

bool jump_fine_end(struct jump_fine *f, const struct traj_result *piece, int all)
{
    size_t wide = (size_t)piece->columns + 1;
    if (!piece->happened_digits || !piece->happened)
        return false;
    char **digits = piece->happened_digits + (size_t)(piece->happened - 1) * wide;
    f->t = of_text(digits[0]);
    f->x = sga_realloc(f->x, ((size_t)all + 1) * sizeof *f->x);
    bool ok = isfinite(f->t.hi);
    for (int k = 0; k < all; k++) {
        f->x[k] = of_text(digits[wide - (size_t)all + (size_t)k]);
        ok = ok && isfinite(f->x[k].hi);
    }
    return ok;
}

bool jump_fine_begin(struct jump_fine *f, struct jump_piece *q, const struct turn *s, int done, int samples, struct sga_error *err)
{
    struct traj_mode own = jump_carried(s->mode);
    struct expr_store *st = own.sys->store;
    int n = s->j.n, all = own.sys->variables;
    f->exact = sga_realloc(f->exact, ((size_t)all + 1) * sizeof *f->exact);
    f->sample = sga_realloc(f->sample, ((size_t)samples + 1) * sizeof *f->sample);
    for (int k = 0; k < all; k++) {
        bool moves = s->j.moving[k % n], known = k < n || moves;
        f->exact[k] = known ? jump_fine_constant(st, f->x[k]) : EXPR_UNDEF;
        q->given[k] = known;
        q->held[k] = moves;
        q->x[k] = f->x[k].hi;
    }
    for (int i = done; i < samples; i++)
        f->sample[i] = jump_fine_constant(st, f->time[i]);
    q->q.start = f->t.hi;
    q->q.exact_start = jump_fine_constant(st, f->t);
    q->q.exact_initial = f->exact;
    q->q.exact_time = f->sample + done;
    assert(done <= samples);
    return expr_store_ok(st) || (*err = *st->error, false);
}

double jump_fine_apart(const char *a, const char *b)
{
    return a && b ? fabs(num_dd_sub(of_text(a), of_text(b)).hi) : INFINITY;
}

char *jump_fine_text(char *text, double error)
{
    if (!text)
        return NULL;
    char *to = precise_digits(of_text(text), error);
    free(text);
    return to;
}
