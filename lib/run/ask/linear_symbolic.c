/* Elimination on the final set, and products with gradients. */
#include "linear_symbolic.h"

#include <assert.h>
#include <string.h>

#include "ask_work.h"
#include "derive.h"
#include "error.h"
#include "linear_gradients.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "system.h"
#include "weak.h"

/* Entries that are longer are null. */
enum { SHOWN_BYTES = 4000 };

struct symbolic {
    struct ask_work *s;
    const struct linear_request *rq;
    struct expr_store *st;
    struct weak weak;
    struct weak_pivots pivots;     /* what was divided by */
    struct sga_arena mem;
    struct linear_gradients g;     /* columns: variables, then inputs that are tables */
    int n;                         /* variables */
    int *input_column;             /* by input: of the gradients */
    expr_id *held;                 /* by variable: the field that holds the inputs */
    int *state; int states;
    int *follow; int follows;
    expr_id *phi;                  /* columns of the gradients x (states, inputs) */
    struct sga_error *err;
};

static expr_id gauge(const struct symbolic *y, int field, int variable)
{
    return y->rq->sol->gauge[(size_t)field * (size_t)y->n + (size_t)variable];
}

static bool is_input(const struct symbolic *y, int variable)
{
    for (int i = 0; i < y->rq->inputs; i++)
        if (y->rq->input[i].variable == variable)
            return true;
    return false;
}

/* Up to a few names of what the free functions move, and no input names. */
static bool refuse_freedom(const struct symbolic *y, int left)
{
    SGA_ENDS(sga_buf_free) struct sga_buf names = { 0 };
    int listed = 0;
    for (int j = 0; j < y->n && listed < 8; j++) {
        bool moves = false;
        for (int k = 0; k < y->rq->sol->free_columns; k++)
            moves |= !expr_is_zero(y->st, gauge(y, k, j));
        if (moves && !is_input(y, j))
            sga_buf_printf(&names, "%s%.40s", listed++ ? ", " : "", answer_variable_name(y->s->j, j));
    }
    return sga_fail_at(y->err, SGA_E_INPUTS, "/linearization/inputs", "the equations leave %d function%s of time to be chosen that no input names; it moves %.400s: name "
                       "inputs among them in %s, take what they leave of least norm (linearization.gauge), or add equations that determine them", left, left == 1 ? "" : "s", names.data, y->rq->said_in);
}

/* X + sum of f Y with Y_u f = -X_u: rows [Y_u | -X_u] by elimination. */
static bool hold_inputs(struct symbolic *y)
{
    const struct sga_solution *sol = y->rq->sol;
    int g = sol->free_columns, width = g + 1, rows = 0, rank = 0;
    expr_id *m = sga_zeros(&y->mem, (size_t)y->rq->inputs * (size_t)width + 1, sizeof *m);
    int *pivot = sga_zeros(&y->mem, (size_t)g + 1, sizeof *pivot);
    for (int i = 0; i < y->rq->inputs; i++) {
        int u = y->rq->input[i].variable;
        bool moves = false;
        if (u < 0)
            continue;
        for (int k = 0; k < g; k++) {
            m[rows * width + k] = gauge(y, k, u);
            moves |= !expr_is_zero(y->st, gauge(y, k, u));
        }
        m[rows++ * width + g] = expr_neg(y->st, sol->field[u]);
        if (!moves)
            return sga_fail_at(y->err, SGA_E_INPUTS, "/linearization/inputs", "%.100s cannot be chosen as a function of time: its derivative is determined on the final set; name "
                               "what is left free%s", y->rq->input[i].name, g ? " (gauge says what moves)" : " (nothing is; give it as a table, or leave it out)");
    }
    if (!weak_eliminate(&y->weak, m, rows, g, width, pivot))
        return false;
    for (int k = 0; k < g; k++)
        rank += pivot[k] >= 0;
    if (rank < rows)
        return sga_fail_at(y->err, SGA_E_INPUTS, "/linearization/inputs", "the inputs cannot be chosen independently of each other: %d of %d can", rank, rows);
    if (rank < g)
        return refuse_freedom(y, g - rank);
    y->held = sga_zeros(&y->mem, (size_t)y->n + 1, sizeof *y->held);
    for (int j = 0; j < y->n; j++) {
        expr_id e = sol->field[j];
        for (int k = 0; k < g; k++)
            e = expr_add(y->st, e, expr_mul(y->st, m[pivot[k] * width + g], gauge(y, k, j)));
        y->held[j] = weak_normal(&y->weak, e);
    }
    return true;
}

