/* Tangency rows, and which velocities are determined. */
#include "mem.h"
#include "state.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "reduction.h"
#include "system.h"

static long factorial(int n)
{
    long f = 1;
    while (n > 1)
        f *= n--;
    return f;
}

/* D_0 of constraint i. Where the whole constraint flows along determined velocities it is
 * the next Taylor coefficient of what the chain of constraints began with. */
static expr_id derivative(struct state *s, const struct sga_constraint *c, expr_id *base, int *order)
{
    *base = c->base;
    *order = c->order + 1;
    if (expr_flow_tainted(s->flow, c->expr) || c->order + 1 > 18) {
        *base = c->expr;
        *order = 1;
    }
    expr_id d = expr_flow_coefficient(s->flow, *base, *order);
    return expr_mul(s->st, expr_int(s->st, factorial(*order)), d);
}

void state_open_columns(struct state *s)
{
    SGA_RESERVE_IN(&s->mem, s->open, s->open_cap, s->st->symbols);
    memset(s->open, 0, (size_t)s->st->symbols);
    for (int j = 0; j < s->sys->variables; j++)
        s->open[s->variable[j]] = !s->determined[j];
}

void state_tangency(struct state *s, int i, struct ech_row *row)
{
    assert(i >= 0 && i < s->sol->constraints);
    *row = (struct ech_row){ .source = s->sys->rows + i };
    const struct sga_constraint *c = s->sol->constraint + i;
    expr_id base;
    int order;
    row->rhs = expr_neg(s->st, derivative(s, c, &base, &order));
    if (!expr_flow_tainted(s->flow, c->expr))
        return;
    assert(s->open_cap >= (size_t)s->st->symbols);
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    int n = expr_gradient(s->st, &s->cone, c->expr, s->open, &term, &cap);
    for (int k = 0; k < n; k++)
        ech_row_push(row, s->column[term[k].symbol], term[k].value);
}

/* What made the velocity's row, kept for whoever asks how it was found. */
static void keep_rate(struct state *s, const struct ech_pivot *p, expr_id value, int generation)
{
    struct sga_solution *sol = s->sol;
    if (!s->options->rates)
        return;
    SGA_RESERVE(sol->rate, s->rate_cap, sol->rates + 1);
    struct sga_rate *r = sol->rate + sol->rates++;
    *r = (struct sga_rate){ .variable = p->col, .generation = generation, .epoch = s->epoch, .value = value };
    state_combine_pivot(s, (int)(p - s->ech.pivot), &r->part, &r->parts);
}

void state_determine(struct state *s, int generation)
{
    bool changed = true;
    while (changed) {       /* later pivots first; a second round finds nothing as a rule */
        changed = false;
        for (int q = s->ech.pivots - 1; q >= 0; q--) {
            const struct ech_pivot *p = s->ech.pivot + q;
            if (s->determined[p->col])
                continue;
            bool all = true;
            for (int k = 0; k < p->row.entries && all; k++)
                all = p->row.entry[k].col == p->col || s->determined[p->row.entry[k].col];
            if (!all)
                continue;
            expr_id x = p->row.rhs;
            for (int k = 0; k < p->row.entries; k++)
                if (p->row.entry[k].col != p->col)
                    x = expr_sub(s->st, x, expr_mul(s->st, p->row.entry[k].value,
                                                    s->flow->velocity[s->variable[p->row.entry[k].col]]));
            x = expr_div(s->st, x, p->value);
            keep_rate(s, p, x, generation);
            expr_flow_determine(s->flow, s->variable[p->col], x);
            s->determined[p->col] = 1;
            changed = true;
        }
    }
}
