/* Enclosures where they are hard: next to poles, edges and cuts, stiff, far from 1, backwards, from wide balls. Families of
 * fields with solutions in closed form, with random numbers in them; every box must hold the solutions from points
 * of the start's balls, and none may stand beyond the end of a solution. */
#include <math.h>
#include <string.h>

#include "ball.h"
#include "check.h"
#include "enclose.h"
#include "error.h"
#include "parse.h"
#include "random_expr.h"

enum { MOST = 3, SAMPLES = 4, POINTS = 4, ROOM = 400 };

/* P, Q: random numbers in [1/8, 4], Z: one in [-2, 2]; solutions from (A, B, C) at t = 0, in terms of those. The start: midpoints.
 * end: before this time the solution ends, if not "": samples are tried up to it and beyond; otherwise up to `span`. */
struct family {
    const char *name, *field[MOST], *start[MOST], *exact[MOST], *end, *span;
    bool both;             /* backwards too */
};

static const struct family families[] = {
    { "blow-up", { "P*x^2" }, { "Q" }, { "A/(1 - P*A*t)" }, "1/(P*A)", "", false },
    { "blow-up of a tangent", { "P*(1 + x^2)" }, { "Z" }, { "tan(P*t + atan(A))" }, "(pi/2 - atan(A))/P", "", false },
    { "blow-up of a logarithm", { "P*exp(x)" }, { "Z" }, { "-log(exp(-A) - P*t)" }, "exp(-A)/P", "", false },
    { "blow-up of a power", { "x^(7/3)" }, { "Q" }, { "(A^(-4/3) - 4*t/3)^(-3/4)" }, "A^(-4/3)*3/4", "", false },
    { "a logarithm of time", { "P/(t - Q)" }, { "Z" }, { "A + P*log((Q - t)/Q)" }, "Q", "", false },
    { "an algebraic point", { "-P*sqrt(x)" }, { "Q" }, { "(sqrt(A) - P*t/2)^2" }, "2*sqrt(A)/P", "", false },
    { "an edge", { "sqrt(1 - x^2)" }, { "Z/3" }, { "sin(t + asin(A))" }, "pi/2 - asin(A)", "", false },
    { "stiff", { "-100*P*(x - cos(t)) - sin(t)" }, { "Z" }, { "cos(t) + (A - 1)*exp(-100*P*t)" }, "", "1/2", false },
    { "growth", { "P*x" }, { "Z" }, { "A*exp(P*t)" }, "", "6", true },
    { "a spiral", { "-x/8 - 10*P*y", "10*P*x - y/8" }, { "Z", "Q" },
      { "exp(-t/8)*(A*cos(10*P*t) - B*sin(10*P*t))", "exp(-t/8)*(A*sin(10*P*t) + B*cos(10*P*t))" }, "", "2", true },
    { "a shear", { "-x + 10^6*y", "-y" }, { "Z", "Q" }, { "exp(-t)*(A + 10^6*B*t)", "exp(-t)*B" }, "", "3", true },
    { "large and small", { "P*10^30*y", "-P*x/10^30" }, { "Z*10^30", "Q" }, { "A*cos(P*t) + 10^30*B*sin(P*t)", "B*cos(P*t) - A*sin(P*t)/10^30" }, "", "4", true },
    { "fast and small", { "P*10^40*x^2" }, { "Q/10^10" }, { "A/(1 - P*10^40*A*t)" }, "1/(P*10^40*A)", "", false },
    { "slow and large", { "P/10^40*x*(1 - x/10^20)" }, { "Q*10^20" }, { "A/(A/10^20 + (1 - A/10^20)*exp(-P/10^40*t))" }, "", "3*10^40", false },
    { "logistic", { "P*x*(1 - x/Q)" }, { "Q/5" }, { "Q*A/(A + (Q - A)*exp(-P*t))" }, "", "5", false },
    { "a double logarithm", { "x*log(x)" }, { "1 + Q" }, { "exp(exp(t)*log(A))" }, "", "1", true },
    { "a hyperbola", { "sqrt(1 + x^2)" }, { "Z" }, { "sinh(t + asinh(A))" }, "", "3", true },
    { "a saturation", { "1 - x^2" }, { "Z/3" }, { "tanh(t + atanh(A))" }, "", "4", false },
    { "tangents of angles", { "(1 + x^2)/(1 + t^2)" }, { "Z" }, { "(t + A)/(1 - A*t)" }, "", "1/4", true },
    { "a sharp step", { "1000*P/(1 + (1000*P*(t - 1/2))^2)" }, { "Z" }, { "A + atan(1000*P*(t - 1/2)) + atan(500*P)" }, "", "1", false },
    { "a sharp pulse", { "-20000*P*(t - 1/2)*x" }, { "Q/10^6" }, { "A*exp(10000*P*(1/4 - (t - 1/2)^2))" }, "", "1/50", false },
    { "branches", { "abs(x) - min(x, 5 + 40*t)/2 + 0*max(x, -x)" }, { "Q" }, { "A*exp(t/2)" }, "", "1", true },
    { "an angle", { "P", "atan2(sin(x), cos(x)) - x" }, { "Z", "Q" }, { "A + P*t", "B" }, "(pi - A)/P", "", false },
    { "twins", { "P*x", "P*y", "x - y" }, { "Q", "Q", "Z" }, { "A*exp(P*t)", "B*exp(P*t)", "C + (A - B)*(exp(P*t) - 1)/P" }, "", "3", true },
    { "polynomials", { "P*t^4 - Q", "x^2", "0" }, { "0", "Z", "Z" },
      { "A + P*t^5/5 - Q*t", "B + A^2*t + 2*A*(P*t^6/30 - Q*t^2/2) + P^2*t^11/275 - 2*P*Q*t^7/35 + Q^2*t^3/3", "C" }, "", "2", true },
    { "cancelling functions", { "tan(x)*cos(x)/(sin(x) + 0*x)*P", "y*(cosh(x)^2 - sinh(x)^2)" }, { "Q/4", "Z" }, { "A + P*t", "B*exp(t)" }, "", "1/2", false },
    { "cube roots", { "3*cbrt(x)^2/P" }, { "Q" }, { "(cbrt(A) + t/P)^3" }, "", "2", false },
    { "inverse functions", { "cos(asin(x))", "1/cosh(acosh(1 + y))" }, { "Z/4", "Q" }, { "sin(t + asin(A))", "sqrt((1 + B)^2 + 2*t) - 1" }, "", "1/2", false },
};

