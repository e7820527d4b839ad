/* What equations say of values that were not given. */
#include "guess.h"

#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "ball.h"
#include "mem.h"
#include "system.h"

enum { BITS = 64 };

struct filling {
    struct sga_arena mem;
    const struct sys_system *sys;
    double *near;
    unsigned char *known;          /* by variable */
    expr_id *equation; int equations;
    int **of, *len;                /* by equation: its variables, how many */
    unsigned char *says; double *value;   /* by equation: what it says of its last open variable (enum says), and that */
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
    f->equation = sga_take(&f->mem, ((size_t)(sys->rows + sys->restrictions) + 1) * sizeof *f->equation);
    for (int i = 0; i < sys->rows; i++)
        if (!sys->row[i].entries)
            f->equation[f->equations++] = sys->row[i].alpha;
    for (int i = 0; i < sys->restrictions; i++)
        f->equation[f->equations++] = sys->restriction[i];
}

static void list_variables(struct filling *f)
{
    f->of = sga_zeros(&f->mem, (size_t)f->equations + 1, sizeof *f->of);
    f->len = sga_zeros(&f->mem, (size_t)f->equations + 1, sizeof *f->len);
    f->says = sga_zeros(&f->mem, (size_t)f->equations + 1, 1);
    f->value = sga_zeros(&f->mem, (size_t)f->equations + 1, sizeof *f->value);
    for (int i = 0; i < f->equations; i++) {
        expr_cone_of(f->sys->store, &f->cone, f->equation + i, 1);
        f->of[i] = sga_take(&f->mem, ((size_t)f->cone.count + 1) * sizeof **f->of);
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
    f->column = sga_take(&f->mem, ((size_t)st->symbols + 1) * sizeof *f->column);
    for (int i = 0; i < st->symbols; i++)
        f->column[i] = -1;
    for (int j = 0; j < sys->variables; j++)
        f->column[sys->variable[j].symbol] = j;
    f->sum = sga_zeros(&f->mem, (size_t)sys->variables + 1, sizeof *f->sum);
    f->said = sga_zeros(&f->mem, (size_t)sys->variables + 1, sizeof *f->said);
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
    sga_arena_end(&f->mem);
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

/* What an equation says of its one variable that is not known. */
enum says { NOT_ASKED, NOTHING, DEFINES, SAYS_HERE };      /* the slope is a number; or it is one at these values only */

/* e along the variable: value at 0 and slope. False: it is not affine in it. */
static bool line(struct filling *f, expr_id e, int symbol, double out[2])
{
    double y[4];
    for (int k = 0; k < 4; k++)
        y[k] = value_with(f, e, symbol, k == 3 ? -3.5 : k);
    double slope = y[1] - y[0], size = fabs(y[0]) + fabs(slope);
    out[0] = y[0];
    out[1] = slope;
    return fabs(y[2] - y[0] - 2 * slope) <= 1e-9 * size && fabs(y[3] - y[0] + 3.5 * slope) <= 1e-9 * size && fabs(slope) > 1e-9 * fabs(y[0]);
}

/* Whether the slope is the same where the other variables are elsewhere. */
static bool is_number(struct filling *f, int i, int j, double slope)
{
    double other[2];
    for (int k = 0; k < f->len[i]; k++) {
        int v = f->of[i][k];
        num_ball_set_d(&f->ball, f->sys->variable[v].symbol, 1.21 * f->near[v] + 0.37);
    }
    bool same = line(f, f->equation[i], f->sys->variable[j].symbol, other) && fabs(other[1] - slope) <= 1e-9 * fabs(slope);
    for (int k = 0; k < f->len[i]; k++)
        num_ball_set_d(&f->ball, f->sys->variable[f->of[i][k]].symbol, f->near[f->of[i][k]]);
    return same;
}

static void ask(struct filling *f, int i, int j)
{
    double at[2];
    expr_cone_of(f->sys->store, &f->cone, f->equation + i, 1);
    bool affine = line(f, f->equation[i], f->sys->variable[j].symbol, at);
    f->says[i] = !affine ? NOTHING : is_number(f, i, j, at[1]) ? DEFINES : SAYS_HERE;
    f->value[i] = affine ? -at[0] / at[1] : NAN;
    num_ball_set_d(&f->ball, f->sys->variable[j].symbol, f->near[j]);
}

/* The one variable of equation i that is not known; -1: there are none, or several. */
static int one_open(const struct filling *f, int i)
{
    int j = -1, open = 0;
    for (int k = 0; k < f->len[i]; k++)
        if (!f->known[f->of[i][k]]) {
            j = f->of[i][k];
            open++;
        }
    return open == 1 ? j : -1;
}

/* Values that equations say now, of this kind; of several the mean. Returns how many are new. */
static int round_of(struct filling *f, enum says kind)
{
    int new = 0;
    for (int i = 0; i < f->equations; i++) {
        int j = f->says[i] == NOTHING ? -1 : one_open(f, i);
        if (j >= 0 && f->says[i] == NOT_ASKED)
            ask(f, i, j);
        if (j >= 0 && f->says[i] == kind && isfinite(f->value[i])) {
            f->sum[j] += f->value[i];
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

/* Definitions first: a product is one with the factors that the values make. */
static void fill(struct filling *f)
{
    while (round_of(f, DEFINES) > 0 || round_of(f, SAYS_HERE) > 0)
        ;
}

void guess_complete(const struct sys_system *sys, const unsigned char *given, double time, const double *parameter_near, double *near)
{
    struct filling f = { .sys = sys, .near = near };
    SGA_FREED unsigned char *moving = guess_moving(sys);
    f.known = sga_zeros(&f.mem, (size_t)sys->variables + 1, 1);
    for (int j = 0; j < sys->variables; j++)
        f.known[j] = given[j];
    begin(&f, time, parameter_near);
    fill(&f);
    for (int j = 0; j < sys->variables; j++)
        f.known[j] |= moving[j];
    fill(&f);
    end(&f);
}
