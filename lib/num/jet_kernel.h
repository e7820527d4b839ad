/* The recurrences of series, for one kind of numbers: included by jet.c and jet_dd.c, which
 * define R (the number), its operations R_..., and the names STRUCT and FACE(what). In the
 * comments a, b, w are the series of a step's rows; sums run over i + j = k. */

/* R_MACHINE, R_CLEAR: machine code of these recurrences, where there is some. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "first_change.h"
#include "mem.h"
#include "watch.h"

/* Steps of which one order takes so long that the watch is asked after each: past a limit nothing is finite. */
enum { JET_LONG = 20000 };

struct STRUCT {
    struct jet_plan plan;
    int order;
    size_t stride;
    R *row;                    /* plan.rows x stride */
    R **lu, *work;             /* by solve */
    int **perm;
    bool *singular;
    R_MACHINE machine;
    double *turn;              /* a row in double, and twice as much to work in */
    signed char *side;         /* by step: which side an abs, sign, min, max is on; 2: not known yet */
};

struct STRUCT *FACE(new)(const struct num_tape *t, int order)
{
    struct STRUCT *j = sga_calloc(1, sizeof *j);
    struct jet_plan *p = &j->plan;
    int widest = 0;
    jet_plan_make(p, t);
    j->order = order;
    j->stride = (size_t)order + 1;
    j->row = sga_calloc((size_t)p->rows * j->stride + 1, sizeof *j->row);
    j->lu = sga_calloc((size_t)p->solves + 1, sizeof *j->lu);
    j->perm = sga_calloc((size_t)p->solves + 1, sizeof *j->perm);
    j->singular = sga_calloc((size_t)p->solves + 1, sizeof *j->singular);
    j->turn = sga_calloc(3 * j->stride, sizeof *j->turn);
    j->side = sga_calloc((size_t)p->count + 1, 1);
    for (int s = 0; s < p->solves; s++) {
        size_t m = (size_t)p->solve[s].m;
        j->lu[s] = sga_calloc(m * m + 1, sizeof **j->lu);
        j->perm[s] = sga_calloc(m + 1, sizeof **j->perm);
        widest = p->solve[s].m > widest ? p->solve[s].m : widest;
    }
    j->work = sga_calloc(2 * (size_t)widest + 1, sizeof *j->work);
    for (int i = 0; i < p->constants; i++)
        j->row[(size_t)(p->first_constant + i) * j->stride] = R_CONSTANT(p->constant[i]);
    FACE(run)(j, 0, 0, p->fixed);
    return j;
}

void FACE(free)(struct STRUCT *j)
{
    if (!j)
        return;
    for (int s = 0; s < j->plan.solves; s++) {
        free(j->lu[s]);
        free(j->perm[s]);
    }
    R_CLEAR(j);
    free(j->lu);
    free(j->perm);
    free(j->singular);
    free(j->work);
    free(j->turn);
    free(j->side);
    free(j->row);
    jet_plan_clear(&j->plan);
    free(j);
}

R *FACE(input)(struct STRUCT *j, int i) { return j->row + (size_t)i * j->stride; }
const R *FACE(root)(const struct STRUCT *j, int r) { return j->row + (size_t)j->plan.root[r] * j->stride; }
int FACE(length)(const struct STRUCT *j) { return j->plan.count - j->plan.fixed; }

/* sum a_i a_{k-i} */
static R square(const R *a, int k)
{
    int half = (k + 1) / 2;
    R s = R_TWICE(R_DOT(a, a + (k - half + 1), half));
    return k % 2 ? s : R_ADD(s, R_MUL(a[k / 2], a[k / 2]));
}

static R exponential(const R *a, const R *da, const R *w, int k)
{
    return k == 0 ? R_FUNCTION(EXPR_EXP, a[0]) : R_DIV_INT(R_DOT(da + 1, w, k), k);
}

