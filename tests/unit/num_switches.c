/* Tapes whose switches can be held, against the same expressions with the branches written out: values, Jacobians and
 * series, interpreted and as machine code; and with nothing held, against tapes that know no switches, to the bit. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "exec.h"
#include "jacobian.h"
#include "jet.h"
#include "switches.h"

enum { SIZE = 3, ROOTS = 5, ORDER = 6 };

static struct expr_store st;
static expr_id symbol[SIZE];
static int input[SIZE];
static unsigned long seed;

static double unit(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(seed >> 11) / 9007199254740992.0 * 2 - 1;
}

/* abs, sign, min, max with branches that the sides choose; side 0: the functions themselves. */
static expr_id absolute(expr_id a, int s) { return s ? expr_mul(&st, expr_int(&st, s), a) : expr_fun(&st, EXPR_ABS, a); }
static expr_id sign(expr_id a, int s) { return s ? expr_int(&st, s) : expr_fun(&st, EXPR_SIGN, a); }
static expr_id least(expr_id a, expr_id b, int s) { return s ? s > 0 ? b : a : expr_fun2(&st, EXPR_MIN, a, b); }
static expr_id most(expr_id a, expr_id b, int s) { return s ? s > 0 ? a : b : expr_fun2(&st, EXPR_MAX, a, b); }

/* Roots with three switches: x - y (shared by abs, min and max), sin(t), and abs(x - y) - 1/2. */
static void roots(expr_id *r, int s0, int s1, int s2)
{
    expr_id x = symbol[0], y = symbol[1], t = symbol[2], d = expr_sub(&st, x, y), sine = expr_fun(&st, EXPR_SIN, t);
    expr_id inner = absolute(d, s0), half = expr_rational(&st, 1, 2);
    r[0] = expr_add(&st, inner, expr_mul(&st, x, t));
    r[1] = expr_mul(&st, sign(sine, s1), expr_fun(&st, EXPR_EXP, y));
    r[2] = expr_mul(&st, least(x, y, s0), most(x, y, s0));
    r[3] = expr_mul(&st, absolute(expr_sub(&st, inner, half), s2), absolute(sine, s1));
    r[4] = expr_add(&st, most(x, y, s0), sign(d, s0));
}

static bool close_to(double a, double b) { return fabs(a - b) <= 1e-13 * (1 + fabs(b)); }

/* The switch of a node with this argument. */
static int which(const struct num_switches *w, expr_id argument)
{
    for (int k = 0; k < w->count; k++)
        if (w->argument[k] == argument)
            return k;
    return -1;
}

static void compare(struct num_tape *held, struct num_jacobian *j, struct num_tape *plain, struct num_jacobian *jp)
{
    double in[SIZE], a[ROOTS], b[ROOTS], va[ROOTS * SIZE], vb[ROOTS * SIZE];
    for (int i = 0; i < SIZE; i++)
        in[i] = 2 * unit();
    num_tape_eval(held, in, a);
    num_tape_eval(plain, in, b);
    for (int r = 0; r < ROOTS; r++)
        CHECK(close_to(a[r], b[r]), "root %d: %g, not %g", r, a[r], b[r]);
    num_jacobian_eval(j, in, NULL, va);
    num_jacobian_eval(jp, in, NULL, vb);
    for (int r = 0; r < ROOTS; r++)
        for (int c = 0; c < SIZE; c++) {
            double u = 0, v = 0;
            for (int k = j->start[r]; k < j->start[r + 1]; k++)
                u = j->col[k] == c ? va[k] : u;
            for (int k = jp->start[r]; k < jp->start[r + 1]; k++)
                v = jp->col[k] == c ? vb[k] : v;
            CHECK(close_to(u, v), "slope %d of root %d: %g, not %g", c, r, u, v);
        }
}

static void compare_series(struct num_tape *held, struct num_jet *a, struct num_tape *plain)
{
    struct num_jet *b = num_jet_new(plain, ORDER);
    struct num_jet2 *a2 = num_jet2_new(held, ORDER), *b2 = num_jet2_new(plain, ORDER);
    num_jet_hold(a, held);
    num_jet2_hold(a2, held);
    for (int i = 0; i < SIZE; i++)
        for (int k = 0; k <= ORDER; k++)
            num_jet2_input(a2, i)[k].hi = num_jet2_input(b2, i)[k].hi = num_jet_input(a, i)[k] = num_jet_input(b, i)[k] = unit();
    for (int k = 0; k <= ORDER; k++)
        CHECK(num_jet_next(a, k) == num_jet_next(b, k) && num_jet2_next(a2, k) == num_jet2_next(b2, k));
    for (int r = 0; r < ROOTS; r++)
        for (int k = 0; k <= ORDER; k++) {
            num_dd u = num_jet2_root(a2, r)[k], v = num_jet2_root(b2, r)[k];
            CHECK(close_to(num_jet_root(a, r)[k], num_jet_root(b, r)[k]), "coefficient %d of root %d", k, r);
            CHECK((!num_dd_finite(u) && !num_dd_finite(v)) || fabs(num_dd_sub(u, v).hi) <= 1e-28 * fabs(u.hi), "coefficient %d of root %d, in double-double", k, r);
        }
    num_jet_free(b);
    num_jet2_free(a2);
    num_jet2_free(b2);
}

