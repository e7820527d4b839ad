/* Validated integration against closed forms, which are evaluated in balls by another way. */
#include <math.h>
#include <string.h>

#include "ball.h"
#include "check.h"
#include "enclose.h"
#include "error.h"
#include "parse.h"

enum { MOST = 6, TIMES = 3 };

struct model {
    const char *name, *variable[MOST], *field[MOST], *start[MOST], *time[TIMES], *exact[MOST];
    double lost;          /* bits that the problem costs at most */
};

static const struct model models[] = {
    { "exponential", { "x" }, { "x" }, { "1/3" }, { "1", "5/3", "7" }, { "exp(t)/3" }, 16 },
    { "decay backwards", { "x" }, { "-x/2" }, { "2" }, { "-1", "-2", "-7" }, { "2*exp(-t/2)" }, 16 },
    { "oscillator", { "x", "v" }, { "v", "-x" }, { "1", "0" }, { "1", "pi", "100" }, { "cos(t)", "-sin(t)" }, 24 },
    { "Riccati", { "x" }, { "1 + x^2" }, { "0" }, { "1/2", "1", "3/2" }, { "tan(t)" }, 24 },
    { "a sheared turn", { "x", "v" }, { "v", "-10^8*x" }, { "1", "0" }, { "1/10^4", "1/1000", "1/100" },
      { "cos(10^4*t)", "-10^4*sin(10^4*t)" }, 40 },
    { "powers", { "x", "y" }, { "-x*y", "-x^(4/3)*y^(2/3)" }, { "1", "1" }, { "1/4", "1/2", "1" }, { "1/(1 + t)", "1/(1 + t)" }, 24 },
    { "forced", { "x" }, { "cos(t) + exp(x - sin(t)) - 1" }, { "0" }, { "1", "2", "4" }, { "sin(t)" }, 24 },
    { "functions", { "x", "y", "z" },
      { "1/(sqrt(1 - tanh(y)^2)*cosh(y)) + atan(x) - atan(t)", "cosh(asinh(x))/sqrt(1 + t^2)", "cbrt(exp(-3*z))/(1 + t) + log((1 + x)/(1 + t))" },
      { "1/4", "1/4", "0" }, { "1/2", "1", "2" }, { NULL }, 24 },
};

static struct expr_store st;

