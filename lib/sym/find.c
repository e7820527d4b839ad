/* The stages in their order. */
#include <stdlib.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "mem.h"
#include "oracle.h"
#include "reduction.h"
#include "sym_work.h"
#include "system.h"
#include "warnings.h"

/* [K_i, K_j] in K on Pf. */
static enum sym_truth gauge_closed(struct sym_work *w)
{
    enum sym_truth all = SYM_TRUE;
    expr_id defect;
    SGA_FREED expr_id *v = sga_malloc(((size_t)w->n + 1) * sizeof *v);
    if (w->gauges > SGA_MOST_GAUGE_CLOSED) {
        all = SYM_UNKNOWN;
        sga_limit_met(w->budget, SGA_LIMIT_GAUGE_CLOSED);
    }
    for (int i = 0; i < w->gauges && all != SYM_FALSE && w->gauges <= SGA_MOST_GAUGE_CLOSED; i++)
        for (int j = i + 1; j < w->gauges && all != SYM_FALSE; j++) {
            sym_bracket(w, w->gauge + (size_t)i * (size_t)(w->n + 1), w->gauge + (size_t)j * (size_t)(w->n + 1), v);
            sym_modulo_gauge(w, w->gauge, v);
            all = sym_and(all, sym_all_zero(w, v, w->n, &defect));
        }
    return all;
}

/* Tables are listed among them, and do not enter what is looked at. */
static bool has_parameters(const struct sys_system *sys)
{
    for (int i = 0; i < sys->parameters; i++)
        if (sys->store->symbol[sys->parameter[i]].kind == EXPR_PARAMETER)
            return true;
    return false;
}

static void judge(const struct sym_work *w, struct sym_evidence *e)
{
    if (!e->why_not && has_parameters(w->sys))
        e->why_not = "coefficients that depend on the symbolic parameters were not searched";
    if (!e->why_not && e->dropped)
        e->why_not = "some candidates were not confirmed";
    if (!e->why_not && e->kernels)
        e->why_not = "functions that are not algebraic were taken as independent of each other";
    e->complete = !e->why_not;
}

bool sym_find(struct sym_work *w, const struct sym_request *request, struct sym_result *out, struct sga_error *err)
{
    *out = (struct sym_result){ 0 };
    sym_presymplectic(w, out);
    out->gauge_closed = gauge_closed(w);
    bool ok = true;
    if (request->has_search && w->sol->field && w->oracle->reals) {
        ok = sym_search_fields(w, &request->search, out, err) && sym_search_integrals(w, &request->search, out, err)
             && sym_commutators(w, out, err) && ((out->closed != SYM_TRUE && !request->form) || sym_noether(w, request, out, err));
    } else if (request->has_search) {
        out->of_fields.why_not = out->of_integrals.why_not = "there is no point of the final set to work at";
    }
    judge(w, &out->of_fields);
    judge(w, &out->of_integrals);
    if (ok && !expr_store_ok(w->st)) {
        *err = *w->st->error;
        return false;
    }
    return ok && sga_budget_ok(w->budget, err);
}

void sym_clear(struct sym_result *r)
{
    for (int k = 0; k < r->fields; k++)
        free(r->field[k].component);
    for (int k = 0; k < r->commutators; k++)
        free(r->commutator[k].factor);
    free(r->field);
    free(r->commutator);
    free(r->integral);
    for (int k = 0; k < r->noethers; k++)
        free(r->noether[k].component);
    free(r->noether);
    *r = (struct sym_result){ 0 };
}
