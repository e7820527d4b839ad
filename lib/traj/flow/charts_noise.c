/* How many digits a chart loses: its field and its constraints are compared with themselves in double-double. A pivot that has shrunk says
 * that digits may be lost, and not how many: what is divided by it may be as small, and what it is a part of may shrink in all charts. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "charts.h"
#include "dd.h"
#include "field.h"
#include "jet.h"
#include "manifold.h"
#include "mem.h"
#include "tape.h"

enum { PLACES = 4 };
static const double BESIDE = 1e-9;      /* of the variables: roundings differ, and pivots do not */

static void inputs(struct num_jet2 *jet, int n, double t, const double *y)
{
    for (int j = 0; j < n; j++)
        num_jet2_input(jet, j)[0] = num_dd_of(y[j]);
    num_jet2_input(jet, n)[0] = num_dd_of(t);
}

static double field_miss(struct charts_exact *e, struct field *f, double t, const double *y, double *v)
{
    double most = 0, size = 0;
    field_load(f, t, y);
    inputs(e->field, f->n, t, y);
    if (!num_tape_eval(f->plain, f->in, v) || !num_jet2_next(e->field, 0))
        return INFINITY;
    size = field_size(f, v);
    for (int j = 0; j < f->n; j++) {
        double unit = f->unit ? f->unit[j] : 1, miss = fabs(num_dd_add_d(num_jet2_root(e->field, j)[0], -v[j]).hi);
        most = fmax(most, miss / (fabs(v[j]) + 1e-3 * size * unit));
    }
    return most;
}

static double constraint_miss(struct charts_exact *e, struct manifold *m, double t, const double *y)
{
    double most = 0;
    inputs(e->constraint, m->n, t, y);
    if (manifold_residual(m, t, y, NULL, NULL) < 0 || !num_jet2_next(e->constraint, 0))
        return INFINITY;
    for (int i = 0; i < m->c; i++)
        most = fmax(most, fabs(num_jet2_root(e->constraint, i)[0].hi / m->big[i] - m->r[i]));
    return most;
}

double charts_noise(struct charts_exact *e, struct field *f, struct manifold *m, double t, const double *x)
{
    int n = f->n;
    double *y = sga_malloc(2 * ((size_t)n + 1) * sizeof *y), most = DBL_EPSILON;
    if (!e->field)
        e->field = num_jet2_new(f->plain, 0);
    if (!e->constraint)
        e->constraint = num_jet2_new(m->tape, 0);
    for (int k = 0; k < PLACES; k++) {
        for (int j = 0; j < n; j++)
            y[j] = x[j] * (1 + BESIDE * sin(1.7 * k + 2.9 * k * j));
        double a = field_miss(e, f, t, y, y + n + 1), b = m->c ? constraint_miss(e, m, t, y) : 0;
        most = fmax(most, fmax(isnan(a) ? INFINITY : a, isnan(b) ? INFINITY : b));
    }
    free(y);
    return most;
}

void charts_exact_clear(struct charts_exact *e)
{
    num_jet2_free(e->field);
    num_jet2_free(e->constraint);
    *e = (struct charts_exact){ 0 };
}
