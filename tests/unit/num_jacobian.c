/* Sparse Jacobians against central differences, against derivatives written as nodes
 * (another code path: expr_diff), and both directions against each other. */
#include "check.h"

#include <math.h>
#include <string.h>

#include "ball.h"
#include "derive.h"
#include "jacobian.h"
#include "mem.h"
#include "random_expr.h"

static struct random_source rng;

static expr_id symbol(struct expr_store *st, const char *stem, int i)
{
    char name[24];
    sprintf(name, "%s%d", stem, i);
    return expr_symbol_add(st, name, EXPR_VARIABLE);
}

static bool pattern_sane(const struct num_jacobian *j)
{
    bool ok = j->start[0] == 0 && j->start[j->rows] == j->nnz;
    for (int r = 0; r < j->rows; r++)
        for (int i = j->start[r]; i < j->start[r + 1]; i++)
            ok &= j->col[i] >= 0 && j->col[i] < j->cols && (i == j->start[r] || j->col[i] > j->col[i - 1]);
    return ok;
}

/* The entry, or 0 outside of the pattern. */
static double entry(const struct num_jacobian *j, const double *values, int r, int c)
{
    for (int i = j->start[r]; i < j->start[r + 1]; i++)
        if (j->col[i] == c)
            return values[i];
    return 0;
}

/* Compare with the tapes of expr_diff (SOLVE nodes: central differences). */
static void against_nodes(struct expr_store *st, const expr_id *root, int rows, const int *inputs, int ninputs,
                          const int *columns, int cols, const double *in)
{
    struct num_tape *t = num_tape_new(st, root, rows, inputs, ninputs, NULL);
    struct num_jacobian *j = num_jacobian_new(t, columns, cols);
    double *values = calloc((size_t)j->nnz + 1, sizeof *values), *out = calloc((size_t)rows, sizeof *out);
    double *again = calloc((size_t)rows, sizeof *again);
    CHECK(pattern_sane(j), "rows %d cols %d", rows, cols);
    num_jacobian_eval(j, in, out, values);
    num_tape_eval(t, in, again);
    CHECK(memcmp(out, again, (size_t)rows * sizeof *out) == 0, "values of the roots");
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < cols; c++) {
            expr_id d = expr_diff(st, root[r], inputs[columns ? columns[c] : c]);
            double want, got = entry(j, values, r, c);
            struct num_tape *dt = num_tape_new(st, &d, 1, inputs, ninputs, NULL);
            if (dt && num_tape_eval(dt, in, &want) && fabs(want) < 1e12)
                CHECK(fabs(got - want) <= 1e-8 * (1 + fabs(want)), "d%d/d%d: %.17g, %.17g", r, c, got, want);
            num_tape_free(dt);
        }
    free(values);
    free(out);
    free(again);
    num_jacobian_free(j);
    num_tape_free(t);
}

static void random_rational_roots(void)
{
    enum { N = 6, POOL = 30 };
    struct expr_store st;
    expr_id pool[POOL];
    int inputs[N], columns[3] = { 4, 0, 2 }, n = 0;
    double in[N];
    expr_store_init(&st);
    for (; n < N; n++) {
        pool[n] = symbol(&st, "x", n);
        inputs[n] = (n + 2) % N;
        in[n] = 1 + random_unit(&rng) / 2;
    }
    for (; n < POOL; n++) {
        pool[n] = random_rational(&rng, &st, pool, n);
        if (pool[n] == EXPR_UNDEF)
            break;
    }
    if (n == POOL && expr_store_ok(&st)) {
        against_nodes(&st, pool, POOL, inputs, N, NULL, N, in);
        against_nodes(&st, pool, POOL, inputs, N, columns, 3, in);
        against_nodes(&st, pool + POOL - 1, 1, inputs, N, NULL, N, in);
    }
    expr_store_clear(&st);
}

