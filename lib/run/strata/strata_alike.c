/* Cases of parameters in which nothing changes. What is divided by on the way depends on which pivots and variables were chosen,
 * and so on the order of equations: at a = 0 another choice does. Where the system with the case put in has an answer of the same
 * shape, and what is printed has a value there, the general answer holds; its own conditions there are looked at in its place. */
#include "strata_listing.h"

#include <stdlib.h>
#include <string.h>

#include "cases.h"
#include "error.h"
#include "job_texts.h"
#include "mem.h"
#include "oracle.h"
#include "poly.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "seeds.h"
#include "strata_case.h"
#include "stratum.h"
#include "texts.h"

/* Whether everything that is printed has a value at the part: read from the texts, as their divisors are not those of the reduction. */
static bool printed(struct job *j, const struct cases_part *part)
{
    struct expr_store *st = &j->request->store;
    bool ok = j->texts->names.count == 0;
    for (int i = 0; i < j->texts->names.roots && ok; i++) {
        expr_id e = answer_text_read(j, j->texts->names.root[i]);
        ok = e && cases_at(st, e, part->put, part->puts);
    }
    return ok;
}

/* Constraints that regular ones had to take the place of. */
static int replacements(const struct sga_solution *sol)
{
    int n = 0;
    for (int i = 0; i < sol->constraints; i++)
        n += sol->constraint[i].replaced != EXPR_UNDEF;
    return n;
}

/* Of the same verdict and dimensions, and no constraint falls into factors or becomes irregular that did not in general. */
static bool same_shape(const struct sga_solution *a, const struct sga_solution *b)
{
    if (a->verdict == SGA_INCONSISTENT && b->verdict == SGA_INCONSISTENT)
        return a->specials == b->specials;
    if (a->verdict != b->verdict || a->branches != b->branches || replacements(a) != replacements(b))
        return false;
    if (a->generations != b->generations || a->free_columns != b->free_columns || a->specials != b->specials)
        return false;
    return a->generations == 0 || memcmp(a->dimension, b->dimension, (size_t)a->generations * sizeof *a->dimension) == 0;
}

static void append(expr_id **list, int *count, const expr_id *more, int n)
{
    *list = sga_realloc(*list, ((size_t)(*count + n) + 1) * sizeof **list);
    for (int i = 0; i < n; i++)
        (*list)[(*count)++] = more[i];
}

/* The part `inner` of the system with `outer` put in, as a part of the whole. */
static bool composed(struct job *j, const struct cases_part *outer, struct cases_part *inner)
{
    struct expr_store *st = &j->request->store;
    struct poly_limits limits = poly_limits_of(POLY_MODEST, j->budget);
    struct cases_part to = cases_copy(outer);
    bool ok = true;
    append(&to.where, &to.wheres, inner->where, inner->wheres);
    append(&to.excluded, &to.excludeds, inner->excluded, inner->excludeds);
    for (int i = 0; i < to.puts && ok; i++) {
        expr_id e = cases_at(st, to.put[i].value, inner->put, inner->puts);
        ok = e && expr_store_ok(st);
        to.put[i].value = e && poly_normal(st, e, &limits, &e) ? e : e;
    }
    to.put = sga_realloc(to.put, (size_t)(to.puts + inner->puts + 1) * sizeof *to.put);
    for (int i = 0; i < inner->puts; i++)
        to.put[to.puts++] = inner->put[i];
    to.open = inner->open;
    to.root = EXPR_UNDEF;
    cases_part_clear(inner);
    *inner = to;
    return ok;
}

/* The conditions of the system at the part join the list, as parts of the whole. */
static void descend(struct listing *l, const struct cases_part *part, const struct sys_system *system, const struct sga_solution *sol)
{
    struct job *j = l->j;
    for (int i = 0; i < sol->conditions.count; i++) {
        struct cases found;
        cases_of(system, sol->conditions.at[i].function, sol->conditions.at[i].functions, part->excluded, part->excludeds, j->budget, &found);
        for (int k = 0; k < found.parts; k++)
            if (composed(j, part, found.part + k))
                strata_join(l, found.part + k);
        l->cases->cut |= found.cut;
        cases_clear(&found);
    }
}

/* Whether the general answer holds at the part too; then its own conditions have joined the list. */
static bool alike(struct listing *l, const struct cases_part *part)
{
    struct job *j = l->j;
    struct stratum as = { .kind = "parameter", .part = *part };
    struct strata_case at;
    struct sga_error err = { 0 }, *own = j->request->store.error, before = *own;
    if (!part->puts || part->open || !printed(j, part) || !strata_case_make(&at, &j->request->system, NULL, &as, &err))
        return false;
    struct reduction_options options = { .seed = SGA_SEED_REDUCTION, .budget = j->budget };
    struct points_oracle oracle;
    struct sga_solution sol = { 0 };
    points_oracle_init(&oracle, 20250101);
    bool same = expr_store_ok(&j->request->store) && sga_reduce(&at.system, &options, &oracle, &sol, &err) && same_shape(j->solution, &sol);
    if (same)
        descend(l, part, &at.system, &sol);
    sga_solution_clear(&sol);
    points_oracle_clear(&oracle);
    strata_case_clear(&at);
    if (own->code == SGA_E_EXPR_UNDEFINED)      /* what is given has no value there */
        *own = before;
    return same;
}

void strata_alike(struct listing *l)
{
    enum { MOST = 200, MOST_VARIABLES = 60 };      /* past which a reduction for each would cost too much: all of them are listed */
    struct job *j = l->j;
    if (!j->request->strata || j->request->mechanical || j->start.x || j->request->system.variables > MOST_VARIABLES)
        return;
    struct cases kept = { .part = NULL };
    for (int tries = 0; l->cases->parts && job_has_left(j) && tries < MOST; tries++) {
        struct cases_part part = l->cases->part[0];
        l->cases->parts--;
        memmove(l->cases->part, l->cases->part + 1, (size_t)l->cases->parts * sizeof part);
        if (alike(l, &part)) {
            cases_part_clear(&part);
            continue;
        }
        kept.part = sga_realloc(kept.part, ((size_t)kept.parts + 1) * sizeof *kept.part);
        kept.part[kept.parts++] = part;
    }
    for (int i = 0; i < kept.parts; i++)
        strata_join(l, kept.part + i);
    free(kept.part);
}
