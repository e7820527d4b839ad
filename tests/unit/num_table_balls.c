/* Tables in balls and in double-double, against doubles, against each other, and against polynomials that the interpolation reproduces exactly. */
#include <flint/fmpq.h>
#include <math.h>

#include "check.h"
#include "error.h"
#include "parse.h"
#include "table_balls.h"

enum { MOST = 14 };

static unsigned long state;

static double uniform(double a, double b)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return a + (b - a) * (double)(state >> 11) * 0x1p-53;
}

/* Decimals of two digits; a step now and then. */
static int samples(double *t, double *y, bool steps)
{
    int n = 2 + (int)uniform(0, MOST - 2.001);
    t[0] = -1;
    for (int i = 1; i < n; i++) {
        bool step = steps && i > 1 && i + 1 < n && t[i - 1] > t[i - 2] && uniform(0, 1) < 0.3;
        t[i] = step ? t[i - 1] : nearbyint(100 * (t[i - 1] + uniform(0.02, 0.6))) / 100;
    }
    for (int i = 0; i < n; i++)
        y[i] = nearbyint(100 * uniform(-3, 3)) / 100;
    return n;
}

/* The numbers in a piece are those of double, to its digits, and those in double-double are in the balls. */
static void same(void)
{
    arb_ptr piece = _arb_vec_init(NUM_TABLE_PIECE);
    arb_t t, v;
    arb_init(t);
    arb_init(v);
    for (int round = 0; round < check_scale(200); round++) {
        double x[MOST], y[MOST];
        int n = samples(x, y, round % 2);
        struct expr_table *u = expr_table_new(round % 3 ? EXPR_CUBIC : EXPR_LINEAR, n, x, y);
        struct num_table_balls b;
        CHECK(num_table_exact(u) < 0 && num_table_exact(u) < 0, "decimals are exact");
        num_table_balls_init(&b, u, 200);
        num_table_fine(u);
        for (int k = 0; k + 1 < n; k++) {
            double at = x[k] + (x[k + 1] - x[k]) * uniform(0, 1);
            num_table_balls_piece(&b, k, piece);
            u->at = k;
            arb_set_d(t, at);
            for (int order = 0; order <= 4; order++) {
                double rough = expr_table_value(u, order, at);
                num_dd fine = num_table_value(u, order, num_dd_of(at));
                num_table_balls_value(v, piece, order, t, 200);
                double size = 1 + fabs(rough), ball = arf_get_d(arb_midref(v), ARF_RND_NEAR);
                CHECK(fabs(rough - ball) <= 1e-8 * size && fabs(fine.hi - ball) <= 1e-14 * size, "order %d: %.17g %.17g %.17g", order, rough, ball, fine.hi);
                CHECK(mag_cmp_2exp_si(arb_radref(v), -120) < 0, "sharp");
                arb_t d, e;
                arb_init(d);
                arb_init(e);
                arb_set_d(d, fine.hi);
                arb_set_d(e, fine.lo);
                arb_add(d, d, e, 200);
                arb_sub(d, d, v, 200);
                arb_abs(d, d);
                arb_set_d(e, 1e-25 * size);
                CHECK(arb_lt(d, e), "order %d of piece %d in double-double", order, k);
                arb_clear(d);
                arb_clear(e);
            }
        }
        num_table_balls_clear(&b);
        expr_table_free(u);
    }
    arb_clear(t);
    arb_clear(v);
    _arb_vec_clear(piece, NUM_TABLE_PIECE);
}