/* s' = c a', c' = sign s a' */
static void trig(const struct jet_code *c, const R *a, const R *da, R *s, R *co, int k)
{
    if (k == 0) {
        s[0] = R_FUNCTION(c->sign < 0 ? EXPR_SIN : EXPR_SINH, a[0]);
        co[0] = R_FUNCTION(c->sign < 0 ? EXPR_COS : EXPR_COSH, a[0]);
        return;
    }
    s[k] = R_DIV_INT(R_DOT(da + 1, co, k), k);
    R d = R_DIV_INT(R_DOT(da + 1, s, k), k);
    co[k] = c->sign < 0 ? R_NEG(d) : d;
}

/* w' d = numerator, of which coefficient k - 1 is given; dw is w'. */
static void integrate(R numerator, const R *d, R *w, R *dw, int k)
{
    R rest = k > 1 ? R_SUB(numerator, R_DOT(dw + 1, d + 1, k - 1)) : numerator;
    dw[k] = R_DIV(rest, d[0]);
    w[k] = R_DIV_INT(dw[k], k);
}

static R root(const R *a, const R *w, int k)
{
    if (k == 0)
        return R_FUNCTION(EXPR_SQRT, a[0]);
    R rest = k > 1 ? R_SUB(a[k], R_DOT(w + 1, w + 1, k - 1)) : a[k];
    return R_ROOT_STAYS(w[0], rest) ? rest : R_DIV(rest, R_TWICE(w[0]));
}

/* a w' = r w a', r the power or 1/3. */
static void power(const struct jet_code *c, const R *a, const R *b, const R *da, R *w, R *dw, int k)
{
    if (k == 0) {
        w[0] = c->shift == 3 ? R_FUNCTION(EXPR_CBRT, a[0]) : R_FUNCTION2(EXPR_POW, a[0], b[0]);
        return;
    }
    R up = R_DOT(da + 1, w, k);
    up = c->shift == 3 ? R_DIV_INT(up, 3) : R_MUL(up, b[0]);
    if (k > 1)
        up = R_SUB(up, R_DOT(a + 1, dw + 1, k - 1));
    dw[k] = R_DIV(up, a[0]);
    w[k] = R_DIV_INT(dw[k], k);
}

/* The side on which series x runs: that of its value, or where this is 0 to rounding, of the
 * first coefficient that tells where the motion takes it. 0 while none has. */
static int side_of(const R *x, int k)
{
    double first = R_DOUBLE(x[0]), later = 0;
    for (int i = 1; i <= k; i++)
        later = fmax(later, fabs(R_DOUBLE(x[i])));
    if (fabs(first) > R_SMALL * later)
        return first > 0 ? 1 : -1;
    for (int i = 1; i <= k; i++)
        if (fabs(R_DOUBLE(x[i])) > R_SMALL * later)
            return R_DOUBLE(x[i]) > 0 ? 1 : -1;
    return 0;
}

static void switching(const struct jet_code *c, const R *a, const R *b, const R *x, R *w, signed char *side, int k)
{
    if (c->op == JET_SIGN) {
        w[k] = k == 0 ? R_FUNCTION(EXPR_SIGN, a[0]) : R_OF(0);
        return;
    }
    if (k == 0) {
        *side = 0;
        w[0] = c->op == JET_ABS ? R_FUNCTION(EXPR_ABS, a[0]) : R_FUNCTION2(c->op == JET_MIN ? EXPR_MIN : EXPR_MAX, a[0], b[0]);
        return;
    }
    if (!*side)
        *side = (signed char)side_of(x, k);
    if (c->op == JET_ABS)
        w[k] = *side < 0 ? R_NEG(a[k]) : a[k];
    else
        w[k] = (*side < 0) == (c->op == JET_MIN) ? a[k] : b[k];
}