/* Variables that may follow, those first that shall: without a derivative in the equations, then the later ones, velocities as a rule. */
static int order(const struct symbolic *y, int *list)
{
    const struct sys_system *sys = y->rq->sys;
    int count = 0;
    SGA_ARENA(mem);
    unsigned char *derived = sga_zeros(&mem, (size_t)y->n + 1, 1);
    for (int i = 0; i < sys->rows; i++)
        for (int k = 0; k < sys->row[i].entries; k++)
            derived[sys->row[i].entry[k].col] = 1;
    for (int part = 0; part < 2; part++)
        for (int j = y->n - 1; j >= 0; j--)
            if (derived[j] == part && !is_input(y, j))
                list[count++] = j;
    return count;
}

/* J Phi = 0, a unit matrix at states and inputs. */
static bool find_tangent(struct symbolic *y)
{
    const struct sga_solution *sol = y->rq->sol;
    int c = sol->constraints, inputs = y->rq->inputs, d, columns, width;
    int *list = sga_take(&y->mem, ((size_t)y->n + 1) * sizeof *list), *pivot = sga_zeros(&y->mem, (size_t)y->n + 1, sizeof *pivot);
    expr_id *constraint = sga_take(&y->mem, ((size_t)c + 1) * sizeof *constraint);
    for (int i = 0; i < c; i++)
        constraint[i] = sol->constraint[i].expr;
    const expr_id *J = linear_gradients_of(&y->g, &y->mem, constraint, c);
    const char *rate = linear_gradients_rate(y->rq, constraint, c);
    if (rate)
        return sga_fail_at(y->err, SGA_E_IMPROPER, "/linearization/inputs", "the derivative of %.100s enters the reduced motion: there is no state form from it alone; give that derivative as "
                           "a table of its own", rate);
    columns = order(y, list);
    width = columns + inputs;
    expr_id *m = sga_zeros(&y->mem, (size_t)c * (size_t)width + 1, sizeof *m), zero = expr_int(y->st, 0);
    for (int i = 0; i < c; i++)
        for (int k = 0; k < width; k++) {
            expr_id e = J[(size_t)i * (size_t)y->g.cols + (size_t)(k < columns ? list[k] : y->input_column[k - columns])];
            m[i * width + k] = e ? e : zero;
        }
    if (!weak_eliminate(&y->weak, m, c, columns, width, pivot))
        return false;
    y->follow = sga_take(&y->mem, ((size_t)y->n + 1) * sizeof *y->follow);
    y->state = sga_take(&y->mem, ((size_t)y->n + 1) * sizeof *y->state);
    for (int j = 0; j < y->n; j++)               /* states in the order of the variables */
        for (int k = 0; k < columns; k++)
            if (list[k] == j && pivot[k] < 0)
                y->state[y->states++] = j;
    d = y->states + inputs;
    y->phi = sga_take(&y->mem, ((size_t)y->g.cols * (size_t)d + 1) * sizeof *y->phi);
    for (int k = 0; k < y->g.cols * d; k++)
        y->phi[k] = zero;
    for (int k = 0; k < y->states; k++)
        y->phi[y->state[k] * d + k] = expr_int(y->st, 1);
    for (int k = 0; k < inputs; k++)
        y->phi[y->input_column[k] * d + y->states + k] = expr_int(y->st, 1);
    for (int p = 0; p < columns; p++) {
        if (pivot[p] < 0)
            continue;
        y->follow[y->follows++] = list[p];
        for (int k = 0; k < d; k++) {
            int at = columns + k - y->states;
            for (int q = 0; k < y->states && q < columns; q++)
                at = list[q] == y->state[k] ? q : at;
            y->phi[list[p] * d + k] = expr_neg(y->st, m[pivot[p] * width + at]);
        }
    }
    if (y->follows < c)
        return sga_fail_at(y->err, SGA_E_INPUTS, "/linearization/inputs", "the constraints ask something of the inputs alone: leave one of them out");
    assert(y->states + y->follows + (y->n - columns) == y->n);
    return true;
}

/* Entry of gradients times Phi. */
static expr_id product(const struct symbolic *y, const expr_id *gradient, int k)
{
    int d = y->states + y->rq->inputs;
    expr_id sum = expr_int(y->st, 0);
    for (int j = 0; j < y->g.cols; j++)
        if (gradient[j] && !expr_is_zero(y->st, y->phi[j * d + k]))
            sum = expr_add(y->st, sum, expr_mul(y->st, gradient[j], y->phi[j * d + k]));
    return weak_normal(&y->weak, sum);
}

static void put(const struct symbolic *y, expr_id e)
{
    expr_json(y->st, e, SHOWN_BYTES, &y->s->json);
}

