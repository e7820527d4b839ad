/* From one mode into another: variables by their names. */
#include "jump_turn.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "slide.h"
#include "system.h"

bool turn_init(struct turn *s, const struct traj_mode *mode, struct sga_error *err)
{
    *s = (struct turn){ .mode = mode, .slide = slide_any(mode->rq) ? slide_new() : NULL };
    return jump_init(&s->j, mode->sys, mode->sol, mode->rq, err);
}

void turn_clear(struct turn *s)
{
    jump_clear(&s->j);
    slide_free(s->slide);
}

/* In the variables of the present mode: values, what is set, what there was. */
static void carry(struct turn *s, const double *x, const double *was, const unsigned char *changed, struct jump_to *to)
{
    for (int k = 0; k < s->before.n; k++) {
        int v = jump_same(&s->before, k, &s->j);
        if (v < 0)
            continue;
        to->x[v] = x[k];
        s->was[v] = was[k];
        to->changed[v] = changed[k];
        to->known[v] = 1;
    }
}

static void make_room(struct turn *s, struct jump_to *to, size_t n)
{
    s->x = sga_calloc(2 * n + 2, sizeof *s->x);
    s->was = s->x + n + 1;
    s->place = sga_calloc(2 * n + 2, 1);
    *to = (struct jump_to){ .x = s->x, .changed = s->place, .known = s->place + n + 1 };
}

bool turn_begin(struct turn *s, const struct jump_at *at, struct jump_to *to, struct sga_error *err)
{
    const struct traj_modes *modes = s->mode->rq->modes;
    size_t n = (size_t)s->j.n, m = modes ? (size_t)modes->modes : 0;
    SGA_FREED int *choice = sga_calloc(m + 1, sizeof *choice);
    SGA_FREED double *x = sga_calloc(n + 1, sizeof *x);
    SGA_FREED unsigned char *changed = sga_calloc(n + 1, 1);
    assert(!s->changing && s->j.n == s->mode->sys->variables);       /* the turn before was ended */
    s->changing = false;
    make_room(s, to, n);
    if (m)
        memcpy(choice, s->mode->choice, m * sizeof *choice);
    s->why[0] = '\0';
    if (!jump_assign(&s->j, at, x, changed, choice, err))
        return false;
    if (s->slide && !s->stays && !slide_choose(s->slide, &s->j, s->mode, at, choice, s->why, err))
        return s->why[0];
    if (!m || !memcmp(choice, s->mode->choice, m * sizeof *choice)) {
        memcpy(s->x, x, n * sizeof *x);
        memcpy(s->was, at->x, n * sizeof *x);
        memcpy(to->changed, changed, n);
        memset(to->known, 1, n);
        return true;
    }
    const struct traj_mode *next = modes->enter(modes->ctx, choice, s->mode, at->t, x, err);
    if (!next)
        return false;
    s->before = s->j;
    s->changing = true;
    s->mode = next;
    if (!jump_init(&s->j, next->sys, next->sol, next->rq, err))
        return false;
    free(s->x);
    free(s->place);
    make_room(s, to, (size_t)s->j.n);
    to->turned = true;
    carry(s, x, at->x, changed, to);
    return true;
}

bool turn_land(struct turn *s, const struct jump_at *at, struct jump_to *to, signed char *side, unsigned char *stands, struct sga_error *err)
{
    struct jump_at now = *at;
    now.x = s->was;
    struct jump_turn t = { s->changing ? &s->before : &s->j, &s->j, at, &now };
    bool ok = jump_land(&t, to, side, stands, err);
    snprintf(s->why, sizeof s->why, "%s", to->why);
    return ok;
}

void turn_end(struct turn *s, struct jump_to *to)
{
    if (s->changing)
        jump_clear(&s->before);
    s->changing = false;
    free(s->x);
    free(s->place);
    free(to->impulse);
    free(to->slope);
    s->x = s->was = NULL;
    s->place = NULL;
}
