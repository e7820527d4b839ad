/* Enclosures of random fields made of all operators: boxes of different precision must meet, and hold what
 * Runge-Kutta steps in double say to as many digits as those have. */
#include <math.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "enclose.h"
#include "error.h"
#include "print.h"
#include "random_expr.h"
#include "tape.h"

enum { N = 2, SAMPLES = 4, SUBSTEPS = 200 };

static const double END = 0.4;
static int completed, compared;

static expr_id random_node(struct random_source *r, struct expr_store *st, const expr_id *pool, int n)
{
    static const enum expr_op one[] = { EXPR_SIN, EXPR_COS, EXPR_TAN, EXPR_ASIN, EXPR_ACOS, EXPR_ATAN, EXPR_SINH, EXPR_COSH, EXPR_TANH,
                                        EXPR_ASINH, EXPR_ACOSH, EXPR_ATANH, EXPR_EXP, EXPR_LOG, EXPR_SQRT, EXPR_CBRT, EXPR_ABS, EXPR_SIGN };
    static const enum expr_op two[] = { EXPR_ATAN2, EXPR_MIN, EXPR_MAX };
    int k = random_below(r, 10);
    expr_id a = pool[random_below(r, n)], b = pool[random_below(r, n)];
    if (k < 4)
        return random_rational(r, st, pool, n);
    if (k < 8)
        return expr_fun(st, one[random_below(r, (int)(sizeof one / sizeof *one))], a);
    if (k == 8)
        return expr_fun2(st, two[random_below(r, 3)], a, b);
    return expr_pow(st, expr_add(st, expr_int(st, 2), expr_fun(st, EXPR_SIN, a)), b);
}

static expr_id random_field(struct random_source *r, struct expr_store *st, const expr_id *leaf, int leaves)
{
    expr_id pool[12];
    int n = leaves;
    memcpy(pool, leaf, (size_t)leaves * sizeof *leaf);
    for (; n < 11; n++)
        pool[n] = random_node(r, st, pool, n);
    expr_id e = pool[n - 1];
    return expr_div(st, e, expr_add(st, expr_int(st, 1), expr_mul(st, e, e)));     /* of moderate size */
}

/* x at the samples, with `fine` steps in each substep. */
static bool runge_kutta(struct num_tape *f, const double *start, int fine, double x[SAMPLES][N])
{
    double h = END / (SAMPLES * SUBSTEPS * fine), in[N + 1], k[4][N], now[N] = { start[0], start[1] };
    long step = 0;
    for (int s = 0; s < SAMPLES; s++) {
        for (int i = 0; i < SUBSTEPS * fine; i++, step++) {
            static const double at[4] = { 0, 0.5, 0.5, 1 };
            for (int q = 0; q < 4; q++) {
                for (int j = 0; j < N; j++)
                    in[j] = now[j] + (q ? at[q] * h * k[q - 1][j] : 0);
                in[N] = h * ((double)step + at[q]);
                if (!num_tape_eval(f, in, k[q]))
                    return false;
            }
            for (int j = 0; j < N; j++)
                now[j] += h / 6 * (k[0][j] + 2 * k[1][j] + 2 * k[2][j] + k[3][j]);
        }
        memcpy(x[s], now, sizeof now);
    }
    return true;
}

static void compare(struct num_tape *f, const double *start, arb_srcptr box, int samples, int which)
{
    double x[SAMPLES][N], finer[SAMPLES][N];
    if (!runge_kutta(f, start, 1, x) || !runge_kutta(f, start, 2, finer))
        return;
    for (int i = 0; i < samples; i++)
        for (int j = 0; j < N; j++) {
            double error = fabs(x[i][j] - finer[i][j]), mid = arf_get_d(arb_midref(box + i * N + j), ARF_RND_NEAR);
            if (error > 1e-11)
                continue;
            compared++;
            CHECK(fabs(mid - finer[i][j]) <= 1e-10 + mag_get_d(arb_radref(box + i * N + j)), "system %d: %.15g, %.15g", which, mid, finer[i][j]);
        }
}

static void one(struct random_source *r, int which)
{
    static const char *const names[N + 1] = { "x", "y", "t" };
    struct expr_store st;
    struct sga_error err = { 0 };
    expr_id leaf[N + 3], field[N];
    int symbol[N + 1];
    double start[N];
    expr_store_init(&st);
    for (int j = 0; j <= N; j++) {
        leaf[j] = expr_symbol_add(&st, names[j], j < N ? EXPR_VARIABLE : EXPR_TIME);
        symbol[j] = expr_symbol_find(&st, names[j], 1);
    }
    leaf[N + 1] = expr_rational(&st, 1 + random_below(r, 9), 2 + random_below(r, 6));
    leaf[N + 2] = expr_pi(&st);
    for (int j = 0; j < N; j++) {
        field[j] = random_field(r, &st, leaf, N + 3);
        start[j] = ldexp(floor(ldexp(random_unit(r), 10)), -9);
    }
    for (int j = 0; j < N && getenv("SGA_TEST_SHOW"); j++) {
        struct sga_buf text = { 0 };
        expr_print(&st, field[j], 2000, &text);
        printf("# %s' = %s from %g\n", names[j], text.data, start[j]);
        sga_buf_free(&text);
    }
    struct num_tape *f = expr_store_ok(&st) ? num_tape_new(&st, field, N, symbol, N + 1, &err) : NULL;
    if (f) {
        arb_ptr x = _arb_vec_init(N), times = _arb_vec_init(SAMPLES), box[2] = { _arb_vec_init(SAMPLES * N), _arb_vec_init(SAMPLES * N) };
        arb_t t0;
        arb_init(t0);
        struct enclose_end end[2];
        for (int j = 0; j < N; j++)
            arb_set_d(x + j, start[j]);
        for (int i = 0; i < SAMPLES; i++)
            arb_set_d(times + i, END * (i + 1) / SAMPLES);
        for (int k = 0; k < 2; k++) {
            struct enclose_problem q = { .st = &st, .variable = symbol, .n = N, .time = symbol[N], .field = field };
            struct enclose_path path = { .start = x, .t0 = t0, .times = times, .samples = SAMPLES, .prec = k ? 150 : 80, .most_steps = 300 };
            CHECK(enclose_run(&q, &path, box[k], end + k, &err), "system %d: %s", which, err.detail);
        }
        if (getenv("SGA_TEST_SHOW"))
            printf("# %d: %ld, %ld steps, ends %d %d at %g\n", which, end[0].steps, end[1].steps, end[0].why, end[1].why, end[1].t);
        int both = end[0].samples < end[1].samples ? end[0].samples : end[1].samples;
        completed += both == SAMPLES;
        for (int i = 0; i < both * N; i++)
            CHECK(arb_overlaps(box[0] + i, box[1] + i) && mag_cmp(arb_radref(box[1] + i), arb_radref(box[0] + i)) <= 0, "system %d", which);
        compare(f, start, box[1], both, which);
        for (int k = 0; k < 2; k++)
            _arb_vec_clear(box[k], SAMPLES * N);
        _arb_vec_clear(x, N);
        _arb_vec_clear(times, SAMPLES);
        arb_clear(t0);
    }
    num_tape_free(f);
    expr_store_clear(&st);
}

int main(void)
{
    struct random_source r = { check_seed(4711) };
    int count = check_scale(100);
    for (int k = 0; k < count; k++)
        one(&r, k);
    printf("# %d of %d to the end, %d numbers compared\n", completed, count, compared);
    CHECK(count < 20 || (3 * completed > count && compared > count), "enough of them come to their end");
    return CHECK_END();
}
