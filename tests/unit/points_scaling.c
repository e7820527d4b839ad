/* Sizes of variables from equations, against known ones; triangular points against their
 * constraints. */
#include "points_space.h"
#include "scaling.h"

#include <stdlib.h>

#include "check.h"
#include "error.h"
#include "needed_bits.h"
#include "parse.h"
#include "points.h"
#include "triangular.h"

static struct expr_store st;
static int variable[3];

static expr_id parse(const char *text)
{
    struct expr_grammar g = { .max_length = 1000, .max_depth = 100, .max_exponent = 1000, .max_digits = 1000 };
    struct sga_error err = { 0 };
    return expr_parse(&st, text, &g, &err);
}

static void sizes(void)
{
    struct scaling *w = scaling_new(&st, variable, 3);
    scaling_sum(w);
    scaling_add(w, parse("1e100*y^2 - 1e-100*x"), -1);      /* y^2 / x = 1e-200 */
    scaling_sum(w);
    scaling_add(w, parse("sin(1e50*z) - 1"), -1);           /* z = 1e-50 */
    scaling_sum(w);
    scaling_add(w, parse("x - 1e20"), -1);                  /* x = 1e20, so y = 1e-90 */
    int *scale = scaling_solve(w);
    CHECK(scale != NULL);
    if (scale) {
        CHECK(abs(scale[0] - 66) <= 1);
        CHECK(abs(scale[1] + 299) <= 1);
        CHECK(abs(scale[2] + 166) <= 1);
    }
    free(scale);
    scaling_free(w);
    w = scaling_new(&st, variable, 3);
    scaling_sum(w);
    scaling_add(w, parse("3*x - y^2 + 7"), -1);
    CHECK(scaling_solve(w) == NULL);                        /* near 1: no scale */
    scaling_free(w);
}

static void triangular(void)
{
    expr_id con[3] = { parse("x - 1e200*sin(t)"), parse("y - x^3"), parse("(2 + cos(x))*z - y^5 + 1") };
    int time = expr_symbol_find(&st, "t", 1);
    struct points_space s = { .st = &st, .variable = variable, .variables = 3, .time = time, .constraint = con, .constraints = 3 };
    struct points_point p;
    uint64_t random = 5;
    CHECK(points_find(&s, 1, &random, 192, &p) == POINTS_OK);
    CHECK(p.certified);
    num_ball_extend(&p.ball);
    for (int i = 0; i < 3; i++)
        CHECK(arb_contains_zero(num_ball_value(&p.ball, con[i])));
    CHECK(points_refine(&s, &p, 2000));
    num_ball_forget(&p.ball);
    num_ball_extend(&p.ball);
    for (int i = 0; i < 3; i++)
        CHECK(arb_contains_zero(num_ball_value(&p.ball, con[i])));
    CHECK(arb_rel_accuracy_bits(p.ball.symbol + variable[2]) > 1900);
    points_point_clear(&p);
    con[0] = parse("x^2 + y^2 - 1");                        /* not a graph */
    num_ball_init(&p.ball, &st, 100);
    p = (struct points_point){ .ball = p.ball, .variables = 3, .constraints = 1 };
    p.x = calloc(3, sizeof(double));
    p.solved = calloc(3, sizeof(int));
    for (int j = 0; j < 3; j++)
        num_ball_set_d(&p.ball, variable[j], 0.5);
    s.constraints = 1;
    CHECK(!points_triangular(&s, &p, 100, true));
    points_point_clear(&p);
}

static slong bits_of(const char *text)
{
    struct num_ball b;
    struct expr_cone c;
    expr_id e = parse(text);
    num_ball_init(&b, &st, 200);
    for (int j = 0; j < 3; j++)
        num_ball_set_d(&b, variable[j], 0.5);
    expr_cone_init(&c);
    expr_cone_of(&st, &c, &e, 1);
    num_ball_list(&b, c.list, c.count);
    slong need = points_needed_bits(&b, c.list, c.count, 0);
    num_ball_clear(&b);
    expr_cone_clear(&c);
    return need;
}

static void needed(void)
{
    CHECK(bits_of("sin(x)^2 + cos(x)^2 - 1") < 400);
    CHECK(bits_of("sin(x)^2 + cos(x)^2 - 1 + 1e-1500") > 5000);
    CHECK(bits_of("x + exp(-10000)") > 14500);
    CHECK(bits_of("tanh(2000) - 1") > 5800);
    CHECK(bits_of("atan(1e300) - pi/2") > 1000);
}

int main(void)
{
    expr_store_init(&st);
    const char *name[] = { "x", "y", "z" };
    for (int j = 0; j < 3; j++) {
        expr_symbol_add(&st, name[j], EXPR_VARIABLE);
        variable[j] = expr_symbol_find(&st, name[j], 1);
    }
    expr_symbol_add(&st, "t", EXPR_TIME);
    sizes();
    triangular();
    needed();
    expr_store_clear(&st);
    return CHECK_END();
}