static struct expr_store st;

static expr_id parse(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

static int number_at(char c)
{
    return c == 'P' ? 0 : c == 'Q' ? 1 : 2;
}

/* A text with the random numbers in it. */
static void replace(char *out, const char *text, const double *number)
{
    size_t used = 0;
    for (; *text && used < ROOM - 40; text++) {
        if (*text == 'P' || *text == 'Q' || *text == 'Z')
            used += (size_t)snprintf(out + used, ROOM - used, "(%d/64)", (int)(64 * number[number_at(*text)]));
        else
            used += (size_t)snprintf(out + used, ROOM - used, "%c", *text);
    }
    out[used] = 0;
}

/* The value of a text at a start and a time (NULL: none). */
static void value(arb_t r, const char *text, arb_srcptr start, int n, const arb_t t, slong prec)
{
    static const char *const names[MOST] = { "A", "B", "C" };
    struct num_ball b;
    expr_id e = parse(text);
    num_ball_init(&b, &st, prec);
    for (int j = 0; j < n && start; j++)
        num_ball_set(&b, expr_symbol_find(&st, names[j], 1), start + j);
    if (t)
        num_ball_set(&b, expr_symbol_find(&st, "t", 1), t);
    num_ball_extend(&b);
    arb_set(r, num_ball_value(&b, e));
    num_ball_clear(&b);
}

static int boxes, complete, ended;

struct trial {
    const struct family *f;
    int n;
    slong prec;
    double number[3], wide;
    char text[ROOM];
    arb_ptr start, times, box;
    struct enclose_end end;
    arb_t last;               /* no sample may stand beyond */
};

static const char *with(struct trial *w, const char *text)
{
    replace(w->text, text, w->number);
    return w->text;
}

/* Points of the start's balls: the midpoint, corners, random ones. */
static void point(struct trial *w, struct random_source *r, int which, arb_ptr at)
{
    arf_t d;
    arf_init(d);
    for (int j = 0; j < w->n; j++) {
        double part = which == 0 ? 0 : which == 1 ? (random_below(r, 2) ? 1 : -1) : random_unit(r);
        arf_set_mag(d, arb_radref(w->start + j));
        arb_get_mid_arb(at + j, w->start + j);
        arb_set_arf(w->last, d);
        arf_set_d(d, part);
        arb_mul_arf(w->last, w->last, d, ARF_PREC_EXACT);
        arb_add(at + j, at + j, w->last, ARF_PREC_EXACT);
    }
    arf_clear(d);
}

static void compare(struct trial *w, struct random_source *r)
{
    arb_ptr at = _arb_vec_init(w->n);
    arb_t v;
    arb_init(v);
    for (int k = 0; k < POINTS; k++) {
        point(w, r, w->wide > 0 ? k : 0, at);
        if (*w->f->end) {
            value(w->last, with(w, w->f->end), at, w->n, NULL, w->prec + 200);
            for (int i = 0; i < w->end.samples; i++)
                CHECK(arb_lt(w->times + i, w->last), "%s: a box at sample %d, beyond the end of the solution", w->f->name, i);
        }
        for (int i = 0; i < w->end.samples; i++)
            for (int j = 0; j < w->n; j++) {
                arb_ptr b = w->box + i * w->n + j;
                value(v, with(w, w->f->exact[j]), at, w->n, w->times + i, w->prec + 300);
                CHECK(arb_is_finite(v) && arb_is_finite(b), "%s: values", w->f->name);
                CHECK(arb_contains(b, v), "%s with %g, %g, %g, %ld bits, start %g wide: component %d at sample %d, point %d: radius %g", w->f->name,
                      w->number[0], w->number[1], w->number[2], w->prec, w->wide, j, i, k, mag_get_d(arb_radref(b)));
                boxes++;
            }
    }
    arb_clear(v);
    _arb_vec_clear(at, w->n);
}

/* Up to the end of the solution from the middle, very near, and beyond; or over the span. */
static void set_times(struct trial *w, struct random_source *r, bool back)
{
    static const int near[SAMPLES] = { 2, 6, 14, 30 };
    bool ends = *w->f->end;
    arb_ptr at = _arb_vec_init(w->n);
    point(w, r, 0, at);
    value(w->last, with(w, ends ? w->f->end : w->f->span), at, w->n, NULL, w->prec + 100);
    double part = 0;
    for (int i = 0; i < SAMPLES; i++) {
        part = ends ? 1 - ldexp(1 + random_unit(r) / 2, -near[i]) : part + (1 - part) * (0.5 + random_unit(r) / 2);
        if (ends && i == SAMPLES - 1 && random_below(r, 2))
            part = 1.25;
        arb_set_d(w->times + i, part);
        arb_mul(w->times + i, w->times + i, w->last, 53);
        arb_get_mid_arb(w->times + i, w->times + i);
        if (back)
            arb_neg(w->times + i, w->times + i);
    }
    _arb_vec_clear(at, w->n);
}

static void begin_store(struct trial *w, int *variable)
{
    static const char *const names[2 * MOST] = { "x", "y", "z", "A", "B", "C" };
    expr_store_init(&st);
    expr_symbol_add(&st, "t", EXPR_TIME);
    for (int j = 0; j < 2 * MOST; j++)
        expr_symbol_add(&st, names[j], EXPR_VARIABLE);
    for (w->n = 0; w->n < MOST && w->f->field[w->n]; w->n++)
        variable[w->n] = expr_symbol_find(&st, names[w->n], 1);
}

static void one(struct random_source *r, const struct family *f)
{
    static const double wides[] = { 0, 0, 0x1p-70, 0x1p-40, 0x1p-20, 0x1p-9 };
    struct trial w = { .f = f, .prec = 60 + random_below(r, 140), .wide = wides[random_below(r, 6)] };
    int variable[MOST];
    expr_id field[MOST];
    struct sga_error err = { 0 };
    for (int k = 0; k < 3; k++)
        w.number[k] = (8 + random_below(r, 248)) / 64.0;
    w.number[2] -= 2;
    begin_store(&w, variable);
    w.start = _arb_vec_init(w.n);
    w.times = _arb_vec_init(SAMPLES);
    w.box = _arb_vec_init(SAMPLES * w.n);
    arb_t t0;
    arb_init(t0);
    arb_init(w.last);
    for (int j = 0; j < w.n; j++) {
        mag_t m, a;
        field[j] = parse(with(&w, f->field[j]));
        value(w.start + j, with(&w, f->start[j]), NULL, 0, NULL, w.prec);
        arb_get_mid_arb(w.start + j, w.start + j);
        mag_init(m);
        mag_init(a);
        arb_get_mag(a, w.start + j);
        mag_set_d(m, w.wide);
        mag_mul(arb_radref(w.start + j), m, a);
        mag_clear(m);
        mag_clear(a);
    }
    set_times(&w, r, f->both && random_below(r, 2));
    struct enclose_problem q = { .st = &st, .variable = variable, .n = w.n, .time = expr_symbol_find(&st, "t", 1), .field = field };
    struct enclose_path path = { .start = w.start, .t0 = t0, .times = w.times, .samples = SAMPLES, .prec = w.prec, .most_steps = 2000 };
    CHECK(enclose_run(&q, &path, w.box, &w.end, &err), "%s: %s", f->name, err.detail);
    complete += w.end.samples >= SAMPLES - (*f->end != 0);
    ended += w.end.samples < SAMPLES;
    if (getenv("SGA_TEST_SHOW"))
        printf("# %s, %ld bits, %g wide: %d of %d, why %d at %g, %ld steps\n", f->name, w.prec, w.wide, w.end.samples, SAMPLES, w.end.why, w.end.t, w.end.steps);
    compare(&w, r);
    arb_clear(t0);
    arb_clear(w.last);
    _arb_vec_clear(w.start, w.n);
    _arb_vec_clear(w.times, SAMPLES);
    _arb_vec_clear(w.box, SAMPLES * w.n);
    expr_store_clear(&st);
}

int main(void)
{
    struct random_source r = { check_seed(2016) };
    int families_count = (int)(sizeof families / sizeof *families), count = check_scale(10), trials = 0;
    for (int k = 0; k < families_count; k++)
        for (int i = 0; i < count; i++, trials++)
            one(&r, families + k);
    printf("# %d trials, %d to the end or near it, %d ended before, %d boxes compared\n", trials, complete, ended, boxes);
    CHECK(5 * complete > 4 * trials && boxes > 15 * trials, "most come to their end");
    return CHECK_END();
}