/* M_0 y_k = r_k - sum_{i >= 1} M_i y_{k-i} */
static void solve(struct STRUCT *j, int index, int k)
{
    const struct jet_solve *s = j->plan.solve + index;
    size_t m = (size_t)s->m;
    R *r = j->work, *y = j->work + m;
    if (k == 0) {
        for (size_t e = 0; e < m * m; e++)
            j->lu[index][e] = j->row[(size_t)s->matrix[e] * j->stride];
        j->singular[index] = !R_LU_FACTOR(j->lu[index], j->perm[index], s->m);
    }
    for (size_t i = 0; i < m; i++) {
        r[i] = j->row[(size_t)s->rhs[i] * j->stride + (size_t)k];
        for (size_t c = 0; c < m && k > 0; c++)
            if (!j->plan.flat[s->matrix[i * m + c]])
                r[i] = R_SUB(r[i], R_DOT(j->row + (size_t)s->matrix[i * m + c] * j->stride + 1,
                                         j->row + (size_t)s->y[c] * j->stride, k));
    }
    if (!j->singular[index])
        R_LU_SOLVE(j->lu[index], j->perm[index], s->m, r, y);
    for (size_t i = 0; i < m; i++)
        j->row[(size_t)s->y[i] * j->stride + (size_t)k] = j->singular[index] ? R_OF(NAN) : y[i];
}

static R product(const struct jet_plan *p, const struct jet_code *c, const R *a, const R *b, int k)
{
    if (p->flat[c->a])
        return R_MUL(a[0], b[k]);
    return p->flat[c->b] ? R_MUL(a[k], b[0]) : R_DOT(a, b, k + 1);
}

static R quotient(const struct jet_plan *p, const struct jet_code *c, const R *a, const R *b, const R *w, int k)
{
    R up = k == 0 || p->flat[c->b] ? a[k] : R_SUB(a[k], R_DOT(b + 1, w, k));
    return R_DIV(up, b[0]);
}

static void step(struct STRUCT *j, int at, int k)
{
    const struct jet_plan *p = &j->plan;
    const struct jet_code *c = p->code + at;
    if (c->op == JET_SOLVE) {
        solve(j, c->a, k);
        return;
    }
    R *w = j->row + (size_t)c->w * j->stride;
    const R *a = j->row + (size_t)c->a * j->stride, *b = j->row + (size_t)c->b * j->stride;
    const R *x = j->row + (size_t)c->x * j->stride;
    R *y = j->row + (size_t)c->y * j->stride;
    switch ((enum jet_op)c->op) {
    case JET_ADD:        w[k] = R_OVERFLOWS(R_ADD(a[k], b[k]), R_DOUBLE(a[k]) + R_DOUBLE(b[k])); break;
    case JET_SUB:        w[k] = R_OVERFLOWS(R_SUB(a[k], b[k]), R_DOUBLE(a[k]) - R_DOUBLE(b[k])); break;
    case JET_NEG:        w[k] = R_NEG(a[k]); break;
    case JET_MUL:        w[k] = k == 0 ? R_PRODUCT(a[0], b[0]) : product(p, c, a, b, k); break;
    case JET_SQUARE:     w[k] = k == 0 ? R_PRODUCT(a[0], a[0]) : square(a, k); break;
    case JET_DIV:        w[k] = k == 0 ? R_QUOTIENT(a[0], b[0]) : R_UNDERFLOWS(quotient(p, c, a, b, w, k), b[0], R_DOUBLE(a[k])); break;
    case JET_INVERSE:    w[k] = k == 0 ? R_QUOTIENT(R_OF(1), a[0]) : R_UNDERFLOWS(R_DIV(R_NEG(R_DOT(a + 1, w, k)), a[0]), a[0], 1.0); break;
    case JET_AFFINE: {
        R v = c->sign < 0 ? R_NEG(a[k]) : a[k];
        w[k] = k == 0 ? R_OVERFLOWS(R_ADD(v, R_OF(c->shift)), R_DOUBLE(v) + c->shift) : v;
        break;
    }
    case JET_DERIVATIVE: w[k] = R_MUL_INT(a[k], k); break;
    case JET_EXP:        w[k] = exponential(a, x, w, k); break;
    case JET_TRIG:       trig(c, a, x, w, y, k); break;
    case JET_TAN: {
        w[k] = k == 0 ? R_FUNCTION(c->function, a[0]) : R_DIV_INT(R_DOT(x + 1, y, k), k);
        R v = c->sign < 0 ? R_NEG(square(w, k)) : square(w, k);
        y[k] = k == 0 ? R_ADD(v, R_OF(1)) : v;
        break;
    }
    case JET_QUOTIENT:
        if (k == 0)
            w[0] = R_FUNCTION(c->function, a[0]);
        else
            integrate(R_MUL_INT(a[k], k * c->sign), x, w, y, k);
        break;
    case JET_ATAN2:
        if (k == 0)
            w[0] = R_FUNCTION2(EXPR_ATAN2, a[0], b[0]);
        else
            integrate(R_SUB(R_DOT(j->row + (size_t)c->p * j->stride + 1, b, k), R_DOT(j->row + (size_t)c->q * j->stride + 1, a, k)),
                      x, w, y, k);
        break;
    case JET_SQRT:       w[k] = root(a, w, k); break;
    case JET_POWER:      power(c, a, b, x, w, y, k); break;
    case JET_ABS: case JET_SIGN: case JET_MIN: case JET_MAX: switching(c, a, b, x, w, j->side + at, k); break;
    case JET_TABLE: {
        R v = R_TABLE(p->table[c->b >> 8], (c->b & 255) + k, a[0]);
        for (int i = 1; i <= k && k <= EXPR_TABLE_DEGREE; i++)
            v = R_DIV_INT(R_MUL(v, a[1]), i);
        w[k] = v;
        break;
    }
    case JET_SOLVE:      break;
    }
}