static void test_held(struct sga_exec *exec)
{
    expr_id r[ROOTS], d = expr_sub(&st, symbol[0], symbol[1]), sine = expr_fun(&st, EXPR_SIN, symbol[2]);
    roots(r, 0, 0, 0);
    struct num_switches w;
    num_switches_find(&w, &st, r, ROOTS);
    int at[3] = { which(&w, d), which(&w, sine), which(&w, expr_sub(&st, expr_fun(&st, EXPR_ABS, d), expr_rational(&st, 1, 2))) };
    CHECK(w.count == 3 && at[0] >= 0 && at[1] >= 0 && at[2] >= 0, "%d switches", w.count);
    struct num_tape *held = num_tape_new_switched(&st, &w, r, ROOTS, input, SIZE, NULL);
    struct num_jacobian *j = num_jacobian_new(held, NULL, 0);
    struct num_jet *jet = num_jet_new(held, ORDER);
    num_jacobian_compile(j, exec);
    for (int turn = 0; turn < 27; turn++) {
        signed char side[3];
        int s[3] = { turn % 3 - 1, turn / 3 % 3 - 1, turn / 9 - 1 };
        for (int k = 0; k < 3; k++)
            side[at[k]] = (signed char)s[k];
        num_jacobian_hold(j, side);
        roots(r, s[0], s[1], s[2]);
        struct num_tape *plain = num_tape_new(&st, r, ROOTS, input, SIZE, NULL);
        struct num_jacobian *jp = num_jacobian_new(plain, NULL, 0);
        for (int k = 0; k < 40; k++)
            compare(held, j, plain, jp);
        if (s[0] && s[1] && s[2])
            compare_series(held, jet, plain);
        num_jacobian_free(jp);
        num_tape_free(plain);
    }
    CHECK(!exec || num_jacobian_compiled(j));
    num_jet_free(jet);
    num_jacobian_free(j);
    num_tape_free(held);
    num_switches_clear(&w);
}

/* Nothing held, on a surface and off it. */
static void test_as_they_are(void)
{
    expr_id r[ROOTS];
    double in[SIZE] = { 0 }, a[ROOTS], b[ROOTS];
    roots(r, 0, 0, 0);
    struct num_switches w;
    num_switches_find(&w, &st, r, ROOTS);
    struct num_tape *held = num_tape_new_switched(&st, &w, r, ROOTS, input, SIZE, NULL), *plain = num_tape_new(&st, r, ROOTS, input, SIZE, NULL);
    signed char side[3] = { 1, -1, 1 };
    for (int k = 0; k < 300; k++) {
        num_tape_hold(held, side);
        num_tape_hold(held, NULL);
        num_tape_eval(held, in, a);
        num_tape_eval(plain, in, b);
        for (int i = 0; i < ROOTS; i++)
            CHECK(a[i] == b[i], "root %d: %g, not %g", i, a[i], b[i]);
        in[0] = 3 * unit();
        in[1] = k % 7 ? 3 * unit() : in[0];
        in[2] = k % 5 ? 3 * unit() : 0;
    }
    num_tape_free(held);
    num_tape_free(plain);
    num_switches_clear(&w);
}

/* Any number of them, each argument once, in the order of the nodes. */
static void test_many(void)
{
    enum { MANY = 3000 };
    struct num_switches w;
    expr_id *root = malloc(2 * MANY * sizeof *root);
    for (int k = 0; k < MANY; k++) {
        expr_id a = expr_add(&st, symbol[0], expr_int(&st, k + 1));
        root[k] = expr_fun(&st, EXPR_ABS, a);
        root[MANY + k] = expr_mul(&st, symbol[1], expr_fun(&st, EXPR_SIGN, a));
    }
    num_switches_find(&w, &st, root, 2 * MANY);
    CHECK(w.count == MANY, "%d switches", w.count);
    for (int k = 0; k < MANY; k++) {
        int at = num_switches_of(&w, root[k]);
        CHECK(at >= 0 && at < w.count && w.argument[at] == st.node[root[k]].a, "switch %d", k);
    }
    num_switches_clear(&w);
    free(root);
}

int main(void)
{
    seed = check_seed(9);
    expr_store_init(&st);
    symbol[0] = expr_symbol_add(&st, "x", EXPR_VARIABLE);
    symbol[1] = expr_symbol_add(&st, "y", EXPR_VARIABLE);
    symbol[2] = expr_symbol_add(&st, "t", EXPR_TIME);
    for (int i = 0; i < SIZE; i++)
        input[i] = st.node[symbol[i]].a;
    struct sga_exec *exec = sga_exec_new(1 << 20);
    test_held(NULL);
    test_held(exec);
    test_as_they_are();
    test_many();
    sga_exec_free(exec);
    expr_store_clear(&st);
    return CHECK_END();
}
