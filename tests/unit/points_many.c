/* Points of many constraints: a chain of rods with its velocities is proved with all variables moving, with its generations and without, and
 * raised to more bits; dependent constraints are not proved. */
#include "points.h"
#include "points_space.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "check.h"
#include "differentials.h"
#include "regular_columns.h"

enum { RODS = 300, ROWS = 2 * RODS, VARIABLES = 4 * RODS + 1 };

static struct expr_store st;
static int variable[VARIABLES];        /* x, y, x', y' of each joint, and one that no constraint has */
static expr_id node[VARIABLES], con[ROWS + 1];
static double near[VARIABLES];

static expr_id symbol(int joint, int which)
{
    return joint ? node[4 * (joint - 1) + which] : expr_int(&st, 0);
}

static expr_id apart(int joint, int which)
{
    return expr_sub(&st, symbol(joint, which), symbol(joint - 1, which));
}

static void make(void)
{
    expr_store_init(&st);
    for (int v = 0; v < VARIABLES; v++) {
        char name[16];
        snprintf(name, sizeof name, "v%d", v);
        node[v] = expr_symbol_add(&st, name, EXPR_VARIABLE);
        variable[v] = st.node[node[v]].a;
    }
    near[VARIABLES - 1] = 0.7;
    for (int i = 1; i <= RODS; i++) {
        expr_id dx = apart(i, 0), dy = apart(i, 1);
        double angle = 0.9 + 0.3 * sin(i), *at = near + 4 * (i - 1);
        con[i - 1] = expr_sub(&st, expr_add(&st, expr_mul(&st, dx, dx), expr_mul(&st, dy, dy)), expr_int(&st, 1));
        con[RODS + i - 1] = expr_add(&st, expr_mul(&st, dx, apart(i, 2)), expr_mul(&st, dy, apart(i, 3)));
        at[0] = (i > 1 ? at[-4] : 0) + cos(angle);
        at[1] = (i > 1 ? at[-3] : 0) - sin(angle) + 1e-3;
        at[2] = sin(3 * i);
        at[3] = cos(2 * i);
    }
    con[ROWS] = expr_mul(&st, expr_int(&st, 2), con[RODS / 2]);
}

static void on_all(struct points_point *p, double most)
{
    int wide = 0, off = 0;
    num_ball_forget(&p->ball);
    num_ball_extend(&p->ball);
    for (int i = 0; i < ROWS; i++)
        off += !arb_contains_zero(num_ball_value(&p->ball, con[i]));
    for (int v = 0; v + 1 < VARIABLES; v++)
        wide += mag_cmp_2exp_si(arb_radref(p->ball.symbol + variable[v]), (slong)most) > 0;
    CHECK(!off, "%d constraints are not met", off);
    CHECK(!wide, "%d radii above 2^%g", wide, most);
    CHECK(mag_is_zero(arb_radref(p->ball.symbol + variable[VARIABLES - 1])), "what no constraint has stays exact");
}

static void proved(const int *end, int ends)
{
    struct points_space s = { .st = &st, .variable = variable, .variables = VARIABLES, .time = -1, .constraint = con, .constraints = ROWS, .near = near, .end = end, .ends = ends };
    struct points_point p;
    uint64_t random = 7;
    CHECK(points_find(&s, 0, &random, 192, &p) == POINTS_OK && p.certified && p.unsolved, "found");
    on_all(&p, -150);
    double far = 0;
    for (int v = 0; v < VARIABLES; v++)
        far = fmax(far, fabs(p.x[v] - near[v]));
    CHECK(far < 2, "%g from the guess", far);
    CHECK(points_refine(&s, &p, 500) && p.certified, "raised");
    on_all(&p, -450);
    points_point_clear(&p);
}

/* The joints' x and x' are regular: each rod has one of its own. With the variable of no constraint in place of one they are not, nor with the
 * velocities of both directions in place of all positions. */
static void columns(void)
{
    static const int end[] = { RODS, ROWS };
    struct points_space s = { .st = &st, .variable = variable, .variables = VARIABLES, .time = -1, .constraint = con, .constraints = ROWS, .near = near, .end = end, .ends = 2 };
    struct points_point p;
    struct points_jacobian j;
    uint64_t random = 7;
    int column[ROWS];
    CHECK(points_find(&s, 0, &random, 192, &p) == POINTS_OK, "found");
    points_jacobian_init(&j, &s);
    points_jacobian_values(&j, &p.ball);
    points_jacobian_entries(&j, &p.ball);
    for (int k = 0; k < ROWS; k++)
        column[k] = 2 * k;                 /* x and x' */
    CHECK(points_columns_regular(&j, &p, column), "x and x'");
    column[RODS] = VARIABLES - 1;
    CHECK(!points_columns_regular(&j, &p, column), "a variable of no constraint");
    for (int k = 0; k < ROWS; k++)
        column[k] = 4 * (k / 2) + 2 + k % 2;       /* x' and y' */
    CHECK(!points_columns_regular(&j, &p, column), "velocities alone");
    points_jacobian_clear(&j);
    points_point_clear(&p);
}

static void dependent(void)
{
    struct points_space s = { .st = &st, .variable = variable, .variables = VARIABLES, .time = -1, .constraint = con, .constraints = ROWS + 1, .near = near, .starts = 3 };
    struct points_point p;
    uint64_t random = 7;
    enum points_status status = points_find(&s, 0, &random, 128, &p);
    CHECK(status != POINTS_OK || !p.certified, "a constraint twice: status %d", status);
    points_point_clear(&p);
}

int main(void)
{
    static const int end[] = { RODS, ROWS };
    make();
    proved(end, 2);
    proved(NULL, 0);
    columns();
    dependent();
    expr_store_clear(&st);
    return CHECK_END();
}
