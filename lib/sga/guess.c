/* What equations say of values that were not given. */
#include "guess.h"

#include <math.h>
#include <stdlib.h>

#include "ball.h"
#include "mem.h"

enum { BITS = 64 };

struct filling {
    const struct sys_system *sys;
    double *near;
    unsigned char *known;          /* by variable */
    expr_id *equation; int equations;
    int **of, *len, *open;         /* by equation: its variables, how many, how many of them are not known */
    double *sum; int *said;        /* by variable: of the values that equations say in this round, and how many do */
    int *column;                   /* by symbol: variable or -1 */
    struct expr_cone cone;
    struct num_ball ball;
};

unsigned char *guess_moving(const struct sys_system *sys)
{
    unsigned char *moving = sga_calloc((size_t)sys->variables + 1, 1);
    for (int i = 0; i < sys->rows; i++)
        for (int k = 0; k < sys->row[i].entries; k++)
            moving[sys->row[i].entry[k].col] = 1;
    return moving;
}

static void list_equations(struct filling *f)
{
    const struct sys_system *sys = f->sys;
    f->equation = sga_malloc(((size_t)(sys->rows + sys->restrictions) + 1) * sizeof *f->equation);
    for (int i = 0; i < sys->rows; i++)
        if (!sys->row[i].entries)
            f->equation[f->equations++] = sys->row[i].alpha;
    for (int i = 0; i < sys->restrictions; i++)
        f->equation[f->equations++] = sys->restriction[i];
}

static void list_variables(struct filling *f)
{
    f->of = sga_calloc((size_t)f->equations + 1, sizeof *f->of);
    f->len = sga_calloc((size_t)f->equations + 1, sizeof *f->len);
    f->open = sga_calloc((size_t)f->equations + 1, sizeof *f->open);
    for (int i = 0; i < f->equations; i++) {
        expr_cone_of(f->sys->store, &f->cone, f->equation + i, 1);
        f->of[i] = sga_malloc(((size_t)f->cone.count + 1) * sizeof **f->of);
        for (int k = 0; k < f->cone.count; k++) {
            const struct expr_node *n = f->sys->store->node + f->cone.list[k];
            if (n->op == EXPR_SYM && f->column[n->a] >= 0)
                f->of[i][f->len[i]++] = f->column[n->a];
        }
    }
}

static void begin(struct filling *f, double time, const double *parameter_near)
{
    const struct sys_system *sys = f->sys;
    struct expr_store *st = sys->store;
    f->column = sga_malloc(((size_t)st->symbols + 1) * sizeof *f->column);
    for (int i = 0; i < st->symbols; i++)
        f->column[i] = -1;
    for (int j = 0; j < sys->variables; j++)
        f->column[sys->variable[j].symbol] = j;
    f->sum = sga_calloc((size_t)sys->variables + 1, sizeof *f->sum);
    f->said = sga_calloc((size_t)sys->variables + 1, sizeof *f->said);
    expr_cone_init(&f->cone);
    num_ball_init(&f->ball, st, BITS);
    list_equations(f);
    list_variables(f);
    for (int j = 0; j < sys->variables; j++)
        num_ball_set_d(&f->ball, sys->variable[j].symbol, f->near[j]);
    for (int k = 0; k < sys->parameters; k++) {
        double v = parameter_near ? parameter_near[k] : NAN;
        num_ball_set_d(&f->ball, sys->parameter[k], isfinite(v) ? v : 1.25);
    }
    if (sys->time >= 0)
        num_ball_set_d(&f->ball, sys->time, time);
}

static void end(struct filling *f)
{
    for (int i = 0; i < f->equations; i++)
        free(f->of[i]);
    free(f->of);
    free(f->len);
    free(f->open);
    free(f->equation);
    free(f->column);
    free(f->sum);
    free(f->said);
    free(f->known);
    num_ball_clear(&f->ball);
    expr_cone_clear(&f->cone);
}

static double value_with(struct filling *f, expr_id e, int symbol, double v)
{
    num_ball_set_d(&f->ball, symbol, v);
    num_ball_list(&f->ball, f->cone.list, f->cone.count);
    arb_srcptr y = num_ball_value(&f->ball, e);
    return arb_is_finite(y) ? arf_get_d(arb_midref(y), ARF_RND_NEAR) : NAN;
}

/* What equation i says of its one variable j that is not known: NaN where it is not affine in it. */
static double said_of(struct filling *f, int i, int j)
{
    int symbol = f->sys->variable[j].symbol;
    expr_id e = f->equation[i];
    expr_cone_of(f->sys->store, &f->cone, &e, 1);
    double y[4];
    for (int k = 0; k < 4; k++)
        y[k] = value_with(f, e, symbol, k == 3 ? -3.5 : k);
    double slope = y[1] - y[0], size = fabs(y[0]) + fabs(slope);
    bool affine = fabs(y[2] - y[0] - 2 * slope) <= 1e-9 * size && fabs(y[3] - y[0] + 3.5 * slope) <= 1e-9 * size;
    num_ball_set_d(&f->ball, symbol, f->near[j]);
    return affine && fabs(slope) > 1e-9 * fabs(y[0]) ? -y[0] / slope : NAN;
}

/* Values that equations say now; of several the mean. Returns how many are new. */
static int round_of(struct filling *f)
{
    int new = 0;
    for (int i = 0; i < f->equations; i++) {
        int j = -1, open = 0;
        for (int k = 0; k < f->len[i]; k++)
            if (!f->known[f->of[i][k]]) {
                j = f->of[i][k];
                open++;
            }
        bool before = f->open[i] == 1;     /* asked in an earlier round, in vain */
        f->open[i] = open;
        double v = open == 1 && !before ? said_of(f, i, j) : NAN;
        if (isfinite(v)) {
            f->sum[j] += v;
            f->said[j]++;
        }
    }
    for (int j = 0; j < f->sys->variables; j++)
        if (f->said[j]) {
            f->near[j] = f->sum[j] / f->said[j];
            num_ball_set_d(&f->ball, f->sys->variable[j].symbol, f->near[j]);
            f->known[j] = 1;
            f->said[j] = 0;
            f->sum[j] = 0;
            new++;
        }
    return new;
}

void guess_complete(const struct sys_system *sys, const unsigned char *given, double time, const double *parameter_near, double *near)
{
    struct filling f = { .sys = sys, .near = near };
    unsigned char *moving = guess_moving(sys);
    f.known = sga_calloc((size_t)sys->variables + 1, 1);
    for (int j = 0; j < sys->variables; j++)
        f.known[j] = given[j];
    begin(&f, time, parameter_near);
    while (round_of(&f) > 0)
        ;
    for (int j = 0; j < sys->variables; j++)
        f.known[j] |= moving[j];
    while (round_of(&f) > 0)
        ;
    end(&f);
    free(moving);
}
