/* Free functions as derivatives of inputs. */
#include "linear_held.h"

#include "poly.h"
#include "reduction.h"
#include "system.h"

static expr_id gauge(const struct linear_request *rq, int field, int variable)
{
    return rq->sol->gauge[(size_t)field * (size_t)rq->sys->variables + (size_t)variable];
}

static expr_id simplified(struct expr_store *st, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, NULL);
    expr_id out;
    return !expr_is_const(st, e) && poly_normal(st, e, &limits, &out) ? out : e;
}

static bool not_zero(struct linear_place *place, expr_id e)
{
    struct linear_matrix v;
    bool ok = linear_place_matrix(place, &e, 1, 1, &v) && (v.exact ? !fmpq_is_zero(fmpq_mat_entry(v.q, 0, 0)) : !arb_contains_zero(arb_mat_entry(v.b, 0, 0)));
    linear_matrix_clear(&v);
    return ok;
}

/* [M | r] of m rows, brought to [1 | f] by Gauss-Jordan steps. */
static bool eliminate(struct expr_store *st, struct linear_place *place, expr_id *M, int m)
{
    int cols = m + 1;
    for (int k = 0; k < m; k++) {
        int row = k;
        while (row < m && !not_zero(place, M[row * cols + k]))
            row++;
        if (row == m)
            return false;
        for (int c = 0; c < cols; c++) {
            expr_id t = M[row * cols + c];
            M[row * cols + c] = M[k * cols + c];
            M[k * cols + c] = t;
        }
        for (int c = cols - 1; c >= k; c--)
            M[k * cols + c] = simplified(st, expr_div(st, M[k * cols + c], M[k * cols + k]));
        for (int i = 0; i < m; i++)
            for (int c = cols - 1; c >= k && i != k; c--)
                M[i * cols + c] = simplified(st, expr_sub(st, M[i * cols + c], expr_mul(st, M[i * cols + k], M[k * cols + c])));
    }
    return true;
}

/* Rows of inputs that are variables; their number is that of the gauge fields. False: nothing has to be solved. */
static bool equations(const struct linear_request *rq, expr_id *M)
{
    struct expr_store *st = rq->sys->store;
    int g = rq->sol->free_columns, row = 0;
    bool any = false;
    for (int i = 0; i < rq->inputs && row < g; i++) {
        int u = rq->input[i].variable;
        if (u < 0)
            continue;
        for (int k = 0; k < g; k++)
            M[row * (g + 1) + k] = gauge(rq, k, u);
        M[row++ * (g + 1) + g] = expr_neg(st, rq->sol->field[u]);
        any |= !expr_is_zero(st, rq->sol->field[u]);
    }
    return any;
}

const expr_id *linear_held_field(struct sga_arena *mem, const struct linear_request *rq, struct linear_place *place)
{
    struct expr_store *st = rq->sys->store;
    int n = rq->sys->variables, g = rq->sol->free_columns;
    expr_id *M = sga_zeros(mem, (size_t)g * (size_t)(g + 1) + 1, sizeof *M), *field = sga_take(mem, ((size_t)n + 1) * sizeof *field);
    if (!equations(rq, M))
        return rq->sol->field;
    if (!eliminate(st, place, M, g))
        return NULL;
    for (int j = 0; j < n; j++) {
        field[j] = rq->sol->field[j];
        for (int k = 0; k < g; k++)
            field[j] = expr_add(st, field[j], expr_mul(st, M[k * (g + 1) + g], gauge(rq, k, j)));
        field[j] = simplified(st, field[j]);
    }
    return field;
}

/* Components of the gauge fields: a row for each field. */
static bool components(const struct linear_request *rq, struct linear_place *place, const int *variable, int count, struct linear_matrix *out)
{
    SGA_ARENA(mem);
    int g = rq->sol->free_columns;
    expr_id *e = sga_zeros(&mem, (size_t)g * (size_t)count + 1, sizeof *e);
    for (int k = 0; k < g; k++)
        for (int i = 0; i < count; i++)
            e[k * count + i] = gauge(rq, k, variable[i]);
    return linear_place_matrix(place, e, g, count, out);
}

bool linear_held_shift(const struct linear_request *rq, struct linear_place *place, const int *state, int states, struct linear_matrix *out)
{
    SGA_ARENA(mem);
    int *input = sga_take(&mem, ((size_t)rq->inputs + 1) * sizeof *input), *column = sga_take(&mem, ((size_t)rq->inputs + 1) * sizeof *column), inputs = 0;
    for (int i = 0; i < rq->inputs; i++)
        if (rq->input[i].variable >= 0) {
            column[inputs] = i;
            input[inputs++] = rq->input[i].variable;
        }
    struct linear_matrix u, z, b;
    bool ok = components(rq, place, input, inputs, &u);
    ok = components(rq, place, state, states, &z) && ok;
    ok = linear_matrix_solve(&b, &u, &z) && ok;          /* inputs x states */
    linear_matrix_init(out, states, rq->inputs);
    out->exact = b.exact;
    for (int i = 0; i < inputs; i++)
        for (int k = 0; k < states; k++) {
            fmpq_set(fmpq_mat_entry(out->q, k, column[i]), fmpq_mat_entry(b.q, i, k));
            arb_set(arb_mat_entry(out->b, k, column[i]), arb_mat_entry(b.b, i, k));
        }
    linear_matrix_clear(&u);
    linear_matrix_clear(&z);
    linear_matrix_clear(&b);
    return ok;
}
