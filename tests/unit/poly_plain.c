/* Values and zeros on a set: known texts, and random functions at exact points of the set. */
#include <string.h>

#include "buf.h"
#include "check_read.h"
#include "error.h"
#include "poly.h"
#include "print.h"
#include "random_expr.h"

static struct expr_store st;
enum { MOST = 1000000 };

static expr_id read(const char *text)
{
    return check_read(&st, text);
}

static void is_text(const char *from, expr_id e, const char *to)
{
    struct sga_buf b = { 0 };
    bool ok = e && expr_print(&st, e, 0, &b);
    CHECK(ok && strcmp(b.data, to) == 0, "%s: %s, should be %s", from, ok ? b.data : "", to);
    sga_buf_free(&b);
}

static void on_set(const char *from, const char *by1, const char *by2, const char *to)
{
    expr_id root[3] = { read(from), read(by1), read(by2) }, out = EXPR_UNDEF;
    struct poly_bridge *b = poly_bridge_new(&st, root, 3, NULL);
    bool found = b && poly_bridge_on_set(b, root[0], root + 1, 2, MOST, &out);
    if (to)
        is_text(from, found ? out : EXPR_UNDEF, to);
    else
        CHECK(!found, "%s became something else", from);
    poly_bridge_free(b);
}

static void zeros(const char *from, const char *by, const char *to, const char *times)
{
    expr_id root[2] = { read(from), read(by) }, out = EXPR_UNDEF, scale = EXPR_UNDEF;
    bool reduced;
    struct poly_bridge *b = poly_bridge_new(&st, root, 2, NULL);
    CHECK(b && poly_bridge_zeros(b, root[0], root + 1, 1, MOST, &out, &scale, &reduced), "%s", from);
    is_text(from, out, to);
    is_text(from, scale, times);
    poly_bridge_free(b);
}

/* x = 2s/(1 + s^2), y = (1 - s^2)/(1 + s^2), u = -w y, v = w x: a point of x^2 + y^2 = 1, x u + y v = 0. */
static void point(struct random_source *r, expr_id *map)
{
    expr_id one = expr_int(&st, 1), s = expr_rational(&st, 1 + random_below(r, 20), 1 + random_below(r, 9));
    expr_id w = expr_rational(&st, random_below(r, 19) - 9, 1 + random_below(r, 5)), ss = expr_mul(&st, s, s);
    map[0] = expr_div(&st, expr_mul(&st, expr_int(&st, 2), s), expr_add(&st, one, ss));
    map[1] = expr_div(&st, expr_sub(&st, one, ss), expr_add(&st, one, ss));
    map[2] = expr_neg(&st, expr_mul(&st, w, map[1]));
    map[3] = expr_mul(&st, w, map[0]);
    map[4] = expr_rational(&st, 1 + random_below(r, 30), 7);
}

static expr_id at(expr_id e, const expr_id *map)
{
    expr_substitute(&st, &e, 1, map);
    *st.error = (struct sga_error){ 0 };
    return e && expr_is_const(&st, e) ? e : EXPR_UNDEF;
}

static void same_values(struct random_source *r)
{
    expr_id pool[16], root[3], out, scale, *map = calloc((size_t)st.symbols, sizeof *map);
    int n = 0;
    for (; n < 5; n++)
        pool[n] = st.symbol[n].node;
    while (n < 16) {
        expr_id e = random_rational(r, &st, pool + (n > 6 ? n - 6 : 0), 6 < n ? 6 : n);
        *st.error = (struct sga_error){ 0 };
        pool[n++] = e ? e : pool[random_below(r, 5)];
    }
    root[0] = pool[15];
    root[1] = read("x^2 + y^2 - 1");
    root[2] = read("x*u + y*v");
    bool reduced;
    struct poly_bridge *b = poly_bridge_new(&st, root, 3, NULL);
    bool found = b && poly_bridge_on_set(b, root[0], root + 1, 2, MOST, &out);
    bool zero = b && poly_bridge_zeros(b, root[0], root + 1, 2, MOST, &scale, &scale, &reduced);
    expr_id z = EXPR_UNDEF;
    zero = zero && poly_bridge_zeros(b, root[0], root + 1, 2, MOST, &z, &scale, &reduced);
    for (int k = 0; k < 4; k++) {
        point(r, map);
        expr_id was = at(root[0], map), is = found ? at(out, map) : was;
        CHECK(!was || was == is, "another value on the set");
        if (was && zero) {
            expr_id p = at(z, map), q = at(scale, map);
            CHECK(p && q && expr_mul(&st, p, q) == was, "the zeros times the scale are another function on the set");
        }
    }
    poly_bridge_free(b);
    free(map);
}

int main(void)
{
    static const char *const name[] = { "x", "y", "u", "v", "l" };
    expr_store_init(&st);
    st.max_bits = 100000;
    for (int i = 0; i < 5; i++)
        expr_symbol_add(&st, name[i], EXPR_VARIABLE);
    expr_symbol_add(&st, "g", EXPR_PARAMETER);
    on_set("(-4*y*l*v - 4*x*l*u - 3*g*v)/(x^2 + y^2)", "x^2 + y^2 - 1", "x*u + y*v", "-3*g*v");
    on_set("x*y*l + 2*l", "x - 3", "y", "2*l");
    on_set("x + 2*y", "u^2 + v", "x*u + y*v", NULL);
    on_set("sin(x)^2*u + y", "sin(x)^2 - l", "v", "u*l + y");
    on_set("1/(x^2 + y^2)", "x^2 + y^2 - g^2", "v", "1/g^2");
    zeros("-2*x*u - 2*y*v", "l", "x*u + y*v", "-2");
    zeros("x/3 - y/2", "l", "2*x - 3*y", "1/6");
    zeros("y/2 - x/3", "l", "2*x - 3*y", "-1/6");
    zeros("(x - u)/l", "v", "u - x", "-1/l");
    zeros("2*(x^2 + y^2)*l - 2*u^2 - 2*v^2 + 981*y/50", "x^2 + y^2 - 1", "100*u^2 + 100*v^2 - 100*l - 981*y", "-1/50");
    struct random_source r = { check_seed(20261122) };
    for (int k = check_scale(300); k > 0; k--)
        same_values(&r);
    expr_store_clear(&st);
    return CHECK_END();
}
