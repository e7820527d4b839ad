/* The choice of states: what moves with an input's derivative must follow from the constraints; then those follow whose derivatives no equation has, as far as
 * the constraints determine them well (a multiplier is no state where coordinates can be); of the others those whose differentials the constraints
 * determine best, the last named ones first. */
#include "linear_coordinates.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "kinds.h"
#include "mem.h"
#include "natural.h"
#include "oracle.h"
#include "reduction.h"
#include "system.h"

/* A pivot is as good as the best one when it is this large beside it: then the later variable is taken. */
static const double AS_GOOD = 0.1;
/* What elimination in doubles leaves of a column that is none; and what is a good pivot beside a row's largest entry. */
static const double NOTHING = 1e-10, WELL = 1e-3;
/* Of what moves with an input's derivative anything does that is no rounding: it comes first, and else nothing can be said. */
static const double ANYTHING = 1e-14;

static const char *name_of(const struct linear_request *rq, int variable)
{
    return rq->sys->store->symbol[rq->sys->variable[variable].symbol].name;
}

/* By index of an input, -1: none. */
static int input_of(const struct linear_request *rq, int variable)
{
    for (int k = 0; k < rq->inputs; k++)
        if (rq->input[k].variable == variable)
            return k;
    return -1;
}

/* Is variable j moved by free functions, on Pf? */
static bool moves(const struct linear_request *rq, int j)
{
    const struct sga_solution *sol = rq->sol;
    for (int k = 0; k < sol->free_columns; k++) {
        expr_id e = sol->gauge[(size_t)k * (size_t)rq->sys->variables + (size_t)j];
        if (!expr_is_zero(rq->sys->store, e) && points_oracle_zero(rq->oracle, e).truth != POINTS_ZERO)
            return true;
    }
    return false;
}

/* Up to a few names of what moves and is no input. */
static bool refuse_freedom(const struct linear_request *rq, const unsigned char *moving, int left, struct sga_error *err)
{
    char names[300] = "";
    int listed = 0;
    for (int j = 0; j < rq->sys->variables; j++) {
        size_t n = strlen(names);
        if (!moving[j] || input_of(rq, j) >= 0 || listed++ >= 8)
            continue;
        snprintf(names + n, sizeof names - n, "%s%.40s", n ? ", " : "", name_of(rq, j));
    }
    return sga_fail_at(err, SGA_E_INPUTS, "/linearization/inputs", "the equations leave %d function%s of time to be chosen that no input names; it moves %s: name "
                       "inputs among them in %s, %sor add equations that determine them", left, left == 1 ? "" : "s", names, rq->said_in,
                       strcmp(rq->said_in, "linearization.inputs") ? "" : "take what they leave of least norm (linearization.gauge), ");
}

/* The gauge's components of the inputs that are variables, a row each. */
static bool input_gauge(const struct linear_request *rq, struct linear_place *place, struct linear_matrix *out)
{
    SGA_ARENA(mem);
    int g = rq->sol->free_columns, rows = 0;
    expr_id *e = sga_zeros(&mem, (size_t)rq->inputs * (size_t)g + 1, sizeof *e);
    for (int i = 0; i < rq->inputs; i++) {
        for (int k = 0; k < g && rq->input[i].variable >= 0; k++)
            e[rows * g + k] = rq->sol->gauge[(size_t)k * (size_t)rq->sys->variables + (size_t)rq->input[i].variable];
        rows += rq->input[i].variable >= 0;
    }
    return linear_place_matrix(place, e, rows, g, out);
}

/* Inputs are the freedom: as many, and each can be chosen. */
static bool check_inputs(const struct linear_request *rq, struct linear_place *place, const unsigned char *moving, struct sga_error *err)
{
    struct linear_matrix g;
    int least = 0;
    bool ok = input_gauge(rq, place, &g) || sga_fail(err, SGA_E_UNDECIDED, "the gauge fields have no value at the point");
    int inputs = linear_rows(&g);
    bool known = ok && linear_matrix_rank(&g, &least);
    linear_matrix_clear(&g);
    if (!ok)
        return false;
    for (int i = 0; i < rq->inputs; i++)
        if (rq->input[i].variable >= 0 && !moving[rq->input[i].variable])
            return sga_fail_at(err, SGA_E_INPUTS, "/linearization/inputs", "%.100s cannot be chosen as a function of time: its derivative is determined on the final "
                               "set; name what is left free%s", rq->input[i].name,
                               rq->sol->free_columns ? " (gauge says what moves)" : " (nothing is; give it as a table, or leave it out)");
    if (least < inputs)
        return sga_fail_at(err, known ? SGA_E_INPUTS : SGA_E_UNDECIDED, "/linearization/inputs", "the inputs cannot be chosen independently of each other: %d of "
                           "%d can%s", least, inputs, known ? "" : ", as far as is known");
    return least == rq->sol->free_columns || refuse_freedom(rq, moving, rq->sol->free_columns - least, err);
}

