/* Series in double-double; the recurrences are in jet_kernel.h. */
#include "jet.h"

#include <math.h>
#include <stdlib.h>

#include "dd_lu.h"
#include "jet_plan.h"
#include "mem.h"
#include "table_balls.h"
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
/* The root of what is 0 as far as is known is 0: max(0, x) beside negative x, which has no other way to go on than series. */
#define R_ROOT_STAYS(root, rest) ((root).hi == 0 && (rest).hi == 0)
/* Sums and products beyond the range of numbers are infinite, as they are in double, not without a value: 1/(1 + exp(u)) beside large u. What is divided by
 * these, or by what has no series near the largest numbers, is 0, with all its derivatives. */
#define R_OVERFLOWS(w, plain) overflowing(w, plain)
#define R_UNDERFLOWS(w, by, what) underflowing(w, by, what)
#define R_PRODUCT wide_product
#define R_QUOTIENT wide_quotient
#define R_TWICE(a) num_dd_scale(a, 2)
#define R_MUL_INT(a, k) num_dd_mul_d(a, (double)(k))
#define R_DIV_INT(a, k) num_dd_div(a, num_dd_of((double)(k)))
#define R_DOT dot
#define R_FUNCTION function
#define R_FUNCTION2 num_dd_function2
#define R_TABLE num_table_value
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

static inline num_dd overflowing(num_dd w, double plain)
{
    return isnan(w.hi) && isinf(plain) ? num_dd_of(plain) : w;
}

static inline num_dd underflowing(num_dd w, num_dd by, double what)
{
    static const double HUGE_NUMBER = 0x1p900;
    return isnan(w.hi) && fabs(by.hi) > HUGE_NUMBER && isfinite(what) ? num_dd_of(0) : w;
}

/* Of numbers near the largest too, whose halves overflow (num_dd_two_product). */
static num_dd wide_product(num_dd a, num_dd b)
{
    num_dd w = num_dd_mul(a, b);
    if (isnan(w.hi))
        w = num_dd_scale(num_dd_mul(num_dd_scale(a, 0x1p-600), b), 0x1p600);
    return overflowing(w, a.hi * b.hi);
}

