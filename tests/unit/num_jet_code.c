/* Series as a program: by machine code and by the loop the same to the bit, and both as the recurrences have them, order by
 * order, but for roundings: every operator alone, all together, products of random ones, random systems of several variables and of time alone; at
 * every order from 1 to the highest, at scales both ways, and where a value is missing. What only the
 * interpreter knows is left to it. Code that is kept serves jets with other constants, and no others, with the same bits. */
#include "check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "error.h"
#include "exec.h"
#include "jet.h"
#include "parse.h"
#include "tape.h"
#include "tape_code.h"

enum { ORDER = 25, RUNS = 40, VARIABLES = 3 };
static struct expr_store st;
static const char *const names[] = { "x", "y", "z", "t" };
static int inputs[VARIABLES + 1];
static int ran;                /* series that machine code made */

static const char *const compiled[] = {
    "x + y", "x - z", "-y", "x*y", "x^2", "x/y", "3/x", "x/7", "7*y", "x^3", "x^7", "y^-2", "exp(x*y)", "sin(x)*cos(x)", "cos(y + t)",
    "sinh(x) + cosh(x)", "tan(x/3)", "tanh(z)", "sqrt(2 + x)", "log(3 + y)", "atan(x)", "asin(x/9)", "acos(y/9)", "asinh(y)", "acosh(2 + x^2)",
    "atanh(x/9)", "(2 + x)^(1/3)", "cbrt(2 + y)", "(2 + x)^(7/2)", "t*x", "t", "t^3 - x", "x - t^2", "t*t*t*y", "sin(t)*x", "cos(3*t) + sin(3*t)",
    "exp(t)", "sqrt(3 + t)", "1/(2 + t)", "x/(2 + t)", "t/(2 + x)", "(1 + t)^(1/3)", "pi*z", "(x*y - z)/(1 + x^2*z^2)", "sin(x*cos(y*exp(z)))",
    "sqrt(x^2 + y^2)^3", "x/(x^2 + y^2)^(3/2)", "2", "0*x", "x", "log(t + 2)", "tan(t)", "x^pi", "(2 + x)^y",
};
static const char *const interpreted[] = { "abs(x + 5)", "max(x, 9)", "atan2(x, 2 + y)", "sign(x)" };
static const char *const missing[] = { "sqrt(x - 9)", "log(-x - 9)", "y/sin(t)", "asin(x + 9)", "(x - 9)^(1/3)", "exp(1000*x + 9000)", "x/t" };

static expr_id parse(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

static double random_between(uint64_t *seed, double a, double b)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return a + (b - a) * (double)(*seed >> 11) * 0x1p-53;
}

/* Coefficients agree to roundings of the sizes that the three series have around there. */
static bool near(const double *a, const double *b, int order)
{
    double size = 0;
    for (int k = 0; k <= order; k++) {
        double here = 0, most = 0;
        for (int i = 0; i < VARIABLES; i++) {
            here = fmax(here, fmax(fabs(a[k * VARIABLES + i]), k < order ? fabs(a[(k + 1) * VARIABLES + i]) : 0));
            most = fmax(most, fabs(a[k * VARIABLES + i] - b[k * VARIABLES + i]));
        }
        size = fmax(0.3 * size, here);
        if (!(most <= 1e-14 * (k + 4) * size))      /* roundings add up from order to order */
            return false;
    }
    return true;
}

/* The series of x' = scale root by the recurrences, one order after the other. */
static bool recur(struct num_jet *j, int order, double t, double scale, double *series)
{
    for (int i = 0; i <= VARIABLES; i++)
        memset(num_jet_input(j, i), 0, (ORDER + 1) * sizeof(double));
    num_jet_input(j, VARIABLES)[0] = t;
    num_jet_input(j, VARIABLES)[1] = scale;
    for (int i = 0; i < VARIABLES; i++)
        num_jet_input(j, i)[0] = series[i];
    for (int k = 0; k < order; k++) {
        if (!num_jet_next(j, k))
            return false;
        for (int i = 0; i < VARIABLES; i++)
            num_jet_input(j, i)[k + 1] = series[(k + 1) * VARIABLES + i] = scale * num_jet_root(j, i)[k] / (k + 1);
    }
    return true;
}

