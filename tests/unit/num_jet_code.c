/* Series by machine code against the interpreted recurrences, coefficient by coefficient: every
 * operator alone, all together, and products of random ones; what only the interpreter knows
 * is left to it. */
#include "check.h"

#include <math.h>
#include <stdio.h>

#include "exec.h"
#include "jet.h"
#include "parse.h"

enum { ORDER = 19, SERIES = 40 };
static struct expr_store st;
static const char *const names[] = { "x", "y", "z", "t" };
static int inputs[4];

static const char *const compiled[] = {
    "x + y", "x - z", "-y", "x*y", "x^2", "x/y", "3/x", "x/7", "7*y", "x^3", "x^7", "y^-2", "exp(x*y)", "sin(x)*cos(x)", "cos(y + t)",
    "sinh(x) + cosh(x)", "tan(x/3)", "tanh(z)", "sqrt(2 + x)", "log(3 + y)", "atan(x)", "asin(x/9)", "(2 + x)^(1/3)", "cbrt(2 + y)",
    "(2 + x)^(7/2)", "t*x", "t", "pi*z", "(x*y - z)/(1 + x^2*z^2)", "sin(x*cos(y*exp(z)))",
};
static const char *const interpreted[] = { "abs(x + 5)", "max(x, 9)", "atan2(x, 2 + y)" };

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

static void fill(struct num_jet *j, uint64_t seed)
{
    for (int i = 0; i < 4; i++)
        for (int k = 0; k <= ORDER; k++)
            num_jet_input(j, i)[k] = i == 3 ? (k == 0 ? 0.3 : k == 1 ? 0.25 : 0)
                                            : random_between(&seed, k ? -1 : 0.3, 1) / (1 + k);
}

static void compare(const expr_id *root, int roots, bool makes, const char *what)
{
    struct sga_error err = { 0 };
    struct num_tape *t = num_tape_new(&st, root, roots, inputs, 4, &err);
    struct num_jet *plain = num_jet_new(t, ORDER), *fast = num_jet_new(t, ORDER);
    struct sga_exec *memory = sga_exec_new(1 << 22);
    int same = 0, all = 0;
    num_jet_compile(fast, memory);
    for (int s = 0; s < SERIES; s++) {
        fill(plain, (uint64_t)s);
        fill(fast, (uint64_t)s);
        for (int k = 0; k < ORDER; k++) {
            bool a = num_jet_next(plain, k), b = num_jet_next(fast, k);
            for (int r = 0; r < roots; r++) {
                double p = num_jet_root(plain, r)[k], q = num_jet_root(fast, r)[k];
                same += a == b && (p == q || (isnan(p) && isnan(q)));
                all++;
            }
        }
    }
    CHECK(same == all, "%s: %d of %d", what, same, all);
    if (memory)
        CHECK(num_jet_compiled(fast) == makes && !num_jet_compiled(plain), "%s", what);
    num_jet_free(plain);
    num_jet_free(fast);
    num_tape_free(t);
    sga_exec_free(memory);
}

int main(void)
{
    enum { FAST = sizeof compiled / sizeof *compiled, SLOW = sizeof interpreted / sizeof *interpreted };
    expr_id root[FAST + SLOW], made[FAST];
    uint64_t seed = 7;
    expr_store_init(&st);
    for (int i = 0; i < 4; i++) {
        expr_symbol_add(&st, names[i], i < 3 ? EXPR_VARIABLE : EXPR_TIME);
        inputs[i] = expr_symbol_find(&st, names[i], 1);
    }
    for (int i = 0; i < FAST; i++) {
        root[i] = parse(compiled[i]);
        compare(root + i, 1, true, compiled[i]);
    }
    compare(root, FAST, true, "all");
    for (int i = 0; i < FAST; i++)
        made[i] = expr_mul(&st, root[(int)random_between(&seed, 0, FAST)], expr_add(&st, root[(int)random_between(&seed, 0, FAST)], root[i]));
    compare(made, FAST, true, "products");
    for (int i = 0; i < SLOW; i++) {
        root[i] = parse(interpreted[i]);
        compare(root + i, 1, false, interpreted[i]);
    }
    expr_store_clear(&st);
    return CHECK_END();
}