/* Every function of the table: d/dx and, where there is one, d/dy. */
static void every_function(void)
{
    for (int op = EXPR_SIN; op <= EXPR_MAX; op++)
        for (int k = 0; k < 4; k++) {
            struct expr_store st;
            expr_store_init(&st);
            int inputs[2] = { 0, 1 };
            expr_id x = symbol(&st, "x", 0), y = symbol(&st, "x", 1), f;
            double in[2] = { op == EXPR_ACOSH ? 1.2 + k : op == EXPR_LOG || op == EXPR_SQRT ? 0.1 + k : 0.6 - 0.4 * k, 0.3 };
            f = expr_op_args((enum expr_op)op) == 2 ? expr_fun2(&st, (enum expr_op)op, x, y) : expr_fun(&st, (enum expr_op)op, x);
            struct num_tape *t = num_tape_new(&st, &f, 1, inputs, 2, NULL);
            struct num_jacobian *j = num_jacobian_new(t, NULL, 0);
            double values[2] = { 0, 0 }, up, down, h = 1e-5;
            CHECK(num_jacobian_eval(j, in, NULL, values), "%s", expr_op_text((enum expr_op)op));
            for (int c = 0; c < j->nnz; c++) {
                double at[2] = { in[0], in[1] };
                at[c] = in[c] + h;
                num_tape_eval(t, at, &up);
                at[c] = in[c] - h;
                num_tape_eval(t, at, &down);
                CHECK(fabs((up - down) / (2 * h) - values[c]) < 1e-6, "%s by %d at %g: %g, %g",
                      expr_op_text((enum expr_op)op), c, in[0], (up - down) / (2 * h), values[c]);
            }
            num_jacobian_free(j);
            num_tape_free(t);
            expr_store_clear(&st);
        }
}

/* Polynomials with small integer coefficients at small integers: no rounding at all. */
static void exact_polynomials(void)
{
    struct expr_store st;
    expr_store_init(&st);
    int inputs[3] = { 0, 1, 2 };
    expr_id x = symbol(&st, "x", 0), y = symbol(&st, "x", 1), z = symbol(&st, "x", 2);
    expr_id root[4] = {
        expr_mul(&st, expr_powi(&st, x, 5), y),                            /* 5 x^4 y, x^5 */
        expr_sub(&st, expr_mul(&st, x, expr_mul(&st, y, z)), expr_powi(&st, z, 3)),
        z, expr_int(&st, 7)
    };
    double in[3] = { 3, -2, 4 }, want[6] = { 5 * 81 * -2, 243, -8, 12, -6 - 48, 1 }, values[6], out[4];
    struct num_tape *t = num_tape_new(&st, root, 4, inputs, 3, NULL);
    struct num_jacobian *j = num_jacobian_new(t, NULL, 0);
    CHECK(j->nnz == 6 && j->start[1] == 2 && j->start[2] == 5 && j->start[3] == 6 && j->start[4] == 6, "%d", j->nnz);
    CHECK(num_jacobian_eval(j, in, out, values) && memcmp(values, want, sizeof want) == 0, "%g", values[0]);
    CHECK(out[3] == 7, "%g", out[3]);
    num_jacobian_free(j);
    num_tape_free(t);
    expr_store_clear(&st);
}

/* Real powers, and a sine and a cosine that share an instruction. */
static void powers_and_pairs(void)
{
    struct expr_store st;
    expr_store_init(&st);
    int inputs[2] = { 0, 1 };
    expr_id x = symbol(&st, "x", 0), y = symbol(&st, "x", 1), a = expr_mul(&st, x, y);
    expr_id s = expr_fun(&st, EXPR_SIN, a), c = expr_fun(&st, EXPR_COS, a);
    expr_id root[6] = { expr_pow(&st, x, y), expr_pow(&st, x, expr_rational(&st, 2, 7)), expr_powi(&st, a, -3), s, c,
                        expr_mul(&st, expr_add(&st, s, x), expr_sub(&st, c, expr_mul(&st, s, y))) };
    double in[2] = { 1.25, -0.75 };
    against_nodes(&st, root, 6, inputs, 2, NULL, 2, in);
    against_nodes(&st, root + 5, 1, inputs, 2, NULL, 2, in);
    expr_store_clear(&st);
}

