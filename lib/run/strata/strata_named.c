/* Pivots through the names of their parts: x s + y^2 with s = x is a sum of squares, which no name may hide. */
#include "strata_listing.h"

#include "alike.h"
#include "definition.h"
#include "run_job.h"
#include "request.h"

static const struct definitions *names(struct listing *l)
{
    if (!l->names_known)
        definitions_find(l->names, &l->j->request->system, DEFINITIONS_ALL, l->j->budget);
    l->names_known = true;
    return l->names;
}

/* Sums of squares count as two, as their zeros are found in another way. */
static int parts(const struct poly_factors *f)
{
    int n = 0;
    for (int i = 0; i < f->factors; i++)
        n += f->factor[i].sum_of_even_powers ? 2 : !f->factor[i].never_zero;
    return n;
}

bool strata_through(struct listing *l, expr_id value, const struct poly_limits *limits, struct poly_factors *f)
{
    struct poly_factors named;
    expr_id through = value;
    definitions_through(names(l), &l->j->request->system, &through, 1);
    bool factored = poly_alike_factors(l->alike, value, limits, f);
    if (!through || through == value || !poly_alike_factors(l->alike, through, limits, &named))
        return factored;
    bool more = !factored || parts(&named) != parts(f);
    if (factored)
        poly_factors_clear(more ? f : &named);
    if (more)
        *f = named;
    return true;
}
