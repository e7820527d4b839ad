/* Rows A(t) x' = alpha(x, u, t) as operators: entry (i, j) is A_ij D - d alpha_i / d x_j. */
#include "transfer_moving.h"

#include <stdio.h>

#include "ask_work.h"
#include "flint_ends.h"
#include "from_expr.h"
#include "linear_gradients.h"
#include "popov.h"
#include "run_job.h"
#include "system.h"

struct moving {
    const struct linear_request *rq;
    struct linear_gradients g;         /* columns: variables, then inputs that are tables */
    struct sga_arena mem;
    int *column;                       /* of the gradients: the unknown that it is, or -1 - the input */
    int rows, unknowns;
    char *why;
};

static void set_columns(struct moving *m)
{
    const struct linear_request *rq = m->rq;
    m->column = sga_zeros(&m->mem, (size_t)m->g.cols + 1, sizeof *m->column);
    for (int k = 0, signal = rq->sys->variables; k < rq->inputs; k++)
        m->column[rq->input[k].variable >= 0 ? rq->input[k].variable : signal++] = -1 - k;
    for (int j = 0; j < rq->sys->variables; j++)
        if (m->column[j] >= 0)
            m->column[j] = m->unknowns++;
}

/* x += factor e D^order; false where e is no rational function of time. */
static bool add(const struct moving *m, struct ore *x, expr_id e, int order, bool minus)
{
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t a;
    fmpz_poly_q_init(a);
    if (op_from_exprs(a, m->rq->sys->store, &e, 1, m->rq->sys->time, m->why) != 1)
        return false;
    if (minus)
        fmpz_poly_q_neg(a, a);
    ore_add_term(x, a, order);
    return true;
}

/* The entry of column j goes to its matrix: unknowns to P, inputs to B. */
static struct ore *place(const struct moving *m, struct ore_matrix *P, struct ore_matrix *B, int row, int j)
{
    int to = m->column[j];
    return to >= 0 ? ore_at(P, row, to) : ore_at(B, row, -1 - to);
}

/* Functions e: their gradients, times -1 for unknowns where they are right sides. */
static bool functions(const struct moving *m, const expr_id *e, int count, int from, bool right, struct ore_matrix *P, struct ore_matrix *B)
{
    SGA_ARENA(mem);
    const expr_id *gradient = linear_gradients_of(&m->g, &mem, e, count);
    const char *rate = linear_gradients_rate(m->rq, e, count);
    if (rate)
        snprintf(m->why, 160, "the derivative of the table %.80s enters", rate);
    bool ok = !rate;
    if (ok && !linear_gradients_rational(&m->g, e, count)) {
        snprintf(m->why, 160, "a function of the variables that is not affine enters");
        ok = false;
    }
    for (int i = 0; i < count && ok; i++)
        for (int j = 0; j < m->g.cols && ok; j++) {
            expr_id d = gradient[(size_t)i * (size_t)m->g.cols + (size_t)j];
            if (d)
                ok = add(m, place(m, P, B, from + i, j), d, 0, right && m->column[j] >= 0);
        }
    return ok;
}

static bool equations(const struct moving *m, struct ore_matrix *P, struct ore_matrix *B)
{
    const struct sys_system *sys = m->rq->sys;
    SGA_ARENA(mem);
    expr_id *e = sga_take(&mem, ((size_t)m->rows + 1) * sizeof *e);
    for (int i = 0; i < m->rows; i++)
        e[i] = i < sys->rows ? sys->row[i].alpha : sys->restriction[i - sys->rows];
    if (!functions(m, e, m->rows, 0, true, P, B))
        return false;
    for (int i = 0; i < sys->rows; i++)
        for (int k = 0; k < sys->row[i].entries; k++) {
            int j = sys->row[i].entry[k].col;
            if (!add(m, place(m, P, B, i, j), sys->row[i].entry[k].value, 1, m->column[j] < 0))
                return false;
        }
    return true;
}

bool transfer_moving(struct op_fraction *f, enum op_fraction_status *status, const struct ask_work *s, bool *linear, char *why, struct sga_error *err)
{
    const struct linear_request *rq = &s->rq;
    struct moving m = { .rq = rq, .rows = rq->sys->rows + rq->sys->restrictions, .why = why };
    struct op_limits limits = { .budget = rq->budget };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix P = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix B = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix C = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix E = { 0 };
    *f = (struct op_fraction){ .which = -1 };
    linear_gradients_init(&m.g, &m.mem, rq);
    set_columns(&m);
    ore_matrix_init(&P, m.rows, m.unknowns);
    ore_matrix_init(&B, m.rows, rq->inputs);
    ore_matrix_init(&C, rq->outputs, m.unknowns);
    ore_matrix_init(&E, rq->outputs, rq->inputs);
    *linear = equations(&m, &P, &B) && functions(&m, rq->output, rq->outputs, 0, false, &C, &E);
    if (*linear)
        *status = op_fraction_find(f, &P, &B, &C, &E, &limits, err);
    sga_arena_end(&m.mem);
    return *linear && *status != OP_FRACTION_FAILED;
}