/* x' = the three roots, at random points; makes: whether there is to be machine code; has: whether there is to be a series. */
static void compare(const expr_id *root, bool makes, bool has, const char *what)
{
    struct sga_error err = { 0 };
    struct num_tape *t = num_tape_new(&st, root, VARIABLES, inputs, VARIABLES + 1, &err);
    struct num_jet *plain = num_jet_new(t, ORDER), *fast = num_jet_new(t, ORDER), *slow = num_jet_new(t, ORDER);
    struct sga_exec *memory = sga_exec_new(1 << 22);
    double a[(ORDER + 1) * VARIABLES + 1], b[(ORDER + 1) * VARIABLES + 1], c[(ORDER + 1) * VARIABLES + 1];
    uint64_t seed = 5;
    int same = 0, all = 0, series = 0;
    num_jet_compile(fast, memory, NULL);
    for (int s = 0; s < RUNS + ORDER; s++) {
        int order = s < RUNS ? ORDER : s - RUNS + 1;
        double now = has ? 0.3 : 0, scale = s % 3 == 0 ? -0.25 : s % 3 == 1 ? 0.125 : 0.25;
        memset(a, 0, sizeof a);
        memset(b, 0, sizeof b);
        a[(order + 1) * VARIABLES] = b[(order + 1) * VARIABLES] = 17;
        for (int i = 0; i < VARIABLES; i++)
            a[i] = b[i] = c[i] = random_between(&seed, 0.3, 1);
        bool p = num_jet_along(plain, VARIABLES, order, now, scale, a), q = num_jet_along(fast, VARIABLES, order, now, scale, b);
        bool agree = p == q && p == recur(slow, order, now, scale, c) && a[(order + 1) * VARIABLES] == 17 && b[(order + 1) * VARIABLES] == 17;
        agree &= !p || (memcmp(a, b, (size_t)((order + 1) * VARIABLES) * sizeof *a) == 0 && near(a, c, order));
        same += agree;
        series += p;
        all++;
        ran += num_jet_compiled(fast);
    }
    CHECK(same == all, "%s: %d of %d", what, same, all);
    CHECK(series == (has ? all : 0), "%s: %d series of %d", what, series, all);
    if (memory)
        CHECK(num_jet_compiled(fast) == makes && num_jet_straight(t) == makes && !num_jet_compiled(plain), "%s", what);
    num_jet_free(plain);
    num_jet_free(fast);
    num_jet_free(slow);
    num_tape_free(t);
    sga_exec_free(memory);
}

/* A jet of these formulas that may use what is kept, beside one that may not. Whether it had code at once. */
static bool shares(struct num_jet_programs *kept, struct sga_exec *memory, const char *const *formula, int order)
{
    struct sga_error err = { 0 };
    expr_id root[VARIABLES];
    for (int i = 0; i < VARIABLES; i++)
        root[i] = parse(formula[i]);
    struct num_tape *t = num_tape_new(&st, root, VARIABLES, inputs, VARIABLES + 1, &err);
    struct num_jet *plain = num_jet_new(t, order), *fast = num_jet_new(t, order);
    double a[(ORDER + 1) * VARIABLES], b[(ORDER + 1) * VARIABLES];
    bool at_once = false;
    int same = 0;
    num_jet_compile(fast, memory, kept);
    for (int s = 0; s < RUNS; s++) {
        for (int i = 0; i < VARIABLES; i++)
            a[i] = b[i] = 0.3 + 0.01 * s + 0.1 * i;
        bool p = num_jet_along(plain, VARIABLES, order, 0.3, 0.25, a), q = num_jet_along(fast, VARIABLES, order, 0.3, 0.25, b);
        same += p && q && memcmp(a, b, (size_t)((order + 1) * VARIABLES) * sizeof *a) == 0;
        at_once |= s == 0 && num_jet_compiled(fast);
    }
    CHECK(same == RUNS, "%s, %s, %s: %d of %d", formula[0], formula[1], formula[2], same, RUNS);
    num_jet_free(plain);
    num_jet_free(fast);
    num_tape_free(t);
    return at_once;
}

