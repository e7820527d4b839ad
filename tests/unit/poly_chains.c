/* Chains: few polynomials in each; every known zero is on one, and what each consists of vanishes with the given where it is linear. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "check_read.h"
#include "poly.h"

static struct expr_store st;

static expr_id read(const char *text)
{
    return check_read(&st, text);
}

enum { GIVEN = 4, POINTS = 5 };

struct chain_test {
    const char *given[GIVEN];
    int chains;                             /* at the least */
    const char *exact;                      /* polynomials of a chain that is among them, or NULL */
    double point[POINTS][GIVEN];            /* of x, y, z, w: on the zeros */
    int points;
};

static const struct chain_test tests[] = {
    { { "x*y", "x*z" }, 2, "x", { { 0, 2, 3, 1 }, { 5, 0, 0, 1 } }, 2 },
    /* bilinear in (x, y) and (z, w): both planes, and pairs of lines */
    { { "z*(10*y - x) + w*(x - 9*y)", "z*(3*x + y) + w*(x - y)" }, 3, "w; z", { { 0, 0, 2, 3 }, { 2, 3, 0, 0 } }, 2 },
    /* four circles, told apart by products of two polynomials only */
    { { "x^2 + y^2 - 1", "x^2 + z^2 - 1", "z^2 + w^2 - 1" }, 4, NULL, { { 0.6, 0.8, 0.8, 0.6 }, { 0.6, -0.8, 0.8, -0.6 }, { 0.6, 0.8, -0.8, -0.6 } }, 3 },
    { { "x^2 - y^2", "(x - y)*(z - w)" }, 2, NULL, { { 1, 1, 2, 3 }, { 1, -1, 2, 2 } }, 2 },
    { { "k*x*sin(t)", "x - y*(z - 1)" }, 2, NULL, { { 0, 0, 5, 1 }, { 0, 3, 1, 1 } }, 2 },
    { { "x - y", "x*z - 1", "z*(x + y) - 3" }, 0, NULL, { { 0 } }, 0 },
};

/* Tenths, whatever t and k are. */
static bool on(const struct poly_chain *c, const double *at)
{
    static const char *const name[GIVEN] = { "x", "y", "z", "w" };
    expr_id map[16] = { 0 };
    bool all = true;
    for (int i = 0; i < GIVEN; i++)
        map[expr_symbol_find(&st, name[i], 1)] = expr_div(&st, expr_int(&st, lround(10 * at[i])), expr_int(&st, 10));
    for (int i = 0; i < c->count; i++) {
        expr_id e = c->poly[i];
        expr_substitute(&st, &e, 1, map);
        all = all && poly_is_zero(&st, e, NULL) == POLY_YES;
    }
    return all;
}

static bool has(const struct poly_chains *c, const char *text)
{
    bool any = false;
    char copy[64], *save = NULL;
    expr_id e[GIVEN];
    int count = 0;
    snprintf(copy, sizeof copy, "%s", text);
    for (char *p = strtok_r(copy, ";", &save); p; p = strtok_r(NULL, ";", &save))
        e[count++] = read(p);
    for (int k = 0; k < c->chains; k++) {
        int same = 0;
        for (int i = 0; i < c->chain[k].count; i++)
            for (int h = 0; h < count; h++)
                same += c->chain[k].poly[i] == e[h];
        any |= same == count && c->chain[k].count == count;
    }
    return any;
}

static void known_zeros(const struct chain_test *t)
{
    expr_id e[GIVEN];
    int n = 0;
    struct poly_chains c;
    for (; n < GIVEN && t->given[n]; n++)
        e[n] = read(t->given[n]);
    CHECK(poly_chains_of(&st, e, n, NULL, &c), "%s", t->given[0]);
    CHECK(c.chains >= t->chains && (t->points || !c.chains), "%s: %d chains", t->given[0], c.chains);
    for (int k = 0; k < c.chains; k++)
        CHECK(c.chain[k].count <= n, "%s: %d polynomials in a chain", t->given[0], c.chain[k].count);
    for (int p = 0; p < t->points; p++) {
        bool any = false;
        for (int k = 0; k < c.chains; k++)
            any |= on(c.chain + k, t->point[p]);
        CHECK(any, "%s: point %d is on no chain", t->given[0], p);
    }
    CHECK(!t->exact || has(&c, t->exact), "%s: no chain %s", t->given[0], t->exact);
    poly_chains_clear(&c);
}

int main(void)
{
    expr_store_init(&st);
    for (const char *v = "xyzw"; *v; v++)
        expr_symbol_add(&st, (char[]){ *v, 0 }, EXPR_VARIABLE);
    expr_symbol_add(&st, "t", EXPR_TIME);
    expr_symbol_add(&st, "k", EXPR_PARAMETER);
    for (size_t i = 0; i < sizeof tests / sizeof *tests; i++)
        known_zeros(tests + i);
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
