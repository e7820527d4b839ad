/* Symmetries of systems that have known ones: fields and maps that are, that are not, and that move no solution; searches find all of
 * an ansatz, and what they find passes the check. */
#include "error.h"
#include "model.h"
#include "oracle.h"
#include "points.h"
#include "sym.h"
#include "system.h"

static const struct model_text oscillator = { "x y", "", { { "x:1", "y" }, { "y:1", "-x" } }, { 0 } };
static const struct model_text circle = { "x y z", "", { { "x:1", "y*z" }, { "y:1", "-x*z" }, { "", "z - x^2 - y^2" } }, { 0 } };
static const struct model_text loose = { "x y", "", { { "x:1", "x" } }, { 0 } };

struct asked { const struct model_text *text; const char *component[4]; bool map; enum sym_truth symmetry, gauge; };

static const struct asked all[] = {
    { &oscillator, { "y", "-x", "0" }, false, SYM_TRUE, SYM_FALSE },          /* along the motion */
    { &oscillator, { "x", "y", "0" }, false, SYM_TRUE, SYM_FALSE },           /* linear */
    { &oscillator, { "x", "0", "0" }, false, SYM_FALSE, SYM_FALSE },
    { &oscillator, { "0", "0", "1" }, false, SYM_TRUE, SYM_FALSE },           /* autonomous */
    { &oscillator, { "2*x", "2*y", "t" }, true, SYM_TRUE, SYM_UNKNOWN },
    { &oscillator, { "y", "x", "t" }, true, SYM_FALSE, SYM_UNKNOWN },
    { &oscillator, { "x", "-y", "-t" }, true, SYM_TRUE, SYM_UNKNOWN },        /* back in time */
    { &circle, { "y", "-x", "0", "0" }, false, SYM_TRUE, SYM_FALSE },
    { &circle, { "x", "y", "2*z", "0" }, false, SYM_FALSE, SYM_FALSE },       /* faster farther out */
    { &circle, { "x", "y", "2*z", "-2*t" }, false, SYM_TRUE, SYM_FALSE },
    { &circle, { "x", "y", "z", "0" }, false, SYM_FALSE, SYM_FALSE },         /* not tangent */
    { &loose, { "0", "x*y^3 + 1", "0" }, false, SYM_TRUE, SYM_TRUE },
    { &loose, { "y", "0", "0" }, false, SYM_FALSE, SYM_FALSE },
};

static void ask(const struct asked *a)
{
    struct model m;
    struct sym_check r = { 0 };
    expr_id component[4];
    model_begin(&m, a->text, NULL, NULL);
    CHECK(model_reduce(&m, NULL), "%s", m.err.detail);
    struct sym_work *w = sym_new(&m.sys, &m.sol, &m.oracle, &m.budget, false);
    for (int j = 0; j <= m.sys.variables; j++)
        component[j] = model_read(&m, a->component[j]);
    (a->map ? sym_check_map : sym_check_field)(w, component, &r);
    CHECK(r.symmetry == a->symmetry, "%s, %s: %d", a->component[0], a->component[1], r.symmetry);
    CHECK(a->map || r.gauge == a->gauge, "%s, %s: gauge %d", a->component[0], a->component[1], r.gauge);
    CHECK((r.symmetry == SYM_FALSE) == (r.defects > 0), "%s: a defect says why", a->component[0]);
    sym_free(w);
    model_end(&m);
}

/* Linear fields that commute with the oscillator's: the two-dimensional algebra of x d/dx + y d/dy and the field itself. */
static void search(void)
{
    struct model m;
    struct sym_result found = { 0 };
    struct sga_error err = { 0 };
    struct sym_request request = { .has_search = true, .search = { .degree = 1, .integral_degree = 2 } };
    model_begin(&m, &oscillator, NULL, NULL);
    CHECK(model_reduce(&m, NULL), "%s", m.err.detail);
    struct sym_work *w = sym_new(&m.sys, &m.sol, &m.oracle, &m.budget, false);
    CHECK(sym_find(w, &request, &found, &err), "%s", err.detail);
    CHECK(found.fields == 2 && found.of_fields.complete, "%d fields", found.fields);
    CHECK(found.integrals == 1 && model_zero(&m, expr_sub(&m.st, found.integral[0], model_read(&m, "x^2 + y^2"))), "%d integrals", found.integrals);
    for (int i = 0; i < found.fields; i++) {
        struct sym_check r = { 0 };
        sym_check_field(w, found.field[i].component, &r);
        CHECK(r.symmetry == SYM_TRUE, "what is found is one");
    }
    for (int i = 0; i < found.commutators; i++)
        CHECK(found.commutator[i].closed, "they commute within their span");
    sym_clear(&found);
    sym_free(w);
    model_end(&m);
}

int main(void)
{
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        ask(all + i);
    search();
    flint_cleanup();
    return CHECK_END();
}