static void check_kept(void)
{
    /* numbers that no other formula has: as in a store of their own they come in the order in which they are read */
    static const char *const first[] = { "y*sin(x)/101", "(103 + x)^(1/107) - 109*t", "exp(x*y)/(113 + z)" },
        *const numbers[] = { "y*sin(x)/211", "(223 + x)^(1/227) - 229*t", "exp(x*y)/(233 + z)" },
        *const steps[] = { "y*cos(x)/101", "(103 + x)^(1/107) - 109*t", "exp(x*y)/(113 + z)" },
        *const places[] = { "y*sin(x)/101", "(103 + x)^(1/107) - 109*t", "exp(x*z)/(113 + z)" },
        *const turned[] = { "(103 + x)^(1/107) - 109*t", "y*sin(x)/101", "exp(x*y)/(113 + z)" };
    struct sga_exec *memory = sga_exec_new(1 << 22);
    struct num_jet_programs *kept = num_jet_programs_new();
    bool has = memory != NULL;
    CHECK(!shares(kept, memory, first, 20));
    CHECK(shares(kept, memory, first, 20) == has);
    CHECK(shares(kept, memory, numbers, 20) == has);
    CHECK(!shares(kept, memory, first, 19) && !shares(kept, memory, steps, 20) && !shares(kept, memory, places, 20) && !shares(kept, memory, turned, 20));
    CHECK(!shares(NULL, memory, first, 20) && !shares(kept, NULL, first, 20));
    CHECK(shares(kept, memory, first, 19) == has && shares(kept, memory, first, 20) == has && shares(kept, memory, steps, 20) == has);
    for (int order = 2; order < 14; order++)          /* more than are kept */
        shares(kept, memory, first, order);
    CHECK(shares(kept, memory, numbers, 20) == has);
    num_jet_programs_free(kept);
    sga_exec_free(memory);
}

/* a sum of random parts of small size */
static expr_id mixed(const expr_id *of, int n, uint64_t *seed)
{
    expr_id e = expr_mul(&st, of[(int)random_between(seed, 0, n)], of[(int)random_between(seed, 0, n)]);
    e = expr_add(&st, expr_mul(&st, parse("1/16"), e), of[(int)random_between(seed, 0, n)]);
    return expr_mul(&st, parse("1/64"), e);
}

int main(void)
{
    enum { FAST = sizeof compiled / sizeof *compiled, SLOW = sizeof interpreted / sizeof *interpreted,
           NONE = sizeof missing / sizeof *missing, SYSTEMS = 60 };
    expr_id root[FAST], made[VARIABLES];
    uint64_t seed = 7;
    char what[32];
    expr_store_init(&st);
    for (int i = 0; i <= VARIABLES; i++) {
        expr_symbol_add(&st, names[i], i < VARIABLES ? EXPR_VARIABLE : EXPR_TIME);
        inputs[i] = expr_symbol_find(&st, names[i], 1);
    }
    for (int i = 0; i < FAST; i++) {
        root[i] = parse(compiled[i]);
        expr_id alone[] = { expr_mul(&st, parse("1/16"), root[i]), parse("x/3 - z/5"), parse("cos(x)/9") };
        compare(alone, true, true, compiled[i]);
    }
    for (int s = 0; s < SYSTEMS; s++) {
        for (int i = 0; i < VARIABLES; i++)
            made[i] = mixed(root, FAST, &seed);
        snprintf(what, sizeof what, "system %d", s);
        compare(made, true, true, what);
    }
#ifdef __x86_64__
    CHECK(ran > 0, "machine code never ran");
#else
    CHECK(ran == 0, "machine code of another processor");
#endif
    for (int i = 0; i < SLOW; i++) {
        expr_id alone[] = { parse(interpreted[i]), parse("x/3"), parse("y") };
        compare(alone, false, true, interpreted[i]);
    }
    for (int i = 0; i < NONE; i++) {
        expr_id alone[] = { parse("y"), parse(missing[i]), parse("y*z") };
        compare(alone, true, false, missing[i]);
    }
    check_kept();
    expr_store_clear(&st);
    return CHECK_END();
}
