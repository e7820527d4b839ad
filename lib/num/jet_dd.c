/* Series in double-double; the recurrences are in jet_kernel.h. */
#include "jet.h"

#include <math.h>

#include "dd_lu.h"
#include "jet_plan.h"
#include "tape_code.h"

#define R num_dd
#define STRUCT num_jet2
#define FACE(what) num_jet2_##what
#define R_SMALL 1e-28
#define R_POLISH 2
#define R_CONSTANT(c) (c)
#define R_OF(x) num_dd_of((double)(x))
#define R_DOUBLE(x) ((x).hi)
#define R_ADD num_dd_add
#define R_SUB num_dd_sub
#define R_MUL num_dd_mul
#define R_DIV num_dd_div
#define R_NEG num_dd_neg
#define R_TWICE(a) num_dd_scale(a, 2)
#define R_MUL_INT(a, k) num_dd_mul_d(a, (double)(k))
#define R_DIV_INT(a, k) num_dd_div(a, num_dd_of((double)(k)))
#define R_DOT dot
#define R_FUNCTION function
#define R_FUNCTION2 num_dd_function2
#define R_LU_FACTOR num_dd_lu_factor
#define R_LU_SOLVE num_dd_lu_solve
#define R_MACHINE char            /* none is made */
#define R_CLEAR(j) (void)0

/* sum_{i < n} a[i] b[n - 1 - i], as if in twice double precision and then rounded (Ogita, Rump,
 * Oishi, SISC 26, 2005: Dot2; the low parts join the errors). */
static num_dd dot(const num_dd *a, const num_dd *b, int n)
{
    double sum = 0, rest = 0;
    b += n - 1;
    for (int i = 0; i < n; i++, b--) {
        num_dd p = num_dd_two_product(a[i].hi, b->hi), s = num_dd_two_sum(sum, p.hi);
        sum = s.hi;
        rest += s.lo + (p.lo + (a[i].hi * b->lo + a[i].lo * b->hi));
    }
    return num_dd_fast_two_sum(sum, rest);
}

static num_dd function(enum expr_op op, num_dd a)
{
    return op == EXPR_SQRT ? num_dd_sqrt(a) : num_dd_function(op, a);
}

static void num_jet2_run(struct num_jet2 *j, int k, int from, int to);

#include "jet_kernel.h"

void num_jet2_hold(struct num_jet2 *j, const struct num_tape *t)
{
    for (int i = 0; i < t->nheld; i++)
        for (int k = t->held[i].slot; k < t->held[i].slot + 3; k++)
            j->row[(size_t)(j->plan.first_constant + k - t->ninputs) * j->stride] = num_dd_of(t->value[k]);
}

num_dd num_jet2_change(const num_dd *x, int k, int side, double *work)
{
    double rest = 0, low, high;
    for (int i = 0; i <= k; i++) {
        work[i] = side * x[i].hi;
        rest += i ? fabs(work[i]) : 0;
    }
    if (work[0] > rest || !num_first_change(work, k, work + k + 1, &low, &high))
        return num_dd_of(INFINITY);
    return change(x, k, side, low, high);
}