/* Samples of (t - 1/3)^3, given as texts, at times in tenths: the coefficients of each piece are known. */
static void encloses(void)
{
    struct expr_store st;
    struct sga_error err = { 0 };
    double t[6], y[6];
    expr_id time[6], value[6];
    char text[60];
    expr_store_init(&st);
    for (int k = 0; k < 6; k++) {
        int tenths = k * (k + 3);
        snprintf(text, sizeof text, "%d/10", tenths);
        time[k] = expr_parse(&st, text, NULL, &err);
        snprintf(text, sizeof text, "(%d/10 - 1/3)^3", tenths);
        value[k] = expr_parse(&st, text, NULL, &err);
        t[k] = tenths / 10.0;
        y[k] = pow(tenths / 10.0 - 1.0 / 3, 3);
    }
    struct expr_table *u = expr_table_new(EXPR_CUBIC, 6, t, y);
    expr_table_given(u, &st, time, value);
    CHECK(num_table_exact(u) < 0, "rational");
    struct num_table_balls b;
    num_table_balls_init(&b, u, 150);
    arb_ptr piece = _arb_vec_init(NUM_TABLE_PIECE);
    fmpq_t a, c;
    fmpq_init(a);
    fmpq_init(c);
    for (int k = 0; k < 5; k++) {
        num_table_balls_piece(&b, k, piece);
        fmpq_set_si(a, k * (k + 3), 10);
        fmpq_canonicalise(a);
        CHECK(arb_contains_fmpq(piece, a), "the time");
        fmpq_set_si(c, 1, 3);
        fmpq_sub(a, a, c);
        for (int i = 3; i >= 0; i--) {
            static const int binomial[] = { 1, 3, 3, 1 };
            fmpq_pow_si(c, a, 3 - i);
            fmpq_mul_si(c, c, binomial[i]);
            CHECK(arb_contains_fmpq(piece + 1 + i, c) && mag_cmp_2exp_si(arb_radref(piece + 1 + i), -100) < 0, "coefficient %d of piece %d", i, k);
        }
    }
    fmpq_clear(a);
    fmpq_clear(c);
    _arb_vec_clear(piece, NUM_TABLE_PIECE);
    num_table_balls_clear(&b);
    expr_table_free(u);
    expr_store_clear(&st);
}

/* Times that are not told from each other exactly are refused by their place. */
static void refuses(void)
{
    struct expr_store st;
    struct sga_error err = { 0 };
    expr_store_init(&st);
    double t[4] = { 0, 1.0 / 3, 1.0 / 3, 2 }, y[4] = { 0, 1, 2, 3 };
    expr_id third[4] = { 0 }, root[4] = { 0 };
    third[1] = expr_parse(&st, "1/3", NULL, &err);
    root[3] = expr_parse(&st, "sqrt(4 + 1/7^99)", NULL, &err);
    struct expr_table *u = expr_table_new(EXPR_LINEAR, 4, t, y);
    expr_table_given(u, &st, third, NULL);
    CHECK(num_table_exact(u) == 2 && !u->knot, "one double, two numbers");
    expr_table_free(u);
    u = expr_table_new(EXPR_LINEAR, 4, t, y);
    expr_table_given(u, &st, root, NULL);
    CHECK(num_table_exact(u) == 3, "no rational number");
    expr_table_free(u);
    expr_store_clear(&st);
}

/* Decimals of any size are the shortest texts of their doubles. */
static void decimals(void)
{
    double t[2] = { -1.5e-300, 2.5e+22 }, y[2] = { 0, 0 };
    struct expr_table *u = expr_table_new(EXPR_LINEAR, 2, t, y);
    num_table_exact(u);
    fmpq_t q;
    fmpq_init(q);
    fmpz_ui_pow_ui(fmpq_denref(q), 10, 301);
    fmpz_set_si(fmpq_numref(q), -15);
    fmpq_canonicalise(q);
    CHECK(fmpq_equal(u->knot, q), "-1.5e-300");
    fmpz_one(fmpq_denref(q));
    fmpz_ui_pow_ui(fmpq_numref(q), 10, 21);
    fmpz_mul_ui(fmpq_numref(q), fmpq_numref(q), 25);
    CHECK(fmpq_equal(u->knot + 1, q), "2.5e22");
    fmpq_clear(q);
    expr_table_free(u);
}

int main(void)
{
    state = check_seed(7);
    same();
    encloses();
    refuses();
    decimals();
    return CHECK_END();
}
