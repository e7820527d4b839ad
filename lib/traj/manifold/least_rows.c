/* See least_rows.h. */
#include "least_rows.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "jacobian.h"
#include "mem.h"
#include "tape.h"

bool least_rows_init(struct least_rows *r, const struct expr_store *st, const expr_id *root, int roots, const int *input, struct sga_error *err)
{
    r->all = r->n * (1 + r->q);
    r->count = (roots - r->first) / (1 + r->q);
    assert(r->first + r->count * (1 + r->q) == roots);       /* each constraint with all of its derivatives */
    r->value = num_tape_new(st, root, roots, input, r->all + 1 + r->more, err);
    r->jac = r->value ? num_jacobian_new(r->value, NULL, 0) : NULL;
    if (!r->jac)
        return false;
    r->in = sga_calloc((size_t)(r->all + 1 + r->more + roots + r->jac->nnz) + 1, sizeof *r->in);
    r->out = r->in + r->all + 1 + r->more;
    r->entry = r->out + roots;
    return true;
}

void least_rows_clear(struct least_rows *r)
{
    num_jacobian_free(r->jac);
    num_tape_free(r->value);
    free(r->in);
    *r = (struct least_rows){ 0 };
}

void least_rows_load(struct least_rows *r, double t, const double *x, const double *S)
{
    memcpy(r->in, x, (size_t)r->n * sizeof *r->in);
    if (S)
        memcpy(r->in + r->n, S, (size_t)(r->all - r->n) * sizeof *r->in);
    else
        memset(r->in + r->n, 0, (size_t)(r->all - r->n) * sizeof *r->in);
    r->in[r->all] = t;
}

bool least_rows_at(struct least_rows *r, double t, const double *x, const double *S)
{
    least_rows_load(r, t, x, S);
    return num_jacobian_eval(r->jac, r->in, r->out, r->entry);
}

double least_rows_gradient(const struct least_rows *r, int root, double *g)
{
    double by_time = 0;
    memset(g, 0, (size_t)r->n * sizeof *g);
    for (int k = r->jac->start[root]; k < r->jac->start[root + 1]; k++)
        if (r->jac->col[k] < r->n)
            g[r->jac->col[k]] = r->entry[k];
        else if (r->jac->col[k] == r->all)
            by_time = r->entry[k];
    return by_time;
}
