/* The witness: right claims pass at fresh points, claims that are spoilt in any part do not. */
#include "error.h"
#include "model.h"
#include "oracle.h"
#include "points.h"
#include "system.h"
#include "witness.h"

static const struct model_text systems[] = {
    { "x y l u v", "g", { { "x:1", "u" }, { "y:1", "v" }, { "u:1", "-l*x" }, { "v:1", "-l*y - g" }, { "", "x^2 + y^2 - 1" } }, { 0 } },
    { "x y z", "", { { "x:1; y:1", "z" }, { "", "z - x*y" } }, { 0 } },
    { "x y z w", "k", { { "x:1", "sin(y) + t" }, { "y:z; w:1", "k*x" }, { "", "z - exp(x)" } }, { "w - x*y" } },
};

struct spoilt {
    struct sga_claim claim;
    expr_id *constraint, *field, *gauge;
};

static void claim_of(struct model *m, int *variable, struct spoilt *s)
{
    size_t n = (size_t)m->sys.variables, c = (size_t)m->sol.constraints, g = (size_t)m->sol.free_columns;
    for (size_t j = 0; j < n; j++)
        variable[j] = m->sys.variable[j].symbol;
    s->constraint = malloc((c + 1) * sizeof *s->constraint);
    for (size_t i = 0; i < c; i++)
        s->constraint[i] = m->sol.constraint[i].expr;
    s->field = memcpy(malloc((n + 1) * sizeof *s->field), m->sol.field, n * sizeof *s->field);
    s->gauge = malloc((n * g + 1) * sizeof *s->gauge);
    if (g)
        memcpy(s->gauge, m->sol.gauge, n * g * sizeof *s->gauge);
    s->claim = (struct sga_claim){
        .st = &m->st, .variable = variable, .variables = (int)n, .parameter = m->sys.parameter, .parameters = m->sys.parameters, .time = m->sys.time,
        .constraint = s->constraint, .constraints = (int)c, .solution = &m->sol, .field = s->field, .gauge = s->gauge, .gauges = (int)g };
}

static bool passes(struct model *m, const struct spoilt *s, struct sga_witness *result)
{
    struct sga_error err = { 0 };
    bool ok = sga_witness_check(&m->sys, &s->claim, &m->oracle, NULL, 0, 99, 4, &m->budget, result, &err);
    CHECK(ok || err.code == SGA_E_WITNESS || err.code == SGA_E_UNDECIDED, "%s", err.detail);
    return ok;
}

static void check(const struct model_text *t)
{
    struct model m;
    struct sga_witness w;
    struct spoilt s;
    int variable[MODEL_VARIABLES];
    model_begin(&m, t, NULL, NULL);
    CHECK(model_reduce(&m, NULL), "%s", m.err.detail);
    claim_of(&m, variable, &s);
    CHECK(passes(&m, &s, &w) && w.points >= 4 && w.certified && w.digits > 30, "%d points, %d digits", w.points, w.digits);
    expr_id x = m.st.symbol[variable[0]].node, one = expr_int(&m.st, 1);
    for (int j = 0; j < m.sys.variables; j++) {
        expr_id was = s.field[j];
        bool tied = false;         /* a component that no equation and no constraint has may be anything */
        for (int i = 0; i < m.sys.rows && !tied; i++)
            for (int k = 0; k < m.sys.row[i].entries; k++)
                tied |= m.sys.row[i].entry[k].col == j;
        s.field[j] = expr_add(&m.st, was, expr_div(&m.st, one, expr_int(&m.st, 1000000)));
        CHECK(!tied || !passes(&m, &s, &w), "component %d may not be off by 1e-6", j);
        s.field[j] = was;
    }
    for (int i = 0; i < m.sol.constraints; i++) {
        expr_id was = s.constraint[i];
        s.constraint[i] = expr_sub(&m.st, was, expr_div(&m.st, expr_mul(&m.st, x, x), expr_int(&m.st, 1000)));
        CHECK(!passes(&m, &s, &w), "constraint %d is another one", i);
        s.constraint[i] = was;
    }
    for (int k = 0; k < s.claim.gauges * m.sys.variables; k++) {
        expr_id was = s.gauge[k];
        s.gauge[k] = expr_add(&m.st, was, one);
        CHECK(!passes(&m, &s, &w), "gauge component %d is another one", k);
        s.gauge[k] = was;
    }
    if (m.sol.constraints > 1) {           /* one that follows from another is none of its own */
        expr_id was = s.constraint[1];
        s.constraint[1] = expr_mul(&m.st, s.constraint[0], expr_add(&m.st, one, expr_mul(&m.st, x, x)));
        CHECK(!passes(&m, &s, &w), "constraints that depend on each other");
        s.constraint[1] = was;
    }
    free(s.constraint);
    free(s.field);
    free(s.gauge);
    model_end(&m);
}

int main(void)
{
    for (size_t i = 0; i < sizeof systems / sizeof *systems; i++)
        check(systems + i);
    flint_cleanup();
    return CHECK_END();
}
