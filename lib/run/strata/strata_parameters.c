/* The cases of the symbolic parameters: what the reduction took for granted of them, part by part. */
#include "strata_listing.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "cases.h"
#include "run_job.h"
#include "mem.h"
#include "request.h"
#include "stratum.h"
#include "warnings.h"

/* Whether the part was looked at where this answer is a stratum of: with the same parameters it is no case of its own. */
static bool ruled_out(const struct job *j, const struct cases_part *part)
{
    for (const struct job *a = j; a->place.above && !a->place.is_case; a = a->place.above)
        for (int i = 0; i < a->place.above->strata.count; i++) {
            const struct stratum *s = a->place.above->strata.at + i;
            if (s->part.wheres && cases_within(&j->request->system, part, &s->part))
                return true;
        }
    return false;
}

static void remove_part(struct cases *c, int i)
{
    assert(i >= 0 && i < c->parts);
    cases_part_clear(c->part + i);
    memmove(c->part + i, c->part + i + 1, (size_t)(c->parts - i - 1) * sizeof *c->part);
    c->parts--;
}

void strata_join(struct listing *l, struct cases_part *part)
{
    assert(part->wheres > 0);                 /* conditions say which parameters are meant */
    const struct sys_system *sys = &l->j->request->system;
    struct cases *c = l->cases;
    bool known = ruled_out(l->j, part);
    for (int i = 0; i < c->parts && !known; i++)
        known = cases_within(sys, part, c->part + i);
    if (known || c->parts >= SGA_MOST_PARAMETER_CASES) {
        c->cut |= !known;
        cases_part_clear(part);
        return;
    }
    for (int i = c->parts - 1; i >= 0; i--)
        if (cases_within(sys, c->part + i, part))
            remove_part(c, i);
    c->part = sga_realloc(c->part, ((size_t)c->parts + 1) * sizeof *c->part);
    c->part[c->parts++] = *part;
    assert(c->parts <= SGA_MOST_PARAMETER_CASES);
    *part = (struct cases_part){ 0 };
}

void strata_condition(struct listing *l, const expr_id *function, int functions)
{
    struct job *j = l->j;
    struct cases found;
    const struct cases_part *above = j->place.part;
    cases_of(&j->request->system, function, functions, above ? above->excluded : NULL, above ? above->excludeds : 0, j->budget, &found);
    for (int i = 0; i < found.parts; i++)
        strata_join(l, found.part + i);
    l->cases->cut |= found.cut;
    cases_clear(&found);
}

/* What vanishes on the part alone. */
static expr_id assumption(struct expr_store *st, const struct cases_part *p)
{
    if (p->root || p->wheres == 1)
        return p->root ? p->root : p->where[0];
    expr_id e = expr_powi(st, p->where[0], 2);
    for (int i = 1; i < p->wheres; i++)
        e = expr_add(st, e, expr_powi(st, p->where[i], 2));
    return e;
}

void strata_assume(struct job *j, expr_id e)
{
    for (int i = 0; i < j->place.not_zeros; i++)
        if (j->place.not_zero[i] == e)
            return;
    j->place.not_zero = sga_realloc(j->place.not_zero, ((size_t)j->place.not_zeros + 1) * sizeof *j->place.not_zero);
    j->place.not_zero[j->place.not_zeros++] = e;
}

void strata_cases(struct listing *l)
{
    struct job *j = l->j;
    struct cases *c = l->cases;
    if (c->cut)
        sga_limit_met(j->budget, SGA_LIMIT_PARAMETER_CASES);
    for (int i = 0; i < c->parts; i++) {
        struct cases_part *p = c->part + i;
        expr_id e = assumption(&j->request->store, p);
        if (strata_add_case(j, p))
            strata_assume(j, e);
    }
    c->parts = 0;
}
