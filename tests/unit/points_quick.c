/* Constraints and their differentials in doubles against those in balls, and what doubles leave to these. */
#include "points.h"
#include "points_space.h"

#include <math.h>
#include <stdlib.h>

#include "check.h"
#include "differentials.h"
#include "quick.h"

enum { VARIABLES = 5, ROWS = 7 };

static struct expr_store st;
static expr_id node[VARIABLES], parameter, time_node, con[ROWS];
static int variable[VARIABLES], given;

static expr_id sum(expr_id a, expr_id b) { return expr_add(&st, a, b); }
static expr_id product(expr_id a, expr_id b) { return expr_mul(&st, a, b); }

static void make(void)
{
    static const char *const name[VARIABLES] = { "a", "b", "c", "d", "e" };
    expr_store_init(&st);
    for (int v = 0; v < VARIABLES; v++) {
        node[v] = expr_symbol_add(&st, name[v], EXPR_VARIABLE);
        variable[v] = st.node[node[v]].a;
    }
    parameter = expr_symbol_add(&st, "p", EXPR_PARAMETER);
    given = st.node[parameter].a;
    time_node = expr_symbol_add(&st, "t", EXPR_TIME);
    con[0] = sum(product(node[0], node[1]), expr_int(&st, -2));
    con[1] = sum(expr_fun(&st, EXPR_SIN, product(node[2], parameter)), expr_div(&st, node[3], sum(product(node[4], node[4]), expr_int(&st, 1))));
    con[2] = expr_sub(&st, expr_fun(&st, EXPR_EXP, node[0]), expr_powi(&st, node[3], 3));
    con[3] = expr_sub(&st, expr_fun(&st, EXPR_SQRT, sum(product(node[1], node[1]), expr_int(&st, 3))), time_node);
    con[4] = sum(node[2], product(expr_rational(&st, 1, 3), node[4]));
    con[5] = expr_sub(&st, product(product(node[0], node[2]), node[4]), expr_powi(&st, node[1], -2));
    con[6] = sum(expr_fun2(&st, EXPR_ATAN2, node[3], sum(product(node[0], node[0]), expr_int(&st, 1))), node[1]);
}

static void same(double quick, double ball, double size, int row)
{
    CHECK(fabs(quick - ball) <= 1e-12 * size, "row %d: %.17g in doubles, %.17g in balls", row, quick, ball);
}

/* At random points; columns stand where points_jacobian has them. */
static void agree(struct points_jacobian *j, struct points_quick *q, struct points_point *p, double **row)
{
    unsigned long state = check_seed(3);
    for (int turn = 0; turn < 50; turn++) {
        for (int v = 0; v < VARIABLES; v++) {
            state = state * 6364136223846793005ul + 1442695040888963407ul;
            p->x[v] = (double)(state >> 33) / (1ul << 30) - 1 + 0.01;
            num_ball_set_d(&p->ball, variable[v], p->x[v]);
        }
        p->parameter[0] = 1.5;
        p->t = 0.3 + turn;
        num_ball_set_d(&p->ball, given, p->parameter[0]);
        num_ball_set_d(&p->ball, j->space->time, p->t);
        CHECK(points_quick_at(q, j, p, row));
        points_jacobian_values(j, &p->ball);
        points_jacobian_entries(j, &p->ball);
        for (int i = 0; i < ROWS; i++) {
            double size = 1;
            for (int k = 0; k < j->cols[i]; k++)
                size = fmax(size, fabs(row[i][k]));
            same(q->value[i], points_scaled(num_ball_value(&p->ball, con[i]), 0), size, i);
            for (int k = 0; k < j->cols[i]; k++)
                same(row[i][k], points_scaled(j->entry[i] + k, 0), size, i);
        }
    }
}

/* Past the range of doubles, where a row is 0, and where there is no value. */
static void refuse(struct points_jacobian *j, struct points_quick *q, struct points_point *p, double **row)
{
    static const double bad[][2] = { { 1e200, 1 }, { 0, 0 }, { 800, 1 }, { NAN, 1 } };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        for (int v = 0; v < VARIABLES; v++)
            p->x[v] = 0.5 + 0.1 * v;
        CHECK(points_quick_at(q, j, p, row));
        p->x[0] = bad[k][0];
        p->x[1] = bad[k][1];
        row[4][0] = 17;
        CHECK(!points_quick_at(q, j, p, row) && row[4][0] == 17, "%zu: balls are to be asked", k);
    }
}

int main(void)
{
    make();
    struct points_space s = { .st = &st, .variable = variable, .variables = VARIABLES, .parameter = &given, .parameters = 1, .time = st.node[time_node].a,
                              .constraint = con, .constraints = ROWS };
    struct points_jacobian j;
    struct points_quick q;
    double x[VARIABLES], value[1], entry[ROWS][VARIABLES], *row[ROWS];
    struct points_point p = { .x = x, .parameter = value, .variables = VARIABLES, .parameters = 1, .constraints = ROWS };
    for (int i = 0; i < ROWS; i++)
        row[i] = entry[i];
    num_ball_init(&p.ball, &st, 128);
    points_jacobian_init(&j, &s);
    points_quick_init(&q, &j);
    CHECK(q.tape);
    agree(&j, &q, &p, row);
    refuse(&j, &q, &p, row);
    points_quick_clear(&q);
    CHECK(!points_quick_at(&q, &j, &p, row), "nothing to ask");
    points_jacobian_clear(&j);
    num_ball_clear(&p.ball);
    expr_store_clear(&st);
    return CHECK_END();
}