static void FACE(run)(struct STRUCT *j, int k, int from, int to)
{
    for (int i = from; i < to; i++)
        step(j, i, k);
}

bool FACE(next)(struct STRUCT *j, int k)
{
    FACE(run)(j, k, j->plan.fixed, j->plan.count);
    bool finite = j->plan.count < JET_LONG || sga_watch_ok();
    for (int r = 0; r < j->plan.roots; r++)
        finite &= isfinite(R_DOUBLE(FACE(root)(j, r)[k])) != 0;
    return finite;
}

/* sum x_i s^i in double. */
static double value_at(const R *x, int k, double s)
{
    double v = 0;
    for (int i = k; i >= 0; i--)
        v = v * s + R_DOUBLE(x[i]);
    return v;
}

/* Between low, where x has the sign of side, and high, where it has not: bisection in
 * double, then (in longer numbers) Newton. */
static R change(const R *x, int k, int side, double low, double high)
{
    for (int i = 0; i < 60 && high - low > 1e-16 * high; i++) {
        double s = 0.5 * (low + high);
        *(value_at(x, k, s) * side > 0 ? &low : &high) = s;
    }
    R s = R_OF(high);
    for (int turn = 0; turn < R_POLISH; turn++) {
        R v = x[k];
        double slope = 0;
        for (int i = k - 1; i >= 0; i--) {
            slope = slope * high + R_DOUBLE(v);
            v = R_ADD(R_MUL(v, s), x[i]);
        }
        double move = -R_DOUBLE(v) / slope;
        if (fabs(move) < 1e-8 * high)
            s = R_ADD(s, R_OF(move));
    }
    return s;
}

/* The side that the series took: the one that its first coefficients showed (as in `switching`), however later ones grow. */
static int side_taken(const R *x, int k)
{
    int side = 0;
    for (int order = 1; order <= k && !side; order++)
        side = side_of(x, order);
    return side;
}

R FACE(reach)(const struct STRUCT *j, int k)
{
    R reach = R_OF(INFINITY);
    for (int i = 0; i < j->plan.turns; i++) {
        const R *x = j->row + (size_t)j->plan.turn[i] * j->stride;
        int side = side_taken(x, k);
        double tail = 0, low, high;
        for (int q = 1; q <= k; q++)
            tail += fabs(R_DOUBLE(x[q]));
        if (!side || fabs(R_DOUBLE(x[0])) > tail)
            continue;          /* it cannot change sign */
        for (int q = 0; q <= k; q++)
            j->turn[q] = side * R_DOUBLE(x[q]);
        if (!num_first_change(j->turn, k, j->turn + j->stride, &low, &high))
            continue;
        R here = change(x, k, side, low, high);
        reach = R_DOUBLE(here) < R_DOUBLE(reach) ? here : reach;
    }
    return reach;
}
