/* Like terms together: known texts, and the same values at exact points. */
#include <string.h>

#include "buf.h"
#include "check.h"
#include "collect.h"
#include "error.h"
#include "parse.h"
#include "print.h"
#include "random_expr.h"

static struct expr_store st;
static const char *const name[] = { "x", "y", "z", "a" };
enum { NAMES = 4 };

static void text(const char *from, const char *to)
{
    struct sga_error err = { 0 };
    struct sga_buf b = { 0 };
    expr_id e = expr_parse(&st, from, NULL, &err);
    CHECK(e, "%s: %s", from, err.detail);
    expr_collect(&st, &e, 1);
    bool ok = expr_print(&st, e, 0, &b);
    CHECK(ok && strcmp(b.data, to) == 0, "%s: %s, should be %s", from, ok ? b.data : "", to);
    sga_buf_free(&b);
}

/* A constant, or EXPR_UNDEF where e has no value. */
static expr_id at(expr_id e, const expr_id *map)
{
    expr_substitute(&st, &e, 1, map);
    *st.error = (struct sga_error){ 0 };
    return e && expr_is_const(&st, e) ? e : EXPR_UNDEF;
}

static void same_values(struct random_source *r)
{
    expr_id pool[24], map[NAMES], before;
    int n = 0;
    for (; n < NAMES; n++)
        pool[n] = st.symbol[n].node;
    pool[n++] = expr_rational(&st, 1 + random_below(r, 5), 1 + random_below(r, 4));
    while (n < 24) {
        expr_id e = random_rational(r, &st, pool + (n > 8 ? n - 8 : 0), n > 8 ? 8 : n);
        *st.error = (struct sga_error){ 0 };
        pool[n++] = e ? e : pool[random_below(r, NAMES)];
    }
    expr_id root = before = pool[n - 1];
    expr_collect(&st, &root, 1);
    CHECK(root && expr_store_ok(&st), "an expression was lost");
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < NAMES; i++)
            map[i] = expr_rational(&st, random_below(r, 13) - 6, 1 + random_below(r, 5));
        expr_id was = at(before, map), is = at(root, map);
        struct sga_buf p = { 0 }, q = { 0 };
        expr_print(&st, before, 2000, &p);
        expr_print(&st, root, 2000, &q);
        CHECK(!was || was == is, "%s became %s", p.data ? p.data : "", q.data ? q.data : "");
        sga_buf_free(&p);
        sga_buf_free(&q);
    }
}

int main(void)
{
    expr_store_init(&st);
    st.max_bits = 20000;
    for (int i = 0; i < NAMES; i++)
        expr_symbol_add(&st, name[i], i < 3 ? EXPR_VARIABLE : EXPR_PARAMETER);
    text("x + x + 1/2 + 1", "2*x + 3/2");
    text("x + y - 3*x + 2*(x - 1)", "y - 2");
    text("-1*x*y + y*x*2", "x*y");
    text("x*y*x/y^2", "x^2/y");
    text("(a*x + a*y)*z", "a*z*(x + y)");
    text("a^2*x - a*y", "a*(a*x - y)");
    text("x/a + y/a", "(x + y)/a");
    text("sin(x + x - y + y/2)", "sin(2*x - y/2)");
    text("3*(x + 2)/6 - 1", "x/2");
    text("(x + y)^2*(y + x)", "(x + y)^3");
    text("x - x", "0");
    struct random_source r = { check_seed(20261122) };
    for (int k = check_scale(400); k > 0; k--)
        same_values(&r);
    expr_store_clear(&st);
    return CHECK_END();
}
