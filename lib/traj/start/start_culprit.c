/* What keeps a start from being found: the relations one by one, then together, then the bounds. */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "buf.h"
#include "error.h"
#include "start_search.h"
#include "system.h"

/* Equations that are left out in turn, for the text. */
enum { TRIES = 16 };

static const char *name_of(const struct start_search *s, int j) { return s->sys->store->symbol[s->sys->variable[j].symbol].name; }

/* Whether some start meets these, in bounds or not. */
static bool meets(struct start_search *s, const unsigned char *use, bool freed, struct start_found *at)
{
    struct start_found outside = { 0 };
    bool inside = start_search_find(s, use, freed, at, &outside);
    if (!inside)
        *at = outside;
    return at->x != NULL;
}

/* By the whole search: before something is said of a relation. */
static bool meets_after_all(struct start_search *s, const unsigned char *use, struct start_found *at)
{
    s->few = false;
    bool ok = meets(s, use, false, at);
    s->few = true;
    return ok;
}

/* ", where left - right is 0.3 at the nearest start without it" */
static void missed(struct start_search *s, int i, const struct start_found *without, struct sga_buf *out)
{
    double *residual = sga_zeros(&s->mem, (size_t)s->rq->relations + 1, sizeof *residual);
    if (without->x && start_residuals(s, without->x, residual))
        sga_buf_printf(out, "; at the nearest start without it left - right is %.3g", residual[i]);
}

/* The relation i does not go with those of use before it. */
static bool refuse_relation(struct start_search *s, int i, unsigned char *use, const struct start_found *without, struct sga_error *err)
{
    SGA_ENDS(sga_buf_free) struct sga_buf others = { 0 };
    struct start_found at;
    const char *place = s->rq->relation[i].place;
    bool held = s->rq->held && memchr(s->rq->held, 1, (size_t)s->sys->variables), freed = false;
    use[i] = 1;
    int tries = 0;
    for (int k = 0; k < i && tries < TRIES; k++) {           /* what it contradicts the rest without is none of it */
        if (!use[k])
            continue;
        use[k] = 0;
        tries++;
        if (meets(s, use, false, &at))
            use[k] = 1;
    }
    for (int k = 0; k < i; k++)
        if (use[k] && others.len < 200)
            sga_buf_printf(&others, "%s\"%.80s\" (number %d)", others.len ? ", " : " and ", s->rq->relation[k].text, k);
    if (held)
        freed = meets(s, use, true, &at);
    if (!sga_budget_ok(s->rq->budget, err))
        return false;
    if (freed)
        return sga_fail_at(err, SGA_E_INITIAL, "/trajectory/hold", "no start was found where \"%.150s\"%s holds with the held values, and one was where these may move; leave variables out of hold, "
                           "or change their values", s->rq->relation[i].text, others.len ? others.data : "");
    SGA_ENDS(sga_buf_free) struct sga_buf miss = { 0 };
    missed(s, i, without, &miss);
    return sga_fail_at(err, SGA_E_INITIAL, place, "no start was found on the constraints where \"%.150s\"%s hold%s%s; change %s", s->rq->relation[i].text,
                       others.len ? others.data : "", others.len ? " together" : "s", miss.len ? miss.data : "", others.len ? "one of them, or leave one out" : "it, or leave it out");
}

static bool refuse_bound(struct start_search *s, const struct start_found *outside, struct sga_error *err)
{
    int worst = -1;
    for (int k = 0; k < s->sys->variables; k++) {
        int j = s->by_name[k];
        double out = start_outside(s->rq, outside->x, j);
        if (out > 0 && (worst < 0 || out > start_outside(s->rq, outside->x, worst)))
            worst = j;
    }
    assert(worst >= 0);
    char place[256];
    bool held = s->rq->held && s->rq->held[worst];
    snprintf(place, sizeof place, "/trajectory/bounds/%.200s", name_of(s, worst));
    bool below = outside->x[worst] < s->rq->low[worst];
    return sga_fail_at(err, SGA_E_INITIAL, place, "no start was found within the bounds: the one that comes closest has %.100s = %.6g, %s %.6g%s; change the bound, %s", name_of(s, worst),
                       outside->x[worst], below ? "below" : "above", below ? s->rq->low[worst] : s->rq->high[worst], held ? ", where it is held" : "",
                       held ? "or leave it out of hold" : "or give trajectory.initial near a start that is meant");
}

bool start_culprit(struct start_search *s, const struct start_found *outside, struct sga_error *err)
{
    unsigned char *use = sga_zeros(&s->mem, (size_t)s->rq->relations + 1, 1);
    struct start_found before = { 0 }, at;
    if (!sga_budget_ok(s->rq->budget, err))
        return false;
    if (outside->x)
        return refuse_bound(s, outside, err);
    s->few = true;
    if (!meets_after_all(s, use, &before)) {                        /* without any: the refusal of the guess itself */
        struct traj_initial r;
        if (traj_consistent(s->sys, s->sol, &s->plain, &r, err)) {
            traj_initial_clear(&r);
            return sga_fail_at(err, SGA_E_INITIAL, "/trajectory", "no start was found within the bounds; change trajectory.bounds");
        }
        return false;
    }
    for (int i = 0; i < s->rq->relations; i++) {                 /* alone against the constraints */
        memset(use, 0, (size_t)s->rq->relations);
        use[i] = 1;
        if (!meets(s, use, false, &at) && !meets_after_all(s, use, &at)) {
            use[i] = 0;
            return refuse_relation(s, i, use, &before, err);
        }
    }
    memset(use, 0, (size_t)s->rq->relations);
    for (int i = 0; i < s->rq->relations; i++) {                 /* beside those before it */
        use[i] = 1;
        if (!meets(s, use, false, &at) && !meets_after_all(s, use, &at)) {
            use[i] = 0;
            return refuse_relation(s, i, use, &before, err);
        }
        before = at;
    }
    return sga_budget_ok(s->rq->budget, err) ? sga_fail_at(err, SGA_E_INITIAL, "/trajectory/start_equations", "no start was found; change trajectory.initial or the start's equations") : false;
}