/* [x 1; 1 x] z = (y, 1) at x = 1: reported, by both directions. */
static void singular_solve(void)
{
    struct expr_store st;
    expr_store_init(&st);
    int inputs[2] = { 0, 1 };
    expr_id x = symbol(&st, "x", 0), y = symbol(&st, "x", 1), one = expr_int(&st, 1);
    expr_id a[4] = { x, one, one, x }, r[2] = { y, one };
    int s = expr_solve_add(&st, 2, a, r);
    expr_id root[2] = { expr_solution(&st, s, 0), expr_solution(&st, s, 1) };
    double good[2] = { 2, 5 }, bad[2] = { 1, 5 }, v[4];
    for (int rows = 1; rows <= 2; rows++) {
        struct num_tape *t = num_tape_new(&st, root, rows, inputs, 2, NULL);
        struct num_jacobian *j = num_jacobian_new(t, NULL, 0);
        int first = 0;
        struct num_jacobian *one_column = num_jacobian_new(t, &first, 1);
        CHECK(!num_jacobian_eval(j, bad, NULL, v) && isnan(v[0]), "%g", v[0]);
        CHECK(!num_jacobian_eval(one_column, bad, NULL, v) && isnan(v[0]), "%g", v[0]);
        /* z = (xy - 1, x - y) / (x^2 - 1): no trace of the NaNs is left */
        CHECK(num_jacobian_eval(j, good, NULL, v) && fabs(v[0] - (5 * 3 - 9 * 4) / 9.0) < 1e-14
              && fabs(v[1] - 2 / 3.0) < 1e-14, "%g %g", v[0], v[1]);
        CHECK(num_jacobian_eval(one_column, good, NULL, v) && fabs(v[0] + 21 / 9.0) < 1e-14, "%g", v[0]);
        num_jacobian_free(one_column);
        num_jacobian_free(j);
        num_tape_free(t);
    }
    expr_store_clear(&st);
}

/* A kink, and an infinite slope that no row may turn into NaN elsewhere. */
static void edges(void)
{
    struct expr_store st;
    expr_store_init(&st);
    int inputs[2] = { 0, 1 };
    expr_id x = symbol(&st, "x", 0), y = symbol(&st, "x", 1);
    expr_id root[4] = { expr_fun(&st, EXPR_ABS, x), expr_fun2(&st, EXPR_MIN, x, y), expr_fun(&st, EXPR_SQRT, x),
                        expr_add(&st, expr_mul(&st, y, expr_fun(&st, EXPR_SQRT, x)), y) };
    double in[2] = { 0, 0 }, v[8], out[4];
    struct num_tape *t = num_tape_new(&st, root, 4, inputs, 2, NULL);
    struct num_jacobian *j = num_jacobian_new(t, NULL, 0);
    CHECK(!num_jacobian_eval(j, in, out, v), "an infinite entry is reported");
    CHECK(entry(j, v, 0, 0) == 0 && entry(j, v, 1, 0) == 0.5 && entry(j, v, 1, 1) == 0.5, "%g", entry(j, v, 1, 0));
    CHECK(isinf(entry(j, v, 2, 0)) && entry(j, v, 3, 0) == 0 && entry(j, v, 3, 1) == 1, "%g", entry(j, v, 3, 0));
    num_jacobian_free(j);
    num_tape_free(t);
    expr_store_clear(&st);
}

/* The same gradient in balls at a point that is a double: they hold it. */
static void in_balls(struct expr_store *st, expr_id root, int n, const double *in, const double *expected)
{
    struct num_ball b;
    struct expr_cone cone;
    int *column = sga_malloc((size_t)st->symbols * sizeof *column), zero = 0;
    arb_ptr grad = _arb_vec_init(n);
    struct num_ball_room room = { 0 };
    num_ball_init(&b, st, 100);
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &root, 1);
    for (int i = 0; i < n; i++) {
        column[i] = i;
        num_ball_set_d(&b, i, in[i]);
    }
    num_ball_list(&b, cone.list, cone.count);
    for (int turn = 0; turn < 2; turn++)      /* the second with what the first found */
        num_ball_gradient(&b, root, cone.list, cone.count, column, grad, &room);
    for (int i = 0; i < n; i++) {
        double v = arf_get_d(arb_midref(grad + i), ARF_RND_NEAR), wide = mag_get_d(arb_radref(grad + i));
        CHECK(fabs(v - expected[i]) < 1e-12 * (1 + fabs(v)) && wide < 1e-15 * (1 + fabs(v)), "balls %d: %g +- %g, %g", i, v, wide, expected[i]);
    }
    for (int i = 0; i < room.bars; i++)
        zero += arb_is_zero(room.bar + i) != 0;
    CHECK(zero == room.bars && room.bars >= cone.count, "%d of %d", zero, room.bars);
    expr_cone_clear(&cone);
    num_ball_clear(&b);
    _arb_vec_clear(grad, n);
    num_ball_room_clear(&room);
    free(column);
}

