/* Dense blocks: the combination behind a constraint that came out of one multiplies out. */
#include "ball.h"
#include "budget.h"
#include "check.h"
#include "oracle.h"
#include "points.h"
#include "points_random.h"
#include "reduction.h"
#include "system.h"

#include <stdio.h>
#include <stdlib.h>

#include "error.h"

enum { N = 9 };

/* c0 + c1 x_i + c2 x_j with small random integers */
static expr_id entry(struct expr_store *st, const struct sys_system *sys, uint64_t *random)
{
    expr_id e = expr_int(st, (long)(points_random(random) % 7) + 1);
    for (int k = 0; k < 2; k++) {
        int v = (int)(points_random(random) % N);
        expr_id x = st->symbol[sys->variable[v].symbol].node;
        e = expr_add(st, e, expr_mul(st, expr_int(st, (long)(points_random(random) % 9) - 4), x));
    }
    return e;
}

static void make_system(struct expr_store *st, struct sys_system *sys, int rows, uint64_t seed)
{
    expr_store_init(st);
    sys_init(sys, st);
    expr_symbol_add(st, "t", EXPR_TIME);
    sys->time = expr_symbol_find(st, "t", 1);
    for (int i = 0; i < N; i++) {
        char name[8];
        int n = snprintf(name, sizeof name, "x%d", i);
        expr_symbol_add(st, name, EXPR_VARIABLE);
        sys_add_variable(sys, expr_symbol_find(st, name, (size_t)n), "variable");
    }
    for (int r = 0; r < rows; r++) {
        sys_add_row(sys, entry(st, sys, &seed), "row");
        for (int i = 0; i < N; i++)
            sys_add_entry(sys, r, i, entry(st, sys, &seed));
    }
}

static void value_of(const struct expr_store *st, struct num_ball *b, struct expr_cone *cone, expr_id e, arb_t v)
{
    expr_cone_of(st, cone, &e, 1);
    num_ball_list(b, cone->list, cone->count);
    arb_set(v, num_ball_value(b, e));
}

/* sum of factor * row i of A vanishes, sum of factor * alpha is the constraint. */
static void check_combination(struct expr_store *st, const struct sys_system *sys, const struct sga_constraint *c)
{
    expr_id left[N] = { 0 }, right = expr_int(st, 0);
    CHECK(c->parts > N - 1, "parts %d", c->parts);
    for (int i = 0; i < N; i++)
        left[i] = expr_int(st, 0);
    for (int k = 0; k < c->parts; k++) {
        const struct sys_row *r = sys->row + c->part[k].row;
        CHECK(c->part[k].row >= 0);
        right = expr_add(st, right, expr_mul(st, c->part[k].factor, r->alpha));
        for (int q = 0; q < r->entries; q++)
            left[r->entry[q].col] = expr_add(st, left[r->entry[q].col], expr_mul(st, c->part[k].factor, r->entry[q].value));
    }
    struct num_ball b;
    struct expr_cone cone;
    arb_t v, w;
    arb_init(v);
    arb_init(w);
    expr_cone_init(&cone);
    num_ball_init(&b, st, 200);
    for (int i = 0; i < N; i++)
        num_ball_set_d(&b, sys->variable[i].symbol, 0.25 + 0.375 * i * i - 0.5 * i);
    num_ball_set_d(&b, sys->time, 0);
    for (int i = 0; i < N; i++) {
        value_of(st, &b, &cone, left[i], v);
        CHECK(arb_contains_zero(v) && arb_rel_accuracy_bits(v) < 20);
        mag_t m;
        mag_init(m);
        arb_get_mag(m, v);
        CHECK(mag_cmp_2exp_si(m, -100) < 0);
        mag_clear(m);
    }
    value_of(st, &b, &cone, right, v);
    value_of(st, &b, &cone, c->expr, w);
    CHECK(arb_overlaps(v, w) && !arb_contains_zero(v));
    num_ball_clear(&b);
    expr_cone_clear(&cone);
    arb_clear(v);
    arb_clear(w);
}

static void test_combination(uint64_t seed)
{
    struct expr_store st;
    struct sys_system sys;
    struct points_oracle oracle;
    struct sga_solution sol = { 0 };
    struct sga_error err = { 0 };
    struct sga_budget budget = { .max_generations = 1 };
    struct reduction_options options = { .seed = 1, .combinations = true, .budget = &budget };
    make_system(&st, &sys, N + 1, seed);
    points_oracle_init(&oracle, seed);
    /* the limit of one generation ends it: what was found so far is looked at */
    sga_reduce(&sys, &options, &oracle, &sol, &err);
    CHECK(sol.constraints >= 1 && sol.constraint[0].generation == 1);
    if (sol.constraints >= 1)
        check_combination(&st, &sys, sol.constraint);
    points_oracle_clear(&oracle);
    sga_solution_clear(&sol);
    sys_clear(&sys);
    expr_store_clear(&st);
}

int main(void)
{
    for (uint64_t seed = 1; seed <= 3; seed++)
        test_combination(seed);
    return CHECK_END();
}
