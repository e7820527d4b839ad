/* Conditions on parameters in parts: what each part puts in fulfils the condition, and every point that fulfils it lies in a part. */
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "cases.h"
#include "check_read.h"
#include "print.h"
#include "system.h"

static struct expr_store st;
static struct sys_system sys;

static expr_id read(const char *text)
{
    return check_read(&st, text);
}

/* "a=...; b=..." of each part, by the place it was found. */
static void show(const struct cases *c, struct sga_buf *out)
{
    for (int i = 0; i < c->parts; i++) {
        sga_buf_puts(out, c->part[i].open ? "[open" : "[");
        for (int k = 0; k < c->part[i].puts; k++) {
            sga_buf_printf(out, "%s=", st.symbol[c->part[i].put[k].symbol].name);
            expr_print(&st, c->part[i].put[k].value, 0, out);
            sga_buf_puts(out, ";");
        }
        sga_buf_puts(out, "]");
    }
}

/* A condition of up to two functions, in how many parts it falls, and what one of them looks like. */
static void parts(void)
{
    static const struct { const char *f, *g; int parts; const char *one; } cases[] = {
        { "a - 1", NULL, 1, "a=1;" }, { "a*b", NULL, 2, "b=0;" }, { "a^2 - 2", NULL, 2, "a=-sqrt(2);" },
        { "a^2 + 1", NULL, 0, "" }, { "a^2 + b^2", NULL, 1, "a=0;" }, { "a^3 - 2", NULL, 1, "a=cbrt(2);" },
        { "a*d - b*c", NULL, 3, "[d=0;b=0;]" }, { "a^4 - 2", NULL, 2, "a=sqrt(sqrt(2));" },
        { "a^4 - 3*a^2 + 1", NULL, 4, "" }, { "a^2 + a*b + b^2", NULL, 1, "b=0;" },
        { "a", "b", 1, "b=0;" }, { "a*b", "a*c", 2, "a=0;" }, { "a", "a - 1", 0, "" }, { "a*b - 1", "a", 0, "" },
        { "(a - 1)^2*(b + 2)", NULL, 2, "b=-2;" }, { "a^5 - a - 1", NULL, 1, "[open" }, { "exp(a) - 2", NULL, 1, "a=log(2);" }, { "exp(a) + 1", NULL, 0, "" },
        { "sqrt(a) - b", "b - 3", 1, "a=9;" }, { "a^3 - 3*a + 1", NULL, 3, "cos(" }, { "sin(a)", NULL, 1, "[open" }, { "a^2 - b", "a - 2", 1, "b=4;" },
        { "a^2 + 2*a*b + b^2 - 1", NULL, 2, "" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expr_id f[2] = { read(cases[i].f), cases[i].g ? read(cases[i].g) : EXPR_UNDEF };
        struct cases c;
        struct sga_buf text = { 0 };
        cases_of(&sys, f, cases[i].g ? 2 : 1, NULL, 0, NULL, &c);
        show(&c, &text);
        CHECK(c.parts == cases[i].parts && !c.cut && (!text.data || strstr(text.data, cases[i].one)), "%s: %d %s", cases[i].f, c.parts,
              text.data ? text.data : "");
        bool algebraic = !strstr(cases[i].f, "exp") && !strstr(cases[i].f, "a^3 - 3");     /* others are no polynomials in their roots */
        for (int k = 0; k < c.parts && algebraic; k++)
            for (int q = 0; q < (cases[i].g ? 2 : 1) && !c.part[k].open; q++)
                CHECK(cases_zero_on(&sys, c.part + k, f[q]), "%s: part %d", cases[i].f, k);
        sga_buf_free(&text);
        cases_clear(&c);
    }
}

static void excluded(void)
{
    expr_id f = read("a*b"), not = read("b");
    struct cases c;
    cases_of(&sys, &f, 1, &not, 1, NULL, &c);
    CHECK(c.parts == 1 && strcmp(st.symbol[c.part[0].put[0].symbol].name, "a") == 0, "what must not vanish does not");
    cases_clear(&c);
}

static void samples(void)
{
    static const struct { const char *f; const char *one; } cases[] = {
        { "a - 1", "\"a\":\"1\"" }, { "a^2 - 2", "[\"-1.41421356237309504881\",\"-1.41421356237309504880\"]" },
        { "a^3 - a - 3", "[\"1.67169988165716096974\",\"1.67169988165716096975\"]" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expr_id f = read(cases[i].f);
        struct cases c;
        struct sga_buf json = { 0 };
        cases_of(&sys, &f, 1, NULL, 0, NULL, &c);
        CHECK(c.parts && cases_sample(&sys, c.part, NULL, 0, &json) && strstr(json.data, cases[i].one), "%s: %s", cases[i].f,
              json.data ? json.data : "none");
        sga_buf_free(&json);
        cases_clear(&c);
    }
}

int main(void)
{
    expr_store_init(&st);
    sys_init(&sys, &st);
    const char *const name[] = { "d", "c", "b", "a" };       /* what is chosen does not depend on this order */
    for (int i = 0; i < 4; i++) {
        expr_symbol_add(&st, name[i], EXPR_PARAMETER);
        sys_add_parameter(&sys, expr_symbol_find(&st, name[i], 1));
    }
    parts();
    excluded();
    samples();
    sys_clear(&sys);
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