static expr_id parse(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

static void value(arb_t r, const char *text, const arb_t t, slong prec)
{
    struct num_ball b;
    num_ball_init(&b, &st, prec);
    if (t)
        num_ball_set(&b, expr_symbol_find(&st, "t", 1), t);
    expr_id e = parse(text);
    num_ball_extend(&b);
    arb_set(r, num_ball_value(&b, e));
    num_ball_clear(&b);
}

static void run(const struct model *m, slong prec)
{
    int n = 0, variable[MOST];
    expr_id field[MOST];
    struct sga_error err = { 0 };
    expr_store_init(&st);
    expr_symbol_add(&st, "t", EXPR_TIME);
    for (; n < MOST && m->variable[n]; n++) {
        expr_symbol_add(&st, m->variable[n], EXPR_VARIABLE);
        variable[n] = expr_symbol_find(&st, m->variable[n], strlen(m->variable[n]));
    }
    arb_ptr start = _arb_vec_init(n), times = _arb_vec_init(TIMES), box = _arb_vec_init(TIMES * n);
    arb_t t0, v;
    arb_init(t0);
    arb_init(v);
    for (int j = 0; j < n; j++) {
        field[j] = parse(m->field[j]);
        value(start + j, m->start[j], NULL, prec);
    }
    for (int i = 0; i < TIMES; i++)
        value(times + i, m->time[i], NULL, prec);
    struct enclose_problem q = { .st = &st, .variable = variable, .n = n, .time = expr_symbol_find(&st, "t", 1), .field = field };
    struct enclose_path path = { .start = start, .t0 = t0, .times = times, .samples = TIMES, .prec = prec };
    struct enclose_end end;
    CHECK(enclose_run(&q, &path, box, &end, &err), "%s: %s", m->name, err.detail);
    CHECK(end.why == ENCLOSE_DONE && end.samples == TIMES, "%s: %d at %g", m->name, end.why, end.t);
    for (int i = 0; i < end.samples; i++)
        for (int j = 0; j < n; j++) {
            arb_ptr b = box + i * n + j;
            double lost = log2(mag_get_d(arb_radref(b))) + (double)prec;
            CHECK(lost < m->lost + fmax(0, log2(fabs(arf_get_d(arb_midref(b), ARF_RND_NEAR)))), "%s: %s at %s loses %.1f bits of %ld", m->name, m->variable[j], m->time[i], lost, prec);
            if (m->exact[j]) {
                arb_t t;
                arb_init(t);
                value(t, m->time[i], NULL, prec + 100);
                value(v, m->exact[j], t, prec + 100);
                CHECK(arb_contains(b, v), "%s: %s at %s", m->name, m->variable[j], m->time[i]);
                arb_clear(t);
            }
        }
    if (getenv("SGA_TEST_SHOW"))
        printf("# %s, %ld bits: %ld steps, %ld boxes\n", m->name, prec, end.steps, end.evaluations);
    arb_clear(t0);
    arb_clear(v);
    _arb_vec_clear(start, n);
    _arb_vec_clear(times, TIMES);
    _arb_vec_clear(box, TIMES * n);
    expr_store_clear(&st);
}

/* x' = 1 + y, S y = r, where y is 0 or harmless while S is singular at t = 1: there the field has no value. */
static void singular_system(int which)
{
    expr_store_init(&st);
    struct sga_error err = { 0 };
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    expr_symbol_add(&st, "t", EXPR_TIME);
    int variable = expr_symbol_find(&st, "x", 1), one = which == 0;
    expr_id matrix[4] = { parse(one ? "1 - t" : "1"), parse(which == 2 ? "10^20*t" : "t"), parse(which == 2 ? "t/10^20" : "t"), parse("1") };
    expr_id rhs[2] = { parse(one ? "0" : which == 2 ? "10^20*x" : "x"), parse("x") };     /* y = x/(1 + t) (1, 1), or (10^20, 1) */
    int solve = expr_solve_add(&st, one ? 1 : 2, matrix, rhs);
    expr_id field = expr_add(&st, expr_int(&st, 1), expr_solution(&st, solve, which == 2));
    arb_ptr times = _arb_vec_init(TIMES), box = _arb_vec_init(TIMES);
    arb_t x, t0;
    arb_init(x);
    arb_init(t0);
    arb_one(x);
    for (int i = 0; i < TIMES; i++)
        arb_set_d(times + i, i == 0 ? 0.5 : 1 + i);
    struct enclose_problem q = { .st = &st, .variable = &variable, .n = 1, .time = expr_symbol_find(&st, "t", 1), .field = &field };
    struct enclose_path path = { .start = x, .t0 = t0, .times = times, .samples = TIMES, .prec = 96 };
    struct enclose_end end;
    CHECK(enclose_run(&q, &path, box, &end, &err), "%s", err.detail);
    CHECK(end.why == ENCLOSE_NOT_SHOWN && end.samples == 1 && end.t > 0.9 && end.t <= 1, "system %d: %d at %g", which, end.why, end.t);
    arb_clear(x);
    arb_clear(t0);
    _arb_vec_clear(times, TIMES);
    _arb_vec_clear(box, TIMES);
    expr_store_clear(&st);
}

int main(void)
{
    for (int which = 0; which < 3; which++)
        singular_system(which);
    for (size_t k = 0; k < sizeof models / sizeof *models; k++) {
        run(models + k, 96);
        if (k != 4 && k != 7)      /* slow ones */
            run(models + k, 300);
    }
    return CHECK_END();
}
