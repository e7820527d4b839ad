/* In which order candidates become constraints. What a set is does not depend on it, but what can be seen of it does: a union
 * may be one set beside the others, an irregular function may follow from them. */
#include "admit.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "mem.h"
#include "oracle.h"
#include "place_search.h"
#include "points.h"
#include "product_routes.h"
#include "regular.h"
#include "system.h"
#include "warnings.h"

/* Those that can be used up come first, then the others are seen as they are on the set; among each the smaller ones:
 * what follows from two others with factors is larger than these, wherever it stands. Affine ones stay as they are. */
struct ranked {
    struct candidate c;
    int last, size, place;
};

static int by_rank(const void *a, const void *b)
{
    const struct ranked *x = a, *y = b;
    if (x->last != y->last)
        return x->last - y->last;
    return x->size != y->size ? x->size - y->size : x->place - y->place;
}

static void order(struct state *s, struct candidate *cand, int count)
{
    if (count < 2 || s->sol->constraints + count > SGA_MOST_REDUCED_BY)
        return;
    SGA_FREED struct ranked *sorted = sga_calloc((size_t)count, sizeof *sorted);
    bool affine = true;
    for (int i = 0; i < count; i++)
        affine = affine && regular_all_affine(s, cand[i].expr);
    for (int i = 0; i < count; i++) {
        expr_cone_of(s->st, &s->cone, &cand[i].expr, 1);
        sorted[i] = (struct ranked){ .c = cand[i], .size = affine ? 0 : s->cone.count, .place = i };
    }
    for (int i = 0; i < count && sga_budget_ok(s->options->budget, NULL); i++)
        sorted[i].last = !regular_is_solved(s, cand[i].expr);
    qsort(sorted, (size_t)count, sizeof *sorted, by_rank);
    for (int i = 0; i < count; i++)
        cand[i] = sorted[i].c;
}

/* What stands before candidates are tried: constraints, the zeros and sides found on them, and a point. */
struct stand {
    int constraints, branches, sides, zeros;
    double *x, t;            /* by variable; owned, NULL where there is no point */
};

static struct stand stand_of(const struct state *s)
{
    struct stand st = { s->sol->constraints, s->sol->branches, s->oracle->sides, s->oracle->zeros, NULL, 0 };
    if (s->oracle->reals) {
        size_t n = (size_t)s->sys->variables;
        st.x = memcpy(sga_malloc((n + 1) * sizeof *st.x), s->oracle->real[0].x, n * sizeof *st.x);
        st.t = s->oracle->real[0].t;
    }
    return st;
}

/* Back to it, with points near the one that stood: those of a smaller set, which candidates led to, are special ones. False
 * where that does not lead back to points. */
static bool take_back(struct state *s, const struct stand *before)
{
    assert(before->constraints <= s->sol->constraints && before->branches <= s->sol->branches);
    admit_pop(s, before->constraints);
    s->sol->branches = before->branches;
    s->oracle->sides = before->sides;
    s->oracle->zeros = before->zeros;
    *s->err = (struct sga_error){ 0 };
    if (before->x && place_sample_near(s, before->x, before->t) == POINTS_OK)
        return true;
    points_oracle_forget(s->oracle);
    return state_sample(s) == POINTS_OK;
}

/* Of several failures the same one is told in whatever order they came. */
static void keep_failure(struct sga_error *kept, const struct sga_error *other)
{
    if (kept->code == SGA_E_OK || other->code < kept->code)
        *kept = *other;
}

/* Whether e is a union, as it is known on the present set. */
static bool reducible(struct state *s, expr_id e)
{
    struct points_oracle *w = s->oracle;
    struct route *route = s->route;
    int sides = w->sides, zeros = w->zeros;
    SGA_FREED struct points_side *side = sga_malloc(((size_t)sides + 1) * sizeof *side);
    if (sides)
        memcpy(side, w->side, (size_t)sides * sizeof *side);
    s->route = NULL;             /* a question, no decision: what it rests on is not what the answer rests on */
    SGA_ENDS(regular_clear) struct regular r = regular_form(s, e);
    bool is = r.options > 1;
    s->route = route;
    if (sides)
        memcpy(w->side, side, (size_t)sides * sizeof *side);
    w->sides = sides;
    w->zeros = zeros;
    return is;
}

