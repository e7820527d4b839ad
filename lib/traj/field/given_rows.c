/* The equations without derivatives at a start. */
#include "given_rows.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "field.h"
#include "jacobian.h"
#include "mem.h"
#include "sizes.h"
#include "system.h"
#include "tape.h"
#include "told.h"

/* Of what an equation adds up, and of its variables: what is missed by more does not hold. */
static const double MISSED = 1e-6;

/* The equations, and which rows they are; returns how many. */
static int without_derivatives(const struct sys_system *sys, expr_id *equation, int *row)
{
    int count = 0;
    for (int i = 0; i < sys->rows; i++)
        if (!sys->row[i].entries) {
            equation[count] = sys->row[i].alpha;
            row[count++] = i;
        }
    return count;
}

/* What is missed, over what equation i becomes where one of its variables is another by its own size, or by its unit. */
static double distance(const struct sizes *s, const struct num_jacobian *jac, const double *slope, const double *x, int i, double miss)
{
    double steep = 0;
    for (int k = jac->start[i]; k < jac->start[i + 1]; k++)
        steep = fmax(steep, fabs(slope[k]) * fmax(s->unit[jac->col[k]], fabs(x[jac->col[k]])));
    return steep > 0 ? fabs(miss) / steep : 0;
}

bool given_rows_hold(const struct sys_system *sys, const struct traj_request *rq, const double *x, struct sga_error *err)
{
    int n = sys->variables;
    struct sizes s;
    expr_id *equation = sga_malloc(((size_t)sys->rows + 1) * sizeof *equation);
    int *row = sga_malloc(((size_t)sys->rows + (size_t)n + 2) * sizeof *row), *columns = row + sys->rows, count = without_derivatives(sys, equation, row);
    struct sga_error none = { 0 };
    bool ok = true;
    for (int j = 0; j < n; j++)
        columns[j] = j;
    int *inputs = field_inputs(sys);
    struct num_tape *tape = count ? num_tape_new(sys->store, equation, count, inputs, n + 1, &none) : NULL;
    struct num_jacobian *jac = tape ? num_jacobian_new(tape, columns, n) : NULL;
    if (jac) {
        sizes_init(&s, sys, rq);
        double *in = sga_malloc(((size_t)n + (size_t)count + (size_t)jac->nnz + 2) * sizeof *in), *miss = in + n + 1, *slope = miss + count;
        memcpy(in, x, (size_t)n * sizeof *in);
        in[n] = rq->start;
        bool valued = num_jacobian_eval(jac, in, miss, slope);
        SGA_ENDS(told_end) struct told_place told;
        told_begin(&told, sys, NULL, in);
        for (int i = 0; i < count && valued && ok; i++) {
            if (!(distance(&s, jac, slope, x, i, miss[i]) > MISSED))
                continue;
            double sum = told_rounding(&told, equation[i]) / DBL_EPSILON;
            if (fabs(miss[i]) > MISSED * sum)
                ok = sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial", "no consistent start was found: where the constraints hold as far as their digits tell, %s misses by %.3g, where its "
                                 "terms are of size %.3g; give trajectory.initial nearer to a consistent start, or write the equations in another order", sys->row[row[i]].source, fabs(miss[i]), sum);
        }
        free(in);
        sizes_clear(&s);
    }
    num_jacobian_free(jac);
    num_tape_free(tape);
    free(inputs);
    free(row);
    free(equation);
    return ok;
}
