/* On which sides of the constraints' switches a zero holds: the sides that are known for each system, by hand, and the
 * values of the zero at points of the set found by this test on either side of them. */
#include "beyond.h"
#include "check.h"
#include "oracle.h"
#include "parse.h"

#include <string.h>

#include "error.h"

enum { MOST = 3 };

static struct expr_store st;
static int variable[4], parameter, variables;

static expr_id parse(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

static void begin(void)
{
    static const char *const name[] = { "x", "y", "z", "w" };
    expr_store_init(&st);
    expr_symbol_add(&st, "t", EXPR_TIME);
    for (variables = 0; variables < 4; variables++) {
        expr_symbol_add(&st, name[variables], EXPR_VARIABLE);
        variable[variables] = expr_symbol_find(&st, name[variables], 1);
    }
    expr_symbol_add(&st, "p", EXPR_PARAMETER);
    parameter = expr_symbol_find(&st, "p", 1);
}

struct example {
    const char *constraint[MOST], *zero;
    double near[4], t;
    const char *side[MOST];        /* "+x": the answer holds where x > 0; "?" before it: nothing was found beyond */
    bool searched;                 /* points were looked for */
};

static const struct example example[] = {
    /* a product that is 0 on one side of another equation's switch */
    { { "y - x*max(x, 0)" }, "z*y", { -1, 0, 1, 0 }, 0, { "-x" }, true },
    { { "y - x*abs(x)" }, "z*(y - x^2)", { 1, 1, 1, 0 }, 0, { "+x" }, true },
    { { "y - x*abs(x)" }, "z*(y + x^2)", { -1, -1, 1, 0 }, 0, { "-x" }, true },
    { { "y - max(x, w)" }, "z*(y - x)", { 2, 2, 1, 1 }, 0, { "+x - w" }, true },
    { { "y - sqrt(x^2)" }, "z*(y - x)", { 1, 1, 1, 0 }, 0, { "+x" }, true },
    /* by a chain of equations, and by time */
    { { "y - abs(x)", "w - x*y" }, "z*(w - x^2)", { 1, 1, 1, 1 }, 0, { "+x" }, true },
    { { "y - max(t - 1, 0)*x" }, "z*y", { 1, 0, 1, 0 }, 0, { "-t - 1" }, true },
    /* it holds on both sides */
    { { "y - x*abs(x)" }, "y^2 - x^4", { 1, 1, 1, 0 }, 0, { NULL }, true },
    { { "y - max(x, w) - min(x, w)" }, "y - x - w", { 2, 3, 1, 1 }, 0, { NULL }, false },
    { { "y - max(x, -x)" }, "y - abs(x)", { 1, 1, 1, 0 }, 0, { NULL }, true },
    { { "y - abs(x)" }, "(y - abs(x))*z", { 1, 1, 1, 0 }, 0, { NULL }, false },
    /* only where both change: one of them is enough */
    { { "y - max(x, 0)*max(w, 0)" }, "z*y", { -1, 0, 1, -1 }, 0, { "-w" }, true },
    { { "y - max(x, 0)*max(w, 0)" }, "z*y", { -1, 0, 1, 1 }, 0, { "-x" }, true },
    /* a switch that no chain of equations links to the zero; one with one side */
    { { "y^2 - x^2*(2 + x^2)", "w - abs(t - 5)" }, "z*(y - x*sqrt(2 + x^2))", { 1, 1.7320508, 1, 5 }, 0, { NULL }, false },
    { { "y - abs(exp(x))", "w - exp(x)" }, "z*(y - w)", { 1, 2.7, 1, 2.7 }, 0, { NULL }, false },
    { { "y - abs(w)", "w - x^2 - 1" }, "z*(y - w)", { 1, 2, 1, 2 }, 0, { "?+w" }, true },
    /* of its own, and none at all */
    { { "y - x" }, "z*(abs(x) - y)", { 1, 1, 1, 0 }, 0, { "+x" }, true },
    { { "y - x^2", "w - x*y" }, "z*(w - x^3)", { 1, 1, 1, 1 }, 0, { NULL }, false },
    /* a parameter's sign */
    { { "y - x*max(p, 0) - w" }, "z*(y - x*p - w)", { 1, 1, 1, 0 }, 0, { "+p" }, true },
};

static void sides_of(const struct example *q)
{
    expr_id con[MOST];
    int c = 0, want = 0;
    begin();
    for (; c < MOST && q->constraint[c]; c++)
        con[c] = parse(q->constraint[c]);
    expr_id e = parse(q->zero);
    struct points_space space = { .st = &st, .variable = variable, .variables = variables, .parameter = &parameter, .parameters = 1,
                                  .constraint = con, .constraints = c, .near = q->near, .near_time = q->t };
    struct points_oracle s;
    points_oracle_init(&s, 5);
    CHECK(points_oracle_sample(&s, &space) == POINTS_OK, "%s: no points", q->zero);
    struct points_decision d = points_oracle_zero(&s, e);
    CHECK(d.truth == POINTS_ZERO, "%s is 0 on the set", q->zero);
    while (want < MOST && q->side[want])
        want++;
    CHECK(s.sides == want, "%s: %d sides instead of %d", q->zero, s.sides, want);
    for (int k = 0; k < want && k < s.sides; k++) {
        bool unseen = q->side[k][0] == '?';
        const char *text = q->side[k] + unseen;
        CHECK(s.side[k].function == parse(text + 1) && s.side[k].sign == (text[0] == '+' ? 1 : -1) && s.side[k].unseen == unseen, "%s: side %s",
              q->zero, q->side[k]);
    }
    CHECK((s.beyond->work > 0) == q->searched, "%s: points beyond were looked for: %g", q->zero, s.beyond->work);
    CHECK(!s.beyond->cut_short, "%s: all of them", q->zero);
    /* a second zero of the same set costs no second search */
    double work = s.beyond->work;
    points_oracle_zero(&s, expr_mul(&st, e, parse("1 + x^2")));
    CHECK(s.beyond->work == work || !q->side[0], "%s: searched once", q->zero);
    points_oracle_clear(&s);
    expr_store_clear(&st);
}

/* More switches than are looked beyond: that is known, and nothing takes long. */
static void too_many(void)
{
    begin();
    expr_id sum = parse("y"), con[1];
    for (int k = 0; k < 400; k++)
        sum = expr_add(&st, sum, expr_fun(&st, EXPR_ABS, expr_sub(&st, parse("x"), expr_rational(&st, k, 7))));
    con[0] = expr_sub(&st, sum, expr_mul(&st, parse("x"), expr_fun(&st, EXPR_ABS, parse("w"))));
    double near[4] = { 0.3, 0, 1, 1 };
    struct points_space space = { .st = &st, .variable = variable, .variables = variables, .constraint = con, .constraints = 1, .near = near };
    struct points_oracle s;
    points_oracle_init(&s, 5);
    CHECK(points_oracle_sample(&s, &space) == POINTS_OK, "points on a set of 401 switches");
    expr_id e = expr_mul(&st, parse("z"), expr_sub(&st, sum, parse("x*w")));
    CHECK(points_oracle_zero(&s, e).truth == POINTS_ZERO, "it is 0 near the points");
    CHECK(s.beyond->cut_short, "not all switches were looked at");
    CHECK(s.beyond->work < 8e6, "within the bound: %g", s.beyond->work);
    points_oracle_clear(&s);
    expr_store_clear(&st);
}

int main(void)
{
    for (size_t i = 0; i < sizeof example / sizeof *example; i++)
        sides_of(example + i);
    too_many();
    flint_cleanup();
    return CHECK_END();
}