/* In natural units (log2 of them by column, or NULL: 1), each row over its largest entry. */
static double *doubles(struct sga_arena *mem, const struct linear_matrix *J, int cols, const int *scale)
{
    double *m = sga_take(mem, ((size_t)linear_rows(J) * (size_t)cols + 1) * sizeof *m);
    for (int i = 0; i < linear_rows(J); i++) {
        double size = 0;
        for (int k = 0; k < cols; k++)
            size = fmax(size, fabs(m[i * cols + k] = ldexp(linear_matrix_double(J, i, k), scale ? scale[k] : 0)));
        for (int k = 0; k < cols && size > 0; k++)
            m[i * cols + k] /= size;
    }
    return m;
}

/* The entry to divide by, of rows that are left and columns that are allowed, larger than least; false: there is none. */
static bool pivot(const double *m, int rows, int cols, int from, const unsigned char *allowed, double least, int *row, int *col)
{
    double best = least;
    for (int i = from; i < rows; i++)
        for (int k = 0; k < cols; k++)
            if (allowed[k])
                best = fmax(best, fabs(m[i * cols + k]));
    for (int k = cols - 1; k >= 0; k--)
        for (int i = from; i < rows && allowed[k]; i++)
            if (fabs(m[i * cols + k]) > least && fabs(m[i * cols + k]) >= AS_GOOD * best) {
                *row = i;
                *col = k;
                return true;
            }
    return false;
}

static void eliminate(double *m, int rows, int cols, int at, int row, int col)
{
    for (int k = 0; k < cols; k++) {
        double t = m[at * cols + k];
        m[at * cols + k] = m[row * cols + k];
        m[row * cols + k] = t;
    }
    for (int i = at + 1; i < rows; i++) {
        double f = m[i * cols + col] / m[at * cols + col];
        for (int k = 0; k < cols && f != 0; k++)
            m[i * cols + k] -= f * m[at * cols + k];
    }
}

/* Those that follow, by elimination; false: fewer than rows. */
static bool follow(struct linear_coordinates *c, const struct linear_request *rq, double *m, int rows, const unsigned char *moving, unsigned char *taken)
{
    enum { MOVING, FOLLOWING, ALL, PARTS };
    int n = rq->sys->variables, row = 0, col = 0;
    SGA_FREED unsigned char *allowed = sga_calloc(2 * (size_t)n + 1, 1);
    unsigned char *kind = allowed + n;
    sys_kinds(rq->sys, kind);
    c->follows = 0;
    memset(taken, 0, (size_t)n);
    for (int part = 0; part < PARTS; part++) {
        for (int j = 0; j < n; j++)
            allowed[j] = !taken[j] && input_of(rq, j) < 0 && (part == ALL || (part == MOVING ? moving[j] : kind[j] >= SYS_ALGEBRAIC));
        while (c->follows < rows && pivot(m, rows, n, c->follows, allowed, part == FOLLOWING ? WELL : part == MOVING ? ANYTHING : NOTHING, &row, &col)) {
            eliminate(m, rows, n, c->follows, row, col);
            c->follow[c->follows++] = col;
            allowed[col] = 0;
            taken[col] = 1;
        }
    }
    return c->follows == rows;
}

/* In natural units, so that the choice is that of other units too; as they are where these guesses do not do. */
static bool follow_any(struct linear_coordinates *c, struct sga_arena *mem, const struct linear_request *rq, const struct linear_matrix *J, const unsigned char *moving,
                       unsigned char *taken)
{
    int n = rq->sys->variables, rows = linear_rows(J);
    double time;
    SGA_FREED int *scale = natural_sizes(rq->sys, &time);
    return (scale && follow(c, rq, doubles(mem, J, n, scale), rows, moving, taken)) || follow(c, rq, doubles(mem, J, n, NULL), rows, moving, taken);
}

bool linear_coordinates_choose(struct linear_coordinates *c, struct sga_arena *mem, const struct linear_request *rq, struct linear_place *place,
                               const struct linear_matrix *J, struct sga_error *err)
{
    int n = rq->sys->variables, rows = linear_rows(J);
    assert(linear_cols(J) >= n && rows == rq->sol->constraints);
    unsigned char *moving = sga_zeros(mem, (size_t)n + 1, 1), *taken = sga_zeros(mem, (size_t)n + 1, 1);
    *c = (struct linear_coordinates){ .follow = sga_take(mem, ((size_t)rows + 1) * sizeof *c->follow), .state = sga_take(mem, ((size_t)n + 1) * sizeof *c->state),
                                      .moving = -1 };
    for (int j = 0; j < n; j++)
        moving[j] = moves(rq, j);
    if (!check_inputs(rq, place, moving, err))
        return false;
    if (!follow_any(c, mem, rq, J, moving, taken))
        return sga_fail_at(err, SGA_E_UNDECIDED, "/linearization/at", "the differentials of the constraints were not found to be independent at this point; choose another");
    for (int j = 0; j < n; j++) {
        if (taken[j] || input_of(rq, j) >= 0)
            continue;
        if (moving[j] && c->moving < 0)
            c->moving = j;
        c->state[c->states++] = j;
    }
    return true;
}
