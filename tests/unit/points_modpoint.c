/* Points modulo primes and powers of primes: sets whose equations are coupled, and what vanishes on them. */
#include "check.h"
#include "modpoint.h"
#include "parse.h"
#include "points.h"
#include "points_space.h"

#include <string.h>

#include "error.h"

enum { MOST = 16 };

struct set {
    const char *what;
    const char *variables;            /* one letter each */
    const char *equation[MOST];
    const char *zero[4];              /* functions that vanish on it ... */
    const char *nonzero[2];           /* ... and some that do not, on no component */
    int solved[MOST];                 /* by equation, as a real point would have it */
    bool none;                        /* no point is expected */
};

static const struct set sets[] = {
    { "a circle", "xy", { "x^2 + y^2 - 1" }, { "(x^2 + y^2)^2 - 1" }, { "x - 1/2" }, { 0 }, false },
    { "two circles that meet", "xyz", { "x^2 + y^2 - 4", "(x - z)^2 + y^2 - 4" }, { "z*(2*x - z)" }, { "x - y" }, { 0, 1 }, false },
    { "a four-bar linkage", "xyuv", { "x^2 + y^2 - 1", "(u - x)^2 + (v - y)^2 - 4", "(u - 3)^2 + v^2 - 5" },
      { "(x^2 + y^2 - 1)*(u + 1) + (u - x)^2 + (v - y)^2 - 4" }, { "u - v" }, { 0, 2, 3 }, false },
    { "a rotation matrix", "abcdefghi", { "a^2+b^2+c^2-1", "d^2+e^2+f^2-1", "g^2+h^2+i^2-1", "a*d+b*e+c*f", "a*g+b*h+c*i", "d*g+e*h+f*i" },
      { "a^2+d^2+g^2-1", "a*b+d*e+g*h", "(a*(e*i-f*h)-b*(d*i-f*g)+c*(d*h-e*g))^2-1" }, { "a*(e*i-f*h)-b*(d*i-f*g)+c*(d*h-e*g)-2" }, { 2, 5, 8, 4, 7, 6 }, false },
    { "three quadrics", "xyzw", { "x^2 + y*z - w - 1", "y^2 + x*z - 2*w", "z^2 + x*y + w^2 - 3" },
      { "(x^2 + y*z - w - 1)*y + y^2 + x*z - 2*w" }, { "x + y + z" }, { 0, 1, 2 }, false },
    { "angles in a loop are solved for their sines", "xysc", { "s - sin(x)", "c - cos(x)", "y*s + c - 2" }, { "s^2 + c^2 - 1", "y^2*s^2 - (2 - c)^2" }, { "y" }, { 0, 3, 1 }, false },
    { "roots", "xyz", { "sqrt(x^2 + y^2) + z - 5", "x + sqrt(y) - 3*z" }, { "x^2 + y^2 - (5 - z)^2", "(3*z - x)^2 - y" }, { "z - 1" }, { 0, 1 }, false },
    { "a loop of angles alone", "xyz", { "cos(x) + cos(y) - z", "sin(x) + sin(y) - 1" }, { NULL }, { NULL }, { 0, 1 }, true },
};

static void one_set(const struct set *set, int prime, uint64_t seed)
{
    struct expr_store st;
    struct sga_error err = { 0 };
    int variable[MOST], n = 0, c = 0;
    expr_id constraint[MOST];
    expr_store_init(&st);
    expr_symbol_add(&st, "t", EXPR_TIME);
    for (; set->variables[n]; n++) {
        char name[2] = { set->variables[n], 0 };
        expr_symbol_add(&st, name, EXPR_VARIABLE);
        variable[n] = expr_symbol_find(&st, name, 1);
    }
    for (; c < MOST && set->equation[c]; c++)
        constraint[c] = expr_parse(&st, set->equation[c], NULL, &err);
    struct points_space space = { .st = &st, .variable = variable, .variables = n, .time = 0, .constraint = constraint, .constraints = c };
    struct points_modpoint p;
    bool found = points_modpoint_find(&p, &space, set->solved, prime, &seed), chance;
    CHECK(found == !set->none, "%s: prime %d", set->what, prime);
    for (int i = 0; found && i < c; i++)
        CHECK(points_modpoint_zero(&p, constraint[i], &chance) == 1, "%s: equation %d", set->what, i);
    for (int i = 0; found && i < 4 && set->zero[i]; i++) {
        int zero = points_modpoint_zero(&p, expr_parse(&st, set->zero[i], NULL, &err), &chance);
        CHECK(zero == 1 || (zero < 0 && chance), "%s: %s", set->what, set->zero[i]);
    }
    for (int i = 0; found && i < 2 && set->nonzero[i]; i++)
        CHECK(points_modpoint_zero(&p, expr_parse(&st, set->nonzero[i], NULL, &err), &chance) <= 0, "%s: %s", set->what, set->nonzero[i]);
    CHECK(err.code == SGA_E_OK, "%s: %s", set->what, err.detail);
    if (found)
        points_modpoint_clear(&p);
    expr_store_clear(&st);
}

int main(void)
{
    uint64_t seed = check_seed(31415);
    int rounds = check_scale(6);
    for (int k = 0; k < rounds; k++)
        for (size_t i = 0; i < sizeof sets / sizeof *sets; i++)
            one_set(sets + i, k % NUM_MODP_PRIMES, seed + 97 * (uint64_t)k);
    flint_cleanup();
    return CHECK_END();
}
