/* See search.h. */
#include "search.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "lin_sparse.h"
#include "mem.h"
#include "newton.h"
#include "points_space.h"

enum { KEPT = 12 };     /* sets: as many as a search has stages, as a rule */

/* What was made of one set, and of which. */
struct kept {
    struct points_search search;
    struct points_space space;     /* its lists are the arena's */
};

struct points_kept {
    struct sga_arena mem;
    int count;
    struct kept *of[KEPT];
};

void points_search_init(struct points_search *w, const struct points_space *space)
{
    *w = (struct points_search){ .has_quick = false };
    points_jacobian_init(&w->j, space);
    normal_init(&w->normal, space->constraints, space->variables, w->j.col, w->j.cols);
}

void points_whole_clear(struct points_whole *w)
{
    lin_stairs_clear(&w->stairs);
    lin_sparse_free(w->J);
    free(w->of);
}

void points_search_clear(struct points_search *w)
{
    points_whole_clear(&w->whole);
    if (w->has_quick)
        points_quick_clear(&w->quick);
    normal_clear(&w->normal);
    points_jacobian_clear(&w->j);
}

struct points_quick *points_search_quick(struct points_search *w)
{
    if (!w->has_quick)
        points_quick_init(&w->quick, &w->j);
    w->has_quick = true;
    return &w->quick;
}

struct points_kept *points_kept_new(void)
{
    return sga_calloc(1, sizeof(struct points_kept));
}

void points_kept_free(struct points_kept *k)
{
    if (!k)
        return;
    for (int i = 0; i < k->count; i++)
        points_search_clear(&k->of[i]->search);
    sga_arena_end(&k->mem);
    free(k);
}

static bool same_list(const int *a, const int *b, int count)
{
    return count == 0 || memcmp(a, b, (size_t)count * sizeof *a) == 0;
}

/* The same constraints, and symbols in the same places: what a search has made of them is of all others that have these. */
static bool same(const struct points_space *a, const struct points_space *b)
{
    return a->st == b->st && a->variables == b->variables && a->parameters == b->parameters && a->time == b->time && a->constraints == b->constraints
           && same_list(a->variable, b->variable, a->variables) && same_list(a->parameter, b->parameter, a->parameters)
           && memcmp(a->constraint, b->constraint, (size_t)a->constraints * sizeof *a->constraint) == 0;
}

static void *copy(struct sga_arena *mem, const void *from, int count, size_t size)
{
    void *to = sga_take(mem, ((size_t)count + 1) * size);
    if (count)
        memcpy(to, from, (size_t)count * size);
    return to;
}

struct points_search *points_kept_of(struct points_kept *k, const struct points_space *space)
{
    if (!k || space->constraints <= POINTS_QUICK)
        return NULL;
    for (int i = 0; i < k->count; i++)
        if (same(&k->of[i]->space, space)) {
            k->of[i]->search.j.space = space;
            return &k->of[i]->search;
        }
    if (k->count == KEPT)
        return NULL;
    struct kept *made = k->of[k->count++] = sga_take(&k->mem, sizeof *made);
    made->space = (struct points_space){
        .st = space->st, .variables = space->variables, .parameters = space->parameters, .time = space->time, .constraints = space->constraints,
        .variable = copy(&k->mem, space->variable, space->variables, sizeof *space->variable),
        .parameter = copy(&k->mem, space->parameter, space->parameters, sizeof *space->parameter),
        .constraint = copy(&k->mem, space->constraint, space->constraints, sizeof *space->constraint),
    };
    points_search_init(&made->search, space);
    return &made->search;
}