/* A solve whose matrix and right-hand side have components of another, and that are used by turns with what they make. */
static void nested(struct expr_store *st, const expr_id *y, int m, const expr_id *x, int n, const double *in)
{
    expr_id a[9], r[3], root = expr_mul(st, y[0], x[0]);
    int inputs[8];
    double values[8] = { 0 }, all[8] = { 0 };
    for (int i = 0; i < 9; i++)
        a[i] = i % 4 == 0 ? expr_add(st, expr_int(st, 3), expr_mul(st, y[i % m], y[i % m])) : i == 2 ? expr_int(st, 0) : expr_mul(st, x[i % n], y[(i + 1) % m]);
    for (int i = 0; i < 3; i++)
        r[i] = i ? expr_add(st, y[i], x[i]) : expr_int(st, 1);
    int s = expr_solve_add(st, 3, a, r);
    for (int i = 2; i >= 0; i--)
        root = expr_add(st, expr_mul(st, root, expr_solution(st, s, i)), expr_fun(st, EXPR_SIN, expr_solution(st, s, i)));
    for (int i = 0; i < n; i++)
        inputs[i] = i;
    struct num_tape *t = num_tape_new(st, &root, 1, inputs, n, NULL);
    struct num_jacobian *j = num_jacobian_new(t, NULL, 0);
    CHECK(num_jacobian_eval(j, in, NULL, values), "finite");
    for (int c = 0; c < n; c++)
        all[c] = entry(j, values, 0, c);
    in_balls(st, root, n, in, all);
    num_jacobian_free(j);
    num_tape_free(t);
}

/* S(x) y = r(x): against central differences; few columns run forward, few rows in
 * reverse, and both must agree. */
static void linear_solve(void)
{
    enum { M = 4, N = 6 };
    struct expr_store st;
    expr_store_init(&st);
    expr_id x[N] = { 0 }, a[M * M], r[M], root[M + 1], *last = root + M;
    int inputs[N];
    double in[N], values[(M + 1) * N], row[N], col[M + 1], up[M + 1], down[M + 1], h = 1e-6;
    for (int i = 0; i < N; i++) {
        x[i] = symbol(&st, "x", i);
        inputs[i] = i;
        in[i] = random_unit(&rng);
    }
    for (int i = 0; i < M * M; i++)
        a[i] = random_below(&rng, 3) ? expr_mul(&st, x[random_below(&rng, N)], x[random_below(&rng, N)]) : expr_int(&st, 0);
    for (int i = 0; i < M; i++) {
        a[i * M + (i + 1) % M] = expr_add(&st, a[i * M + (i + 1) % M], expr_int(&st, 4));
        r[i] = expr_fun(&st, EXPR_SIN, x[random_below(&rng, N)]);
    }
    int s = expr_solve_add(&st, M, a, r);
    *last = expr_int(&st, 1);
    for (int i = 0; i < M; i++) {
        root[i] = expr_solution(&st, s, i);
        *last = expr_add(&st, *last, expr_mul(&st, root[i], x[i]));
    }
    struct num_tape *t = num_tape_new(&st, root, M + 1, inputs, N, NULL);
    struct num_jacobian *j = num_jacobian_new(t, NULL, 0);
    CHECK(num_jacobian_eval(j, in, NULL, values), "finite");
    for (int c = 0; c < N; c++) {
        double at[N];
        memcpy(at, in, sizeof in);
        at[c] = in[c] + h;
        num_tape_eval(t, at, up);
        at[c] = in[c] - h;
        num_tape_eval(t, at, down);
        struct num_jacobian *one = num_jacobian_new(t, &c, 1);
        CHECK(num_jacobian_eval(one, in, NULL, col), "finite");
        for (int i = 0; i <= M; i++) {
            double d = (up[i] - down[i]) / (2 * h), v = entry(j, values, i, c);
            CHECK(fabs(d - v) < 1e-7 * (1 + fabs(d)), "%d %d: %g, %g", i, c, v, d);
            CHECK(fabs(entry(one, col, i, 0) - v) < 1e-12 * (1 + fabs(v)), "forward %d %d", i, c);
        }
        num_jacobian_free(one);
    }
    struct num_tape *t1 = num_tape_new(&st, last, 1, inputs, N, NULL);
    struct num_jacobian *j1 = num_jacobian_new(t1, NULL, 0);
    CHECK(num_jacobian_eval(j1, in, NULL, row), "finite");
    for (int c = 0; c < N; c++)
        CHECK(fabs(entry(j1, row, 0, c) - entry(j, values, M, c)) < 1e-12 * (1 + fabs(entry(j, values, M, c))), "reverse %d", c);
    for (int c = 0; c < N; c++)
        row[c] = entry(j, values, M, c);
    in_balls(&st, *last, N, in, row);
    nested(&st, root, M, x, N, in);       /* last: the store grows */
    num_jacobian_free(j1);
    num_tape_free(t1);
    num_jacobian_free(j);
    num_tape_free(t);
    expr_store_clear(&st);
}

