/* Factors of combinations, divided by what the printed function was divided by. */
#include "printed_parts.h"

#include <assert.h>

#include "error.h"
#include "job_texts.h"
#include "oracle.h"
#include "poly.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"

expr_id printed_normal(struct job *j, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_SHOWN, NULL);
    expr_id normal = e;
    limits.budget = j->budget;
    return poly_normal(&j->request->store, e, &limits, &normal) ? normal : e;
}

expr_id printed_factor(struct job *j, const struct sga_part *part, bool minus, expr_id divisor)
{
    struct expr_store *st = &j->request->store;
    expr_id scale = part->row < 0 && j->texts && j->texts->scale ? j->texts->scale[part->tangency] : EXPR_UNDEF, e = minus ? expr_neg(st, part->factor) : part->factor;
    if (!scale && !divisor)
        return e;
    if (scale)
        e = expr_mul(st, e, scale);
    if (divisor)
        e = expr_div(st, e, divisor);
    return printed_normal(j, e);
}

/* e = *number times what is returned. */
static expr_id without_number(const struct expr_store *st, expr_id e, fmpq_t number)
{
    fmpq_one(number);
    for (;;) {
        const struct expr_node n = st->node[e];
        if (n.op == EXPR_NEG)
            fmpq_neg(number, number);
        else if (n.op == EXPR_MUL && expr_is_const(st, n.a))
            fmpq_mul(number, number, expr_const_value(st, n.a));
        else
            return e;
        e = n.op == EXPR_NEG ? n.a : n.b;
    }
}

/* x / y where that is seen to be a number; otherwise EXPR_UNDEF. */
static expr_id plain_quotient(struct expr_store *st, expr_id x, expr_id y)
{
    fmpq_t p, q;
    fmpq_init(p);
    fmpq_init(q);
    expr_id a = without_number(st, x, p), b = without_number(st, y, q), e = EXPR_UNDEF;
    bool same = a == b, turned = !same && st->node[a].op == EXPR_SUB && st->node[b].op == EXPR_SUB
         && st->node[a].a == st->node[b].b && st->node[a].b == st->node[b].a;
    if ((same || turned) && !fmpq_is_zero(q)) {
        fmpq_div(p, p, q);
        if (turned)
            fmpq_neg(p, p);
        e = expr_fmpq(st, p);
    }
    fmpq_clear(p);
    fmpq_clear(q);
    return e;
}

/* What arose is so many times the function that took its place, and that is never 0 on the set; EXPR_UNDEF: it is not known to be. */
static expr_id times_replaced(struct job *j, const struct sga_constraint *c)
{
    struct expr_store *st = &j->request->store;
    struct sga_error before = *st->error;
    expr_id plain = plain_quotient(st, c->replaced, c->expr);
    if (plain)
        return plain;
    expr_id q = expr_div(st, c->replaced, c->expr), normal = EXPR_UNDEF;
    struct poly_limits limits = poly_limits_of(POLY_SHOWN, NULL);
    limits.budget = j->budget;
    bool ok = q && poly_normal(st, q, &limits, &normal)
              && (expr_is_const(st, normal) ? !expr_is_zero(st, normal)
                  : j->oracle->reals && points_oracle_zero(j->oracle, normal).basis == POINTS_NONZERO_PROVED);
    *st->error = before;
    return ok ? normal : EXPR_UNDEF;
}

struct printed_sum printed_sum(struct job *j, int constraint)
{
    assert(constraint >= 0 && constraint < j->solution->constraints);
    const struct sga_constraint *c = j->solution->constraint + constraint;
    expr_id scale = j->texts && j->texts->scale ? j->texts->scale[constraint] : EXPR_UNDEF, times = c->replaced ? times_replaced(j, c) : EXPR_UNDEF;
    bool stands_for = c->replaced && !times;
    return (struct printed_sum){ stands_for ? EXPR_UNDEF : !times ? scale : !scale ? times : expr_mul(&j->request->store, times, scale), stands_for };
}
