/* Conditions on the fibre, the parts of the acceleration and where the rank drops, at points. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "ball.h"
#include "check.h"
#include "error.h"
#include "form.h"
#include "mech.h"
#include "oracle.h"
#include "parse.h"
#include "points.h"
#include "reduction.h"

static struct expr_store st;
static struct sys_system s;
static struct form_mechanical in;

static expr_id velocity_of(void *ctx, int symbol, int order)
{
    (void)ctx;
    char name[32];
    snprintf(name, sizeof name, "%s'", st.symbol[symbol].name);
    int k = expr_symbol_find(&st, name, strlen(name));
    return order == 1 && k >= 0 ? st.symbol[k].node : EXPR_UNDEF;
}

static expr_id parse(const char *text)
{
    struct expr_grammar g = { .derivative = velocity_of, .max_length = 1000, .max_depth = 100, .max_exponent = 100, .max_digits = 100 };
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, &g, &err);
    CHECK(e != EXPR_UNDEF);
    return e;
}

static int add(const char *name, enum expr_symbol_kind kind)
{
    expr_symbol_add(&st, name, kind);
    return expr_symbol_find(&st, name, strlen(name));
}

/* Two coordinates x, y of mass 1 and 2. */
static void begin(const char *const *force, const char *const *constraint, int constraints)
{
    static const char *const names[] = { "x", "y" }, *const speeds[] = { "x'", "y'" };
    expr_store_init(&st);
    sys_init(&s, &st);
    s.time = add("t", EXPR_TIME);
    in = (struct form_mechanical){ .coordinates = 2, .constraints = constraints, .masses = 2 };
    in.coordinate = calloc(2, sizeof(int));
    in.velocity = calloc(2, sizeof(int));
    in.mass = calloc(2, sizeof *in.mass);
    in.force = calloc(2, sizeof *in.force);
    in.constraint = calloc((size_t)constraints + 1, sizeof *in.constraint);
    for (int i = 0; i < 2; i++) {
        in.coordinate[i] = add(names[i], EXPR_VARIABLE);
        in.velocity[i] = add(speeds[i], EXPR_VARIABLE);
        in.mass[i] = (struct form_entry){ i, i, expr_int(&st, i + 1) };
    }
    for (int i = 0; i < 2; i++)
        in.force[i] = parse(force[i]);
    for (int i = 0; i < constraints; i++)
        in.constraint[i] = parse(constraint[i]);
}

static void end(void)
{
    free(in.coordinate);
    free(in.velocity);
    free(in.mass);
    free(in.force);
    free(in.constraint);
    sys_clear(&s);
    expr_store_clear(&st);
}

static double at(struct mech_fibre *f, expr_id e)
{
    struct num_ball *b = &f->oracle->real[0].ball;
    num_ball_extend(b);
    return arf_get_d(arb_midref(num_ball_value(b, e)), ARF_RND_NEAR);
}

static void check_one(const char *const *force, const char *const *constraint, int constraints, int rank, int redundants, bool own,
                bool full)
{
    struct mech_fibre f;
    struct mech_motion m;
    struct mech_regularity r;
    struct sga_budget budget = { .max_generations = 20 };
    struct reduction_options options = { .seed = 1, .budget = &budget };
    struct sga_error err = { 0 };
    begin(force, constraint, constraints);
    CHECK(mech_fibre_find(&f, &s, &in, &options, &err));
    CHECK(f.conditions == rank && f.redundants == redundants && f.own == own);
    mech_motion_find(&m, &f, &in);
    for (int j = 0; j < 2; j++) {
        CHECK(fabs(at(&f, m.total[j]) - at(&f, m.tangent[j]) - at(&f, m.orthogonal[j])) < 1e-12);
        CHECK(fabs((j + 1) * at(&f, m.total[j]) - at(&f, in.force[j]) - at(&f, m.reaction[j])) < 1e-12);
    }
    for (int i = 0; i < f.conditions; i++) {
        double h0 = at(&f, f.H[2 * i]), h1 = at(&f, f.H[2 * i + 1]);
        CHECK(fabs(h0 * at(&f, m.total[0]) + h1 * at(&f, m.total[1]) + at(&f, f.rate[i])) < 1e-10);
        CHECK(fabs(h0 * at(&f, m.tangent[0]) + h1 * at(&f, m.tangent[1])) < 1e-10);
        CHECK(rank > 1 || fabs(h1 * at(&f, m.reaction[0]) - h0 * at(&f, m.reaction[1])) < 1e-10);
    }
    mech_regularity_find(&r, &f, &in, &options);
    CHECK((r.full == MECH_FULL_PROVED || r.full == MECH_FULL_SEARCHED) == full);
    CHECK(full || r.rank < rank);
    mech_regularity_clear(&r);
    mech_motion_clear(&m);
    mech_fibre_clear(&f);
    end();
}

int main(void)
{
    const char *const none[] = { "0", "0" }, *const force[] = { "y", "-x*x'" };
    const char *const circle[] = { "x^2+y^2-1", "x*x'+y*y'", "3*(x^2+y^2-1)" };
    const char *const square[] = { "(x^2+y^2-1)^2" }, *const speed[] = { "x'^2+y'^2-1" }, *const cube[] = { "(x'+y'-1)^3-x" };
    const char *const rest[] = { "x'^2+y'^2" }, *const sum[] = { "x'+y'", "x'+y'+x-1" };
    check_one(none, circle, 1, 1, 0, true, true);
    check_one(force, circle, 1, 1, 0, true, true);
    check_one(force, circle, 3, 1, 2, true, true);
    check_one(force, square, 1, 1, 0, false, true);
    check_one(force, speed, 1, 1, 0, true, true);
    check_one(force, cube, 1, 1, 0, true, false);
    check_one(force, rest, 1, 2, 0, false, true);
    check_one(force, sum, 2, 2, 0, false, true);
    check_one(force, sum, 0, 0, 0, true, true);
    return CHECK_END();
}
