/* See search.h. */
#include "search.h"

#include <stdlib.h>

#include "lin_sparse.h"
#include "points_space.h"

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
