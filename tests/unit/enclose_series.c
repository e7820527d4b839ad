/* Taylor coefficients in balls, and their derivatives, against coefficients as nodes of the store and gradients of those;
 * what is proved of their tails against many more coefficients; interval Newton; decimals. */
#include <math.h>
#include <string.h>

#include "ball.h"
#include "check.h"
#include "derive.h"
#include "enclose.h"
#include "error.h"
#include "parse.h"
#include "tail.h"

enum { N = 3, ORDER = 5 };

static struct expr_store st;
static const char *const names[N] = { "x", "y", "z" };
static int variable[N], time_symbol;

static expr_id parse(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

static void begin(void)
{
    expr_store_init(&st);
    for (int j = 0; j < N; j++) {
        expr_symbol_add(&st, names[j], EXPR_VARIABLE);
        variable[j] = expr_symbol_find(&st, names[j], 1);
    }
    expr_symbol_add(&st, "t", EXPR_TIME);
    time_symbol = expr_symbol_find(&st, "t", 1);
}

static bool near(const arb_t a, const arb_t b)
{
    arb_t d;
    arb_init(d);
    arb_sub(d, a, b, 400);
    bool ok = arb_is_finite(d) && arb_contains_zero(d) && mag_cmp_2exp_si(arb_radref(d), -100) < 0;
    arb_clear(d);
    return ok;
}

static void with_store(expr_id field, const struct enc_series *s, struct num_ball *b, const char *text)
{
    struct expr_flow f;
    struct expr_cone cone;
    int column[8];
    for (int j = 0; j < st.symbols; j++)
        column[j] = -1;
    for (int j = 0; j < N; j++)
        column[variable[j]] = j;
    expr_flow_init(&f, &st);
    expr_cone_init(&cone);
    expr_flow_determine(&f, variable[0], field);
    expr_flow_determine(&f, variable[1], parse("x*z + t"));
    expr_flow_determine(&f, variable[2], parse("-y/2"));
    for (int k = 0; k < ORDER; k++) {
        expr_id c = expr_flow_coefficient(&f, field, k);
        num_ball_forget(b);
        num_ball_extend(b);
        CHECK(near(num_ball_value(b, c), enc_series_of(s, s->p->root[0]) + k), "order %d of %s", k, text);
        arb_ptr grad = _arb_vec_init(N);
        struct num_ball_room room = { 0 };
        expr_cone_of(&st, &cone, &c, 1);
        num_ball_gradient(b, c, cone.list, cone.count, column, grad, &room);
        for (int j = 0; j < N; j++) {
            CHECK(enc_series_along((struct enc_series *)s, j));
            CHECK(near(grad + j, enc_series_tangent(s, s->p->root[0]) + k), "order %d of %s, by %s", k, text, names[j]);
        }
        _arb_vec_clear(grad, N);
        num_ball_room_clear(&room);
    }
    expr_cone_clear(&cone);
    expr_flow_clear(&f);
}

enum { LONG = 70 };

/* sum_{order < k <= LONG} |f_k| R^k <= tau. */
static bool within(arb_srcptr f, int order, double R, const mag_t tau)
{
    arb_t sum, power, a;
    arb_init(sum);
    arb_init(power);
    arb_init(a);
    arb_set_d(a, R);
    arb_pow_ui(power, a, (ulong)order + 1, 300);
    for (int k = order + 1; k <= LONG; k++) {
        arb_get_mid_arb(a, f + k);
        arb_abs(a, a);
        arb_addmul(sum, a, power, 300);
        arb_set_d(a, R);
        arb_mul(power, power, a, 300);
    }
    arf_t bound;
    arf_init(bound);
    arf_set_mag(bound, tau);
    bool ok = arf_cmp(arb_midref(sum), bound) <= 0;
    arf_clear(bound);
    arb_clear(sum);
    arb_clear(power);
    arb_clear(a);
    return ok;
}

/* Tails of the series from one start, by many more coefficients. */
static void compare_tails(struct enc_tail *tail, struct enc_series *few, const struct enc_program *p, arb_srcptr x, const arb_t t, const char *text)
{
    struct enc_series many;
    enc_series_init(&many, p);
    CHECK(enc_series_run(&many, x, t, LONG, 300), "%s", text);
    for (int i = 0; i < p->slots; i++)
        CHECK(!p->code[i].varies || within(enc_series_of(&many, i), tail->order, tail->R, tail->tau + i), "%s: tail of slot %d at %g: %g", text, i, tail->R, mag_get_d(tail->tau + i));
    for (int j = 0; j < N; j++) {
        CHECK(enc_series_along(few, j) && enc_series_along(&many, j), "%s", text);
        bool found = enc_tail_along(tail);
        CHECK(found, "%s: derivatives at %g", text, tail->R);
        for (int i = 0; found && i < p->slots; i++)
            CHECK(!p->code[i].state || p->code[i].aux || within(enc_series_tangent(&many, i), tail->order, tail->R, tail->dtau + i),
                  "%s: tail of slot %d by %s at %g: %g", text, i, names[j], tail->R, mag_get_d(tail->dtau + i));
    }
    enc_series_clear(&many);
}

/* A little less than the largest R for which there is a tail, and half of that. Short series have long tails: all terms of Phi count. */
static void with_tails(struct enc_program *p, arb_srcptr x, const arb_t t, int order, const char *text)
{
    static const double wide[] = { 0, 0x1p-30, 0x1p-8 };
    flint_rand_t random;
    flint_randinit(random);
    arb_ptr box = _arb_vec_init(N), start = _arb_vec_init(N);
    for (size_t w = 0; w < sizeof wide / sizeof *wide; w++) {
        struct enc_series few;
        struct enc_tail tail;
        enc_series_init(&few, p);
        enc_tail_init(&tail, p);
        for (int j = 0; j < N; j++) {
            arb_set(box + j, x + j);
            mag_set_d(arb_radref(box + j), wide[w]);
        }
        CHECK(enc_series_run(&few, box, t, order, 64), "%s", text);
        enc_tail_begin(&tail, &few);
        double R = 8;
        while (R > 1e-6 && !enc_tail_find(&tail, R))
            R *= 0.9;
        CHECK(R > 0.004 * order, "%s, starts %g around: tails of order %d up to %g only", text, wide[w], order, R);
        for (int turn = 0; turn < 3; turn++, R *= turn == 1 ? 0.9 : 0.5) {
            CHECK(enc_tail_find(&tail, R), "%s: smaller steps have tails too", text);
            if (turn < 1)
                continue;        /* derivatives may ask for less */
            for (int j = 0; j < N; j++) {
                arb_set_d(start + j, wide[w] * (turn == 1 ? (j & 1 ? 1 : -1) : (double)(slong)n_randint(random, 2001) / 1000 - 1));
                arb_add(start + j, start + j, x + j, ARF_PREC_EXACT);
            }
            compare_tails(&tail, &few, p, start, t, text);
        }
        enc_tail_clear(&tail);
        enc_series_clear(&few);
    }
    _arb_vec_clear(box, N);
    _arb_vec_clear(start, N);
    flint_randclear(random);
}

static void functions(void)
{
    static const char *const function[] = {
        "x^2 + y^2 - 1", "x*y*z", "(x + y)/(1 + z^2)", "1/(1 + exp(4*x))", "y/(x - 1)", "atan2(y^3, x - 1)*4", "sin(x*y) + t", "sqrt(1 + x^2)", "log(2 + y)", "x^5", "(1 + x)^-3",
        "exp(x - z)", "tan(y/2)", "atan(x) + asin(y/2) + acos(z/3)", "sinh(x)*cosh(y) - tanh(z)", "cos(x) - sin(x)*cos(y)",
        "asinh(x) + acosh(2 + y^2) + atanh(z/4)", "cbrt(2 + x)", "cbrt(-2 - x)", "(1 + x^2)^(1/3)", "(2 + x)^y", "2^x", "atan2(x, 1 + y)",
        "atan2(-1 - y, x)", "abs(x + 1)", "abs(-x - 1)*y", "max(x, 3)*min(y, 5)", "max(x*y, -3) - min(y, -5)", "sign(x + 5)*y", "t^2*x", "pi*x + exp(1)", "-(x - y)",
    };
    static const double at[N] = { 0.34375, 0.8125, 0.5625 };
    arb_ptr x = _arb_vec_init(N);
    arb_t t;
    arb_init(t);
    arb_set_d(t, 0.15625);
    for (int j = 0; j < N; j++)
        arb_set_d(x + j, at[j]);
    begin();
    int component[2];
    expr_id matrix[4] = { parse("2 + x"), parse("sin(y)"), parse("z*t"), parse("3 - x*y") }, rhs[2] = { parse("y"), parse("x + z^2") };
    int solve = expr_solve_add(&st, 2, matrix, rhs);
    component[0] = expr_solution(&st, solve, 0);
    component[1] = expr_solution(&st, solve, 1);
    int texts = (int)(sizeof function / sizeof *function);
    expr_id fast[4] = { parse("1/(1 - x)"), parse("exp(3*y)"), parse("-exp(2*t)"), parse("exp(4*z)*sin(x + t)") }, large[2] = { parse("exp(3*x)"), parse("1/(2 - y)") };
    int second = expr_solve_add(&st, 2, fast, large);
    for (int i = 0; i < texts + 3; i++) {
        const char *text = i < texts ? function[i] : i == texts ? "a linear solve" : i == texts + 1 ? "a second linear solve" : "its second component";
        expr_id field[N] = { i < texts ? parse(text) : i == texts ? expr_sub(&st, component[0], expr_mul(&st, component[1], component[1]))
                             : expr_solution(&st, second, i - texts - 1), parse("x*z + t"), parse("-y/2") };
        struct enc_program p;
        struct enc_series s;
        struct num_ball b;
        struct sga_error err = { 0 };
        CHECK(enc_program_init(&p, &(struct enc_of){ &st, variable, N, time_symbol, NULL }, field, N, &err), "%s: %s", text, err.detail);
        enc_series_init(&s, &p);
        num_ball_init(&b, &st, 300);
        for (int j = 0; j < N; j++)
            num_ball_set(&b, variable[j], x + j);
        num_ball_set(&b, time_symbol, t);
        CHECK(enc_series_run(&s, x, t, ORDER, 300), "%s", text);
        with_store(field[0], &s, &b, text);
        for (int order = 1; order < 16; order *= 2)
            with_tails(&p, x, t, order, text);
        enc_series_clear(&s);
        num_ball_clear(&b);
        enc_program_clear(&p);
    }
    expr_store_clear(&st);
    _arb_vec_clear(x, N);
    arb_clear(t);
}

static void zeros(void)
{
    struct sga_error err = { 0 };
    begin();
    struct enclose_problem q = { .st = &st, .variable = variable, .n = N, .time = time_symbol };
    expr_id f[2] = { parse("x^2 + y^2 + z^2 - 3"), parse("exp(x - 1) - y") }, twice[2] = { parse("(x - y)^2"), f[0] };
    unsigned char solved[N] = { 1, 1, 0 };
    arb_ptr x = _arb_vec_init(N);
    arb_t t, one;
    arb_init(t);
    arb_init(one);
    arb_one(one);
    for (int j = 0; j < N; j++)
        arb_set_d(x + j, j < 2 ? 1.01 : 1);
    CHECK(enclose_zero(&q, f, 2, t, solved, 500, x, &err));
    for (int j = 0; j < 2; j++)
        CHECK(arb_contains(x + j, one) && mag_cmp_2exp_si(arb_radref(x + j), -480) < 0, "%s", names[j]);
    for (int j = 0; j < N; j++)
        arb_set_d(x + j, j < 2 ? 1.01 : 1);
    CHECK(!enclose_zero(&q, twice, 2, t, solved, 200, x, &err), "a double zero is not proved");
    arb_clear(t);
    arb_clear(one);
    _arb_vec_clear(x, N);
    expr_store_clear(&st);
}

static void decimals(void)
{
    flint_rand_t random;
    flint_randinit(random);
    arb_t x, d;
    arf_t worst, part;
    arb_init(x);
    arb_init(d);
    arf_init(worst);
    arf_init(part);
    for (int k = 0; k < check_scale(3000); k++) {
        double radius;
        arb_randtest(x, random, 200, k % 3 ? 12 : 5);
        char *text = enclose_decimal(x, 100, &radius);
        CHECK(text, "finite");
        CHECK(arb_set_str(d, text, 3000) == 0, "%s", text);
        arf_sub(worst, arb_midref(d), arb_midref(x), ARF_PREC_EXACT, ARF_RND_DOWN);     /* the text itself is off by 2^-3000 of it */
        arf_abs(worst, worst);
        arf_set_mag(part, arb_radref(x));
        arf_add(worst, worst, part, ARF_PREC_EXACT, ARF_RND_DOWN);
        CHECK(arf_cmp_d(worst, radius) <= 0, "%s: %g, %g", text, arf_get_d(worst, ARF_RND_UP), radius);
        bool coarse = mag_cmp_2exp_si(arb_radref(x), -1000) > 0 && arf_cmpabs_mag(arb_midref(x), arb_radref(x)) > 0;
        CHECK(!coarse || radius <= 1.1 * mag_get_d(arb_radref(x)) + ldexp(fabs(arf_get_d(arb_midref(x), ARF_RND_UP)), -99), "%s: radius %g", text, radius);
        free(text);
    }
    arb_indeterminate(x);
    double radius;
    CHECK(enclose_decimal(x, 100, &radius) == NULL && isinf(radius));
    arb_clear(x);
    arb_clear(d);
    arf_clear(worst);
    arf_clear(part);
    flint_randclear(random);
}

int main(void)
{
    functions();
    zeros();
    decimals();
    return CHECK_END();
}