/* Columns [from, to) of the products of rows of gradients. */
static void write_products(const struct symbolic *y, const char *key, const expr_id *gradient, int rows, int from, int to)
{
    struct sga_json *w = &y->s->json;
    sga_json_key(w, key);
    sga_json_array(w);
    for (int i = 0; i < rows; i++) {
        sga_json_array(w);
        for (int k = from; k < to; k++)
            put(y, product(y, gradient + (size_t)i * (size_t)y->g.cols, k));
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

static void write_names(const struct symbolic *y, const int *variable, int count)
{
    struct sga_json *w = &y->s->json;
    sga_json_key(w, "names");
    sga_json_array(w);
    for (int k = 0; k < count; k++)
        sga_json_string(w, answer_variable_name(y->s->j, variable[k]));
    sga_json_end_array(w);
}

/* Entries of rows at these columns, EXPR_UNDEF for 0. */
static void write_entries(const struct symbolic *y, const char *key, const expr_id *entry, int rows, int width, const int *column, int columns)
{
    struct sga_json *w = &y->s->json;
    sga_json_key(w, key);
    sga_json_array(w);
    for (int i = 0; i < rows; i++) {
        sga_json_array(w);
        for (int k = 0; k < columns; k++) {
            expr_id e = column[k] < width ? entry[(size_t)i * (size_t)width + (size_t)column[k]] : EXPR_UNDEF;
            put(y, e ? weak_normal(&y->weak, e) : expr_int(y->st, 0));
        }
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

/* Rows A x' = alpha, then restrictions: entries of A, and gradients of alpha - A v at the velocity v. */
static void gather_rows(const struct symbolic *y, expr_id *entry, expr_id *gradient)
{
    const struct sys_system *sys = y->rq->sys;
    SGA_ARENA(mem);
    for (int i = 0; i < sys->rows + sys->restrictions; i++) {
        const struct sys_row *r = sys->row + i;
        expr_id e = i < sys->rows ? r->alpha : sys->restriction[i - sys->rows], *to = gradient + (size_t)i * (size_t)y->g.cols;
        memcpy(to, linear_gradients_of(&y->g, &mem, &e, 1), (size_t)y->g.cols * sizeof *to);
        for (int k = 0; i < sys->rows && k < r->entries; k++) {
            entry[(size_t)i * (size_t)y->n + (size_t)r->entry[k].col] = r->entry[k].value;
            if (expr_is_const(y->st, r->entry[k].value))
                continue;
            const expr_id *da = linear_gradients_of(&y->g, &mem, &r->entry[k].value, 1);
            for (int j = 0; j < y->g.cols; j++)
                if (da[j]) {
                    expr_id term = expr_mul(y->st, da[j], y->held[r->entry[k].col]);
                    to[j] = to[j] ? expr_sub(y->st, to[j], term) : expr_neg(y->st, term);
                }
        }
    }
}

static void write_given(struct symbolic *y, const expr_id *doutput)
{
    const struct sys_system *sys = y->rq->sys;
    struct sga_json *w = &y->s->json;
    int rows = sys->rows + sys->restrictions, columns = 0;
    expr_id *entry = sga_zeros(&y->mem, (size_t)rows * (size_t)y->n + 1, sizeof *entry), *gradient = sga_zeros(&y->mem, (size_t)rows * (size_t)y->g.cols + 1, sizeof *gradient);
    int *column = sga_take(&y->mem, ((size_t)y->n + 1) * sizeof *column);
    bool rates = false;
    for (int j = 0; j < y->n; j++)
        if (!is_input(y, j))
            column[columns++] = j;
    gather_rows(y, entry, gradient);
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < y->rq->inputs; k++)
            rates |= y->rq->input[k].variable >= 0 && entry[(size_t)i * (size_t)y->n + (size_t)y->rq->input[k].variable] != EXPR_UNDEF;
    sga_json_key(w, "descriptor");
    sga_json_object(w);
    write_names(y, column, columns);
    write_entries(y, "E", entry, rows, y->n, column, columns);
    if (rates)
        write_entries(y, "F", entry, rows, y->n, y->input_column, y->rq->inputs);
    write_entries(y, "A", gradient, rows, y->g.cols, column, columns);
    write_entries(y, "B", gradient, rows, y->g.cols, y->input_column, y->rq->inputs);
    write_entries(y, "C", doutput, y->rq->outputs, y->g.cols, column, columns);
    write_entries(y, "D", doutput, y->rq->outputs, y->g.cols, y->input_column, y->rq->inputs);
    sga_json_end_object(w);
}

static void write_evidence(const struct symbolic *y)
{
    static const char why[] = "the matrices are expressions: ask at places with values for numbers";
    struct sga_json *w = &y->s->json;
    static const char *const member[] = { "eigenvalues", "stable", "stability" };
    for (int k = 0; k < 3; k++) {
        sga_json_key(w, member[k]);
        sga_json_null(w);
    }
    sga_json_key(w, "evidence");
    sga_json_object(w);
    sga_json_key(w, "constant");
    sga_json_null(w);
    sga_json_key(w, "equilibrium");
    sga_json_null(w);
    sga_json_member_string(w, "matrices", "symbolic");
    sga_json_key(w, "assumed_not_zero");
    sga_json_array(w);
    for (int k = 0; k < y->pivots.count; k++)
        if (!expr_is_const(y->st, y->pivots.e[k]))
            put(y, y->pivots.e[k]);
    sga_json_end_array(w);
    sga_json_member_string(w, "eigenvalues", why);
    sga_json_member_string(w, "stability", why);
    sga_json_end_object(w);
}

/* A state that moves with an input's derivative has no state form but at equilibria. */
static bool check_states(const struct symbolic *y)
{
    for (int k = 0; k < y->states; k++)
        for (int g = 0; g < y->rq->sol->free_columns; g++) {
            int is = weak_zero(&y->weak, gauge(y, g, y->state[k]));
            if (is < 0)
                return false;
            if (!is)
                return sga_fail_at(y->err, SGA_E_IMPROPER, "/linearization/inputs", "%.100s moves with the derivative of an input: there is a state form at equilibria only; linearize at one, or "
                                   "take what moves as an input", answer_variable_name(y->s->j, y->state[k]));
        }
    return true;
}

static bool write(struct symbolic *y)
{
    struct sga_json *w = &y->s->json;
    const struct linear_request *rq = y->rq;
    int inputs = rq->inputs, states = y->states;
    expr_id *rate = sga_take(&y->mem, ((size_t)states + 1) * sizeof *rate);
    for (int k = 0; k < states; k++)
        rate[k] = y->held[y->state[k]];
    const char *name = linear_gradients_rate(rq, rate, states);
    name = name ? name : linear_gradients_rate(rq, rq->output, rq->outputs);
    if (name)
        return sga_fail_at(y->err, SGA_E_IMPROPER, "/linearization/inputs", "the derivative of %.100s enters the reduced motion: there is no state form from it alone; give that derivative as "
                           "a table of its own", name);
    const expr_id *drate = linear_gradients_of(&y->g, &y->mem, rate, states), *doutput = linear_gradients_of(&y->g, &y->mem, rq->output, rq->outputs);
    sga_json_object(w);
    sga_json_key(w, "t");
    sga_json_null(w);
    sga_json_key(w, "point");
    sga_json_null(w);
    linear_write_ports(&y->s->ports, w);
    sga_json_key(w, "state");
    sga_json_object(w);
    write_names(y, y->state, states);
    write_products(y, "A", drate, states, 0, states);
    write_products(y, "B", drate, states, states, states + inputs);
    write_products(y, "C", doutput, rq->outputs, 0, states);
    write_products(y, "D", doutput, rq->outputs, states, states + inputs);
    sga_json_end_object(w);
    write_given(y, doutput);
    write_evidence(y);
    sga_json_end_object(w);
    return expr_store_ok(y->st) || sga_fail(y->err, y->st->error->code, "%s", y->st->error->detail);
}

bool linear_symbolic(struct ask_work *s)
{
    struct job *j = s->j;
    struct symbolic y = { .s = s, .rq = &s->rq, .st = &j->request->store, .n = j->request->system.variables, .err = j->err };
    if (y.n > LINEAR_MOST)
        return sga_fail(j->err, SGA_E_LIMIT_VARIABLES, "the system has %d variables; it is linearized up to %d", y.n, LINEAR_MOST);
    y.pivots.mem = &y.mem;
    y.weak = (struct weak){ y.st, j->oracle, j->budget, j->err, &y.pivots };
    linear_gradients_init(&y.g, &y.mem, y.rq);
    y.input_column = sga_take(&y.mem, ((size_t)y.rq->inputs + 1) * sizeof *y.input_column);
    for (int k = 0, signal = y.n; k < y.rq->inputs; k++)
        y.input_column[k] = y.rq->input[k].variable >= 0 ? y.rq->input[k].variable : signal++;
    bool ok = hold_inputs(&y) && find_tangent(&y) && check_states(&y) && write(&y);
    sga_arena_end(&y.mem);
    return ok && job_goes_on(j) && answer_fits(j, s->json.out);
}
