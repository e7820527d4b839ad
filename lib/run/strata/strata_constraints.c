/* Functions that are constraints: these are found by what they contain. */
#include "strata_listing.h"

#include <stdlib.h>

#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"

/* The constraints of the first generation, by symbol: which contain it. */
struct strata_constraints {
    int symbols;
    int *first;                /* by symbol: where its list begins; the last one's end */
    int *containing;           /* these lists, one after the other */
    int *mark, round;          /* by symbol: the last question that contained it */
    struct expr_cone cone;
};

static bool is_symbol(const struct expr_store *st, expr_id e)
{
    return st->node[e].op == EXPR_SYM;
}

/* Adds constraint i to the lists of what it contains, each of which ends at upto; NULL: counts only, in first. */
static void enter(struct strata_constraints *k, const struct expr_store *st, expr_id e, int i, int *upto)
{
    expr_cone_of(st, &k->cone, &e, 1);
    for (int m = 0; m < k->cone.count; m++)
        if (is_symbol(st, k->cone.list[m])) {
            int symbol = st->node[k->cone.list[m]].a;
            if (upto)
                k->containing[upto[symbol]++] = i;
            else
                k->first[symbol + 1]++;
        }
}

static struct strata_constraints *make(const struct job *j)
{
    const struct expr_store *st = &j->request->store;
    const struct sga_solution *sol = j->solution;
    struct strata_constraints *k = sga_calloc(1, sizeof *k);
    int count = 0, n = k->symbols = st->symbols;
    expr_cone_init(&k->cone);
    while (count < sol->constraints && sol->constraint[count].generation == 1)
        count++;
    k->first = sga_calloc((size_t)n + 1, sizeof *k->first);
    k->mark = sga_calloc((size_t)n + 1, sizeof *k->mark);
    for (int i = 0; i < count; i++)
        enter(k, st, sol->constraint[i].expr, i, NULL);
    for (int i = 0; i < n; i++)
        k->first[i + 1] += k->first[i];
    k->containing = sga_malloc(((size_t)k->first[n] + 1) * sizeof *k->containing);
    SGA_FREED int *upto = sga_malloc(((size_t)n + 1) * sizeof *upto);
    for (int i = 0; i < n; i++)
        upto[i] = k->first[i];
    for (int i = 0; i < count; i++)
        enter(k, st, sol->constraint[i].expr, i, upto);
    return k;
}

void strata_constraints_free(struct strata_constraints *k)
{
    if (!k)
        return;
    expr_cone_clear(&k->cone);
    free(k->first);
    free(k->containing);
    free(k->mark);
    free(k);
}

/* Marks the symbols of e. Returns the one that the fewest constraints contain, and how many there are; -1: one is in none, or there are none. */
static int rarest(struct strata_constraints *k, const struct expr_store *st, expr_id e, int *symbols)
{
    int best = -1;
    k->round++;
    *symbols = 0;
    expr_cone_of(st, &k->cone, &e, 1);
    for (int m = 0; m < k->cone.count; m++) {
        if (!is_symbol(st, k->cone.list[m]))
            continue;
        int symbol = st->node[k->cone.list[m]].a;
        if (symbol >= k->symbols || k->first[symbol] == k->first[symbol + 1])
            return -1;
        k->mark[symbol] = k->round;
        ++*symbols;
        if (best < 0 || k->first[symbol + 1] - k->first[symbol] < k->first[best + 1] - k->first[best])
            best = symbol;
    }
    return best;
}

/* Whether e contains the marked symbols, all of them and no others. */
static bool has_marked(struct strata_constraints *k, const struct expr_store *st, expr_id e, int symbols)
{
    expr_cone_of(st, &k->cone, &e, 1);
    for (int m = 0; m < k->cone.count; m++)
        if (is_symbol(st, k->cone.list[m]) && (k->mark[st->node[k->cone.list[m]].a] != k->round || !symbols--))
            return false;
    return symbols == 0;
}

bool strata_is_constraint(struct job *j, expr_id e)
{
    struct expr_store *st = &j->request->store;
    struct poly_limits limits = poly_limits_of(POLY_GLANCE, j->budget);
    if (!j->strata.constraints)
        j->strata.constraints = make(j);
    struct strata_constraints *k = j->strata.constraints;
    int symbols, symbol = rarest(k, st, e, &symbols);
    for (int i = symbol < 0 ? 0 : k->first[symbol]; symbol >= 0 && i < k->first[symbol + 1] && j->strata.compared <= st->nodes; i++) {
        expr_id c = j->solution->constraint[k->containing[i]].expr;
        bool like = has_marked(k, st, c, symbols);
        j->strata.compared += k->cone.count;
        if (like && (poly_is_zero(st, expr_sub(st, e, c), &limits) == POLY_YES || poly_is_zero(st, expr_add(st, e, c), &limits) == POLY_YES))
            return true;
    }
    return false;
}