/* Whether e is 0 on the present set on one side of a surface only: on the set of the others it may lie. */
static bool one_sided(struct state *s, expr_id e)
{
    bool mixed = false;
    points_oracle_cells(s->oracle, e, false, false, &mixed);
    return mixed;
}

/* Candidates that are admitted one by one. */
struct admission {
    const struct candidate *cand;
    int count, g;
    unsigned char *done;
    int *failed;             /* by candidate: beside how many constraints it failed, or -1 */
    struct sga_error failure;
};

/* False: a failure that ends the run. */
static bool try_one(struct state *s, struct admission *a, int i)
{
    struct stand before = stand_of(s);
    a->done[i] = admit_one(s, a->cand + i, a->g) >= 0;
    if (a->done[i]) {
        free(before.x);
        return true;
    }
    struct sga_error here = *s->err;
    a->failed[i] = before.constraints;
    keep_failure(&a->failure, &here);
    bool back = routes_local(here.code) && expr_store_ok(s->st) && take_back(s, &before);
    free(before.x);
    if (!back)
        *s->err = here;
    return back;
}

/* Tries what has not failed beside the present constraints: all that is no union, or the first that is one. Returns
 * whether something was tried, or -1. */
static int try_some(struct state *s, struct admission *a, bool unions)
{
    int tried = 0;
    for (int i = 0; i < a->count && !s->inconsistent && !(unions && tried); i++) {
        if (a->done[i] || a->failed[i] == s->sol->constraints || (one_sided(s, a->cand[i].expr) || reducible(s, a->cand[i].expr)) != unions)
            continue;
        tried = 1;
        if (!try_one(s, a, i))
            return -1;
    }
    return tried;
}

/* One by one. Unions wait for the others, on whose set they may follow or be a single set; those that fail are tried once
 * more beside more constraints, where an irregular one may follow. What is left comes first in cand, then; how many, with
 * the failure, or -1. */
static int admit_each(struct state *s, struct candidate *cand, int count, int g, struct sga_error *failure)
{
    struct admission a = { .cand = cand, .count = count, .g = g };
    a.done = sga_calloc((size_t)count + 1, 1);
    a.failed = sga_malloc((size_t)(count + 1) * sizeof *a.failed);
    for (int i = 0; i < count; i++)
        a.failed[i] = -1;
    int tried = 1, left = 0;
    while (tried > 0 && !s->inconsistent) {
        tried = try_some(s, &a, false);
        if (!tried && !s->inconsistent)
            tried = try_some(s, &a, true);
    }
    for (int i = 0; i < count; i++)
        if (!a.done[i]) {
            struct candidate c = cand[i];
            memmove(cand + left + 1, cand + left, (size_t)(i - left) * sizeof *cand);
            cand[left++] = c;
        }
    free(a.done);
    free(a.failed);
    *failure = a.failure;
    return tried < 0 ? -1 : s->inconsistent ? 0 : left;
}

/* In one order after the other: a set that is regular in one (a circle, then a rod) may not look so in another (a circle that a
 * point in the middle of a rod just reaches). What was left comes first in the next. Only near a guess: elsewhere the
 * points of another order may be those of another component, which product_routes.h looks for. What is left in the end fails, or is held
 * back where a contradiction may show without it. */
static bool admit_in_orders(struct state *s, struct candidate *cand, int count, int g)
{
    struct stand before = stand_of(s);
    int left = 1, orders = s->options->near ? 3 : 1;
    for (int k = 0; k < orders && left > 0; k++) {
        struct sga_error failure;
        if (k && !take_back(s, &before)) {
            left = -1;
            break;
        }
        left = admit_each(s, cand, count, g, &failure);
        if (left > 0 && k + 1 == orders) {
            s->sol->stuck = cand[0].expr;
            keep_failure(&s->held, &failure);
        }
    }
    free(before.x);
    return left >= 0;
}

int state_admit(struct state *s, struct candidate *cand, int count, int g)
{
    int before = s->sol->constraints;
    if (!count)
        return 0;
    order(s, cand, count);
    int added = admit_together(s, cand, count, g);
    if (added != -1)
        return added < 0 ? -1 : added;
    return admit_in_orders(s, cand, count, g) ? s->sol->constraints - before : -1;
}
