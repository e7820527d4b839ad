/* Large sparse linear systems in balls, against the dense way and against exact solutions of matrices inside. */
#include <arb_mat.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "arb_ends.h"
#include "ball.h"
#include "ball_solve.h"
#include "check.h"

enum { BITS = 96 };

static uint64_t state = 5;

static double uniform(double a, double b)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return a + (b - a) * (double)(state >> 11) * 0x1p-53;
}

struct example {
    struct expr_store st;
    struct num_ball ball;
    int m, solve;
    arb_mat_t A;                   /* the numbers in the middle, exact */
    arb_mat_t r;
};

/* A symbol of its own for each entry. */
static expr_id entry(struct example *e, double v, double radius, arb_t middle)
{
    char name[24];
    snprintf(name, sizeof name, "s%d", e->st.symbols);
    expr_id s = expr_symbol_add(&e->st, name, EXPR_PARAMETER);
    SGA_ENDS(arb_end) arb_t x = { 0 };
    arb_set_d(x, v);
    arb_set(middle, x);
    mag_set_d(arb_radref(x), radius * fabs(v));
    num_ball_set(&e->ball, e->st.node[s].a, x);
    return s;
}

/* A grid's Laplacian with drift, rows and columns in sizes far apart, and some entries anywhere; bordered: a filled last row and column. dependent: a row
 * is another. */
static void make(struct example *e, int side, bool bordered, bool dependent, double radius, double apart)
{
    int inner = side * side, m = e->m = inner + bordered;
    expr_store_init(&e->st);
    num_ball_init(&e->ball, &e->st, BITS);
    arb_mat_init(e->A, m, m);
    arb_mat_init(e->r, m, 1);
    expr_id *matrix = calloc((size_t)(m * m), sizeof *matrix), *rhs = calloc((size_t)m, sizeof *rhs), zero = expr_int(&e->st, 0);
    double *row = calloc((size_t)m, sizeof *row), *column = calloc((size_t)m, sizeof *column);
    for (int i = 0; i < m; i++) {
        row[i] = exp2(nearbyint(uniform(-apart, apart)));
        column[i] = exp2(nearbyint(uniform(-apart, apart)));
    }
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) {
            int d = i > j ? i - j : j - i;
            bool in = i < inner && j < inner ? d == 0 || d == side || (d == 1 && i / side == j / side) || uniform(0, m) < 0.5 : i < inner || j < inner;
            double v = d == 0 ? uniform(3, 5) : uniform(-1, 1);
            matrix[i * m + j] = !in ? zero : entry(e, v * row[i] * column[j], radius, arb_mat_entry(e->A, i, j));
        }
    for (int j = 0; dependent && j < m; j++) {
        matrix[7 * m + j] = matrix[3 * m + j];
        arb_set(arb_mat_entry(e->A, 7, j), arb_mat_entry(e->A, 3, j));
    }
    for (int i = 0; i < m; i++)
        rhs[i] = i % 3 ? entry(e, uniform(-1, 1) * row[i], radius, arb_mat_entry(e->r, i, 0)) : zero;
    e->solve = expr_solve_add(&e->st, m, matrix, rhs);
    free(matrix), free(rhs), free(row), free(column);
    num_ball_extend(&e->ball);
}

static void done(struct example *e)
{
    arb_mat_clear(e->A);
    arb_mat_clear(e->r);
    num_ball_clear(&e->ball);
    expr_store_clear(&e->st);
}

static void same(void)
{
    for (int round = 0; round < check_scale(24); round++) {
        int side = 9 + round % 4, m;
        bool bordered = round % 2;
        double radius = round % 3 == 2 ? 1e-12 : 0;
        struct example e;
        make(&e, side, bordered, false, radius, round % 5 == 4 ? 60 : 3);
        m = e.m;
        arb_ptr y = _arb_vec_init(m);
        bool ok = num_ball_solve_sparse(&e.ball, e.st.solve + e.solve, y);
        CHECK(ok, "round %d: solved", round);
        arb_mat_t x;
        arb_mat_init(x, m, 1);
        CHECK(arb_mat_solve(x, e.A, e.r, 4 * BITS), "regular");
        int inside = 0, sharp = 0;
        for (int i = 0; i < m && ok; i++) {
            inside += arb_contains(y + i, arb_mat_entry(x, i, 0));
            sharp += arb_rel_accuracy_bits(y + i) > (radius > 0 ? 10 : 50);
        }
        CHECK(inside == m, "round %d: %d of %d exact unknowns are inside", round, inside, m);
        CHECK(sharp > m * 9 / 10, "round %d: %d of %d balls are narrow", round, sharp, m);
        arb_mat_clear(x);
        _arb_vec_clear(y, m);
        done(&e);
    }
}

/* Whatever is chosen inside of the balls, its solution is in those that come of it. */
static void inside(void)
{
    struct example e;
    make(&e, 10, false, false, 1e-6, 2);
    arb_ptr y = _arb_vec_init(e.m);
    CHECK(num_ball_solve_sparse(&e.ball, e.st.solve + e.solve, y), "solved");
    for (int round = 0; round < 4; round++) {
        arb_mat_t A, x;
        arb_mat_init(A, e.m, e.m);
        arb_mat_init(x, e.m, 1);
        for (int i = 0; i < e.m; i++)
            for (int j = 0; j < e.m; j++) {
                SGA_ENDS(arf_end) arf_t part = { 0 };
                arf_set_d(part, 1 + 0.99e-6 * (uniform(-1, 1) > 0 ? 1 : -1));
                arb_mul_arf(arb_mat_entry(A, i, j), arb_mat_entry(e.A, i, j), part, 4 * BITS);
            }
        CHECK(arb_mat_solve(x, A, e.r, 4 * BITS), "regular");
        int count = 0;
        for (int i = 0; i < e.m; i++)
            count += arb_contains(y + i, arb_mat_entry(x, i, 0));
        CHECK(count == e.m, "%d of %d", count, e.m);
        arb_mat_clear(A);
        arb_mat_clear(x);
    }
    _arb_vec_clear(y, e.m);
    done(&e);
}

/* Two rows that are the same, and balls so wide that some matrix inside is singular: nothing is said. */
static void none(void)
{
    for (int round = 0; round < 3; round++) {
        struct example e;
        make(&e, 10, round == 1, round < 2, round == 2 ? 1 : 0, 2);
        arb_ptr y = _arb_vec_init(e.m);
        CHECK(!num_ball_solve_sparse(&e.ball, e.st.solve + e.solve, y), "round %d: no proof of what is not so", round);
        _arb_vec_clear(y, e.m);
        done(&e);
    }
    struct example small;
    make(&small, 5, false, false, 0, 2);
    arb_ptr y = _arb_vec_init(small.m);
    CHECK(!num_ball_solve_sparse(&small.ball, small.st.solve + small.solve, y), "small systems are not for it");
    _arb_vec_clear(y, small.m);
    done(&small);
}

int main(void)
{
    same();
    inside();
    none();
    flint_cleanup();
    return CHECK_END();
}
