/* Series in double; the recurrences are in jet_kernel.h. */
#include "jet.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "jet_machine.h"
#include "lu.h"
#include "table.h"
#include "tape_code.h"
#include "value.h"

#define R double
#define STRUCT num_jet
#define FACE(what) num_jet_##what
#define R_SMALL 1e-13      /* of a step is no distance */
#define R_POLISH 0
#define R_CONSTANT(c) ((c).hi)
#define R_OF(x) ((double)(x))
#define R_DOUBLE(x) (x)
#define R_ADD(a, b) ((a) + (b))
#define R_SUB(a, b) ((a) - (b))
#define R_MUL(a, b) ((a) * (b))
#define R_DIV(a, b) ((a) / (b))
#define R_NEG(a) (-(a))
#define R_ROOT_STAYS(root, rest) false
#define R_OVERFLOWS(w, plain) (w)
#define R_UNDERFLOWS(w, by, what) (w)
#define R_PRODUCT R_MUL
#define R_QUOTIENT R_DIV
#define R_TWICE(a) (2 * (a))
#define R_MUL_INT(a, k) ((a) * (k))
#define R_DIV_INT(a, k) ((a) / (k))
#define R_DOT dot
#define R_FUNCTION expr_function_value
#define R_FUNCTION2 function2
#define R_TABLE expr_table_value
#define R_LU_FACTOR num_lu_factor
#define R_LU_SOLVE num_lu_solve

/* sum_{i < n} a[i] b[n - 1 - i]; four sums that do not wait for each other. */
static double dot(const double *a, const double *b, int n)
{
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    int i = 0;
    for (b += n - 1; i + 4 <= n; i += 4, b -= 4) {
        s0 += a[i] * b[0];
        s1 += a[i + 1] * b[-1];
        s2 += a[i + 2] * b[-2];
        s3 += a[i + 3] * b[-3];
    }
    for (; i < n; i++, b--)
        s0 += a[i] * b[0];
    return (s0 + s1) + (s2 + s3);
}

static double function2(enum expr_op op, double a, double b)
{
    switch (op) {
    case EXPR_ATAN2: return atan2(a, b);
    case EXPR_POW:   return a < 0 ? NAN : pow(a, b);
    case EXPR_MIN:   return a < b || isnan(a) ? a : b;
    case EXPR_MAX:   return a > b || isnan(a) ? a : b;
    default:         return NAN;
    }
}

#define R_MACHINE struct jet_machine
#define R_CLEAR(j) jet_machine_clear(&(j)->machine, &(j)->plan)

static void num_jet_run(struct num_jet *j, int k, int from, int to);

#include "jet_kernel.h"

bool num_jet_along(struct num_jet *j, int count, int order, double t, double scale, double *series)
{
    assert(order >= 1 && order <= j->order && count >= 0);
    struct jet_machine *m = &j->machine;
    if (!m->asked)
        jet_machine_begin(m, &j->plan, j->order, count, j->row, j->stride);
    if (m->has)
        return jet_machine_along(m, order, t, scale, series);
    for (int i = 0; i < count; i++)
        num_jet_input(j, i)[0] = series[i];
    double *time = num_jet_input(j, count);
    memset(time, 0, j->stride * sizeof *time);
    time[0] = t;
    time[1] = scale;
    for (int k = 0; k < order; k++) {
        num_jet_run(j, k, j->plan.fixed, j->plan.count);
        double sum = 0;
        series += count;
        for (int i = 0; i < count; i++) {
            double v = scale * num_jet_root(j, i)[k] / (k + 1);      /* 1/(k + 1) rounded would err alike in every step */
            series[i] = num_jet_input(j, i)[k + 1] = v;
            sum += 0.0 * v;
        }
        if (sum != 0 || (j->plan.count >= JET_LONG && !sga_watch_ok()))
            return false;
    }
    return true;
}

void num_jet_hold(struct num_jet *j, const struct num_tape *t)
{
    assert(t->ninputs == j->plan.inputs && t->nroots == j->plan.roots);
    for (int i = 0; i < t->nheld; i++)
        for (int k = t->held[i].slot; k < t->held[i].slot + 3; k++)
            j->row[(size_t)(j->plan.first_constant + k - t->ninputs) * j->stride] = t->value[k];
}

void num_jet_compile(struct num_jet *j, struct sga_exec *memory, struct num_jet_programs *kept)
{
    jet_machine_clear(&j->machine, &j->plan);
    j->machine.memory = memory;
    j->machine.kept = kept;
}

bool num_jet_compiled(const struct num_jet *j) { return j->machine.run != NULL; }

bool num_jet_straight(const struct num_tape *t)
{
    for (int i = t->nstatic; i < t->ncode; i++) {
        int op = t->code[i].op;
        if (op == TAPE_FACTOR || op == TAPE_COMPONENT || op == TAPE_SIGNAL || op == EXPR_ATAN2 || op == EXPR_ABS || op == EXPR_SIGN ||
            op == EXPR_MIN || op == EXPR_MAX)
            return false;
    }
    return true;
}