static num_dd wide_quotient(num_dd a, num_dd b)
{
    num_dd w = num_dd_div(a, b);
    if (isnan(w.hi) && isfinite(b.hi) && b.hi != 0)
        w = num_dd_scale(num_dd_div(a, num_dd_scale(b, 0x1p-600)), 0x1p-600);
    return isnan(w.hi) && isinf(b.hi) && isfinite(a.hi) ? num_dd_of(0) : w;
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

/* x(s); *slope by s in double. */
static num_dd value_of(const num_dd *x, int k, num_dd s, double *slope)
{
    num_dd v = x[k];
    *slope = 0;
    for (int i = k - 1; i >= 0; i--) {
        *slope = *slope * s.hi + v.hi;
        v = num_dd_add(num_dd_mul(v, s), x[i]);
    }
    return v;
}

/* Where x, of one sign at a and of the other at b, is 0: between them, to all digits that s can have there. */
static num_dd zero_between(const num_dd *x, int k, int side, num_dd a, num_dd b)
{
    double slope;
    for (int turn = 0; turn < 110; turn++) {
        num_dd s = num_dd_scale(num_dd_add(a, b), 0.5);
        *(side * value_of(x, k, s, &slope).hi > 0 ? &a : &b) = s;
    }
    return b;
}

enum { HALVINGS = 40 };        /* of (0, limit] */

/* x on (0, limit] by Bernstein's polynomials there. */
static void bernstein(const num_dd *x, int k, double limit, num_dd *b)
{
    num_dd power = num_dd_of(1);
    for (int i = 0; i <= k; i++) {
        b[i] = num_dd_mul(x[i], power);
        power = num_dd_mul_d(power, limit);
    }
    for (int i = 1; i <= k; i++)       /* over the binomial of k and i, and sums with those of j and i */
        for (int j = i; j > 0; j--)
            b[i] = num_dd_div(num_dd_mul_d(b[i], j), num_dd_of(k - i + j));
    for (int turn = 1; turn <= k; turn++)
        for (int i = k; i >= turn; i--)
            b[i] = num_dd_add(b[i], b[i - 1]);
}

/* The halves of b (de Casteljau): the right one stays, left gets the other. */
static void halve(num_dd *b, int k, num_dd *left)
{
    left[0] = b[0];
    for (int r = 1; r <= k; r++) {
        for (int i = 0; i + r <= k; i++)
            b[i] = num_dd_scale(num_dd_add(b[i], b[i + 1]), 0.5);
        left[r] = b[0];
    }
}

/* Whether it is never off its side by more than least; *once: it leaves that once, and is off it at the end. */
static bool stays(const num_dd *b, int k, int side, double least, bool *once)
{
    int turns = 0, last = 1;
    bool off = false;
    for (int i = 0; i <= k; i++) {
        double v = side * b[i].hi;
        off |= v < -least;
        turns += v != 0 && (v > 0 ? 1 : -1) != last;
        last = v != 0 ? (v > 0 ? 1 : -1) : last;
    }
    *once = turns == 1 && side * b[k].hi < -least;
    return !off;
}

/* The first change before limit that is too shallow for doubles, or whose neighbours are too near: by halves, in all digits. */
static num_dd shallow_change(const num_dd *x, int k, int side, double least, double limit)
{
    struct part { double from, wide; num_dd *b; } part[HALVINGS + 2];
    size_t size = (size_t)k + 1;
    num_dd *room = sga_malloc((HALVINGS + 2) * size * sizeof *room), at = num_dd_of(INFINITY);
    int top = 0;
    bernstein(x, k, limit, room);
    part[top++] = (struct part){ 0, limit, room };
    while (top > 0 && isinf(at.hi)) {
        struct part p = part[--top];
        bool once, last = !(p.wide > ldexp(limit, -HALVINGS));
        if (stays(p.b, k, side, least, &once))
            continue;
        if (once || last) {
            at = once ? zero_between(x, k, side, num_dd_of(p.from), num_dd_of(p.from + p.wide)) : side * p.b[k].hi < -least ? num_dd_of(p.from + p.wide) : at;
            continue;
        }
        num_dd *left = room + (size_t)(top + 1) * size;       /* the right half stays where it is */
        halve(p.b, k, left);
        part[top++] = (struct part){ p.from + 0.5 * p.wide, 0.5 * p.wide, p.b };
        part[top++] = (struct part){ p.from, 0.5 * p.wide, left };
    }
    free(room);
    return at;
}

/* Newton's method from near a zero, which may have another one beside it. *far: that has not come to it. */
static num_dd polished(const num_dd *x, int k, num_dd s, bool *far)
{
    enum { TURNS = 12 };
    double slope, last = INFINITY;
    *far = false;
    for (int turn = 0; turn < TURNS; turn++) {
        double move = -value_of(x, k, s, &slope).hi / slope;
        *far = fabs(move) > 1e-8 * fabs(s.hi);
        if (*far || !(fabs(move) < 0.5 * last))
            break;
        s = num_dd_add_d(s, move);
        last = fabs(move);
    }
    return s;
}

num_dd num_jet2_change(const num_dd *x, int k, int side, double *work)
{
    static const double shallow = 1e-12;           /* of the sum of all terms: to be looked at twice */
    double rest = 0, low = 1, high, dip, end;
    for (int i = 0; i <= k; i++) {
        work[i] = side * x[i].hi;
        rest += i ? fabs(work[i]) : 0;
    }
    if (work[0] > rest)
        return num_dd_of(INFINITY);
    bool found = num_first_change(work, k, work + k + 1, &low, &high);
    bool far = false;
    num_dd s = found ? polished(x, k, change(x, k, side, low, high), &far) : num_dd_of(INFINITY);
    double least = shallow * (fabs(work[0]) + rest);
    work[0] -= least;
    if (k > 1 && (work[0] <= 0 || (num_first_change(work, k, work + k + 1, &dip, &end) && dip < low))) {
        num_dd first = shallow_change(x, k, side, 1e-17 * least, far ? high : found ? low : 1);
        s = num_dd_less(first, s) || (far && isfinite(first.hi)) ? first : s;
    }
    return s;
}