/* A long chain of small constraints, each with two neighbours: sparse in reverse; and
 * the same with every row made long, and few columns: sparse in forward. */
static void chain(void)
{
    enum { N = 400 };
    struct expr_store st;
    expr_store_init(&st);
    static expr_id x[N], root[N];
    static int inputs[N], first[2] = { 3, N - 2 };
    static double in[N], values[3 * N], dense[2 * N], out[N];
    for (int i = 0; i < N; i++) {
        x[i] = symbol(&st, "x", i);
        inputs[i] = i;
        in[i] = random_unit(&rng);
    }
    for (int i = 0; i + 1 < N; i++) {
        expr_id d = expr_sub(&st, x[i + 1], x[i]);
        root[i] = expr_add(&st, expr_mul(&st, d, d), expr_fun(&st, EXPR_SIN, x[i]));
    }
    struct num_tape *t = num_tape_new(&st, root, N - 1, inputs, N, NULL);
    struct num_jacobian *j = num_jacobian_new(t, NULL, 0);
    CHECK(j->nnz == 2 * (N - 1) && num_jacobian_eval(j, in, out, values), "%d", j->nnz);
    for (int i = 0; i + 1 < N; i++) {
        double d = 2 * (in[i + 1] - in[i]);
        CHECK(values[2 * i] == -d + cos(in[i]) && values[2 * i + 1] == d, "row %d", i);
    }
    num_jacobian_free(j);
    num_tape_free(t);
    for (int i = 1; i + 1 < N; i++)
        root[i] = expr_add(&st, root[i - 1], root[i]);
    t = num_tape_new(&st, root, N - 1, inputs, N, NULL);
    j = num_jacobian_new(t, first, 2);
    CHECK(j->nnz == N - 1 - 2 + 2 && num_jacobian_eval(j, in, out, dense), "%d", j->nnz);
    for (int r = 0; r + 1 < N; r++)    /* x3 enters with steps 2 and 3 */
        CHECK(fabs(entry(j, dense, r, 0) - (r >= 2 ? 2 * (in[3] - in[2]) : 0)
                   - (r >= 3 ? cos(in[3]) - 2 * (in[4] - in[3]) : 0)) < 1e-14, "row %d", r);
    num_jacobian_free(j);
    num_tape_free(t);
    expr_store_clear(&st);
}

int main(void)
{
    rng.state = check_seed(99);
    int n = check_scale(60);
    for (int i = 0; i < n; i++)
        random_rational_roots();
    for (int i = 0; i < n; i++)
        linear_solve();
    every_function();
    exact_polynomials();
    powers_and_pairs();
    singular_solve();
    edges();
    chain();
    flint_cleanup();
    return CHECK_END();
}
