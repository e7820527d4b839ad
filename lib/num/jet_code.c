/* Series as acts: the recurrences of jet_kernel.h written out for all orders, so that sums
 * have no loops and operands are addresses or registers. What is rare (solves,
 * switches) is left to the interpreter, and with it the whole tape.
 *
 * The roundings of a reciprocal are the same in every step, and would add up to a drift: so up to
 * coefficient 5 divisions are divisions. At the end of a step coefficients fall by about e^2 each
 * (Jorba and Zou), so that nothing is left of it beyond. */
#include "jet_code.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"

enum { MOST_ACTS = 1 << 17, DIVIDED = 5, A = JET_SPARE, WIDE = 8 };

static void quotient_by(struct jet_maker *m, int reg, int slot, int reciprocal)
{
    if (m->k < DIVIDED)
        jet_at(m, ACT_DIV_SLOT, reg, slot);
    else
        jet_at(m, ACT_MUL_SLOT, reg, reciprocal);
}

static void divide_by_order(struct jet_maker *m, int reg)
{
    if (m->k == 3)
        jet_at(m, ACT_DIV_SLOT, reg, m->whole + m->k);
    else if (m->k > 1)
        jet_at(m, ACT_MUL_SLOT, reg, m->reciprocal + m->k);
}

/* A coefficient less what is in reg. */
static bool subtract_from(struct jet_maker *m, int reg, bool begun, int row)
{
    if (m->degree[row] < m->k) {
        if (begun)
            jet_do(m, ACT_NEGATE, reg, 0);
        return begun;
    }
    int at = begun ? A : reg;
    jet_get(m, at, row, m->k);
    if (begun) {
        jet_do(m, ACT_SUB, A, reg);
        jet_do(m, ACT_MOVE, reg, A);
    }
    return true;
}

/* sum_{i=1..k} a_i b_{k-i} into a new register. */
static int convolve(struct jet_maker *m, int a, int b)
{
    struct jet_late late;
    int r = jet_fresh(m);
    bool begun = jet_sum(m, r, a, 1, b, 0, m->k, &late);
    jet_finish(m, r, jet_add_late(m, ACT_ADD, r, begun, false, &late));
    return r;
}

static int square(struct jet_maker *m, int a)
{
    struct jet_late late;
    int k = m->k, half = (k + 1) / 2, r = jet_fresh(m);
    bool begun = jet_sum(m, r, a, 0, a, k - half + 1, half, &late);
    begun = jet_double(m, r, begun, a, k);
    jet_finish(m, r, jet_add_late(m, ACT_ADD, r, begun, true, &late));
    return r;
}

static int product(struct jet_maker *m, int a, int b)
{
    struct jet_late late;
    int r = jet_fresh(m);
    if (m->p->flat[a] || m->p->flat[b]) {
        jet_get(m, r, m->p->flat[a] ? b : a, m->k);
        jet_with(m, ACT_MUL, r, m->p->flat[a] ? a : b, 0);
        return r;
    }
    bool down = m->reversed[b] >= 0;
    bool begun = jet_sum(m, r, down ? a : b, 0, down ? b : a, 0, m->k + 1, &late);
    jet_finish(m, r, jet_add_late(m, ACT_ADD, r, begun, false, &late));
    return r;
}

static int sum(struct jet_maker *m, const struct jet_code *c)
{
    int r = jet_fresh(m);
    bool first = m->degree[c->a] >= m->k;
    jet_get(m, r, first ? c->a : c->b, m->k);
    if (first && m->degree[c->b] >= m->k)
        jet_with(m, c->op == JET_ADD ? ACT_ADD : ACT_SUB, r, c->b, m->k);
    else if (!first && c->op == JET_SUB)
        jet_do(m, ACT_NEGATE, r, 0);
    return r;
}

static int ratio(struct jet_maker *m, const struct jet_code *c, int inverse)
{
    struct jet_late late = { 0 };
    int r = jet_fresh(m);
    bool begun = !m->p->flat[c->b] && jet_sum(m, r, c->b, 1, c->w, 0, m->k, &late);
    begun = subtract_from(m, r, begun, c->a);
    jet_finish(m, r, jet_add_late(m, ACT_SUB, r, begun, false, &late));
    quotient_by(m, r, jet_slot(m, c->b, 0), inverse);
    return r;
}

static int root(struct jet_maker *m, const struct jet_code *c, int inverse)
{
    struct jet_late late;
    int k = m->k, half = (k - 1) / 2, r = jet_fresh(m);
    bool begun = jet_sum(m, r, c->w, 1, c->w, k - half, half, &late);
    begun = k > 1 && jet_double(m, r, begun, c->w, k);
    jet_finish(m, r, subtract_from(m, r, begun, c->a));
    quotient_by(m, r, inverse + 1, inverse);
    return r;
}

/* w' x = numerator, whose coefficient k - 1 is in register r; dw is w'. */
static void integrate(struct jet_maker *m, const struct jet_code *c, int r, int x, int inverse)
{
    quotient_by(m, r, jet_slot(m, x, 0), inverse);
    jet_put(m, r, c->y);
    int w = jet_fresh(m);
    jet_do(m, ACT_MOVE, w, r);
    divide_by_order(m, w);
    jet_put(m, w, c->w);
}

static void quotient(struct jet_maker *m, const struct jet_code *c, int inverse)
{
    struct jet_late late = { 0 };
    int r = jet_fresh(m);
    bool begun = m->k > 1 && jet_sum(m, r, c->y, 1, c->x, 1, m->k - 1, &late), has = m->degree[c->a] >= m->k;
    if (has) {
        jet_get(m, A, c->a, m->k);
        jet_at(m, ACT_MUL_SLOT, A, m->whole + m->k);
        if (c->sign < 0)
            jet_do(m, ACT_NEGATE, A, 0);
        if (begun)
            jet_do(m, ACT_SUB, A, r);
        jet_do(m, ACT_MOVE, r, A);
    } else if (begun) {
        jet_do(m, ACT_NEGATE, r, 0);
    }
    jet_finish(m, r, begun || has);
    integrate(m, c, r, c->x, inverse);
}

static void power(struct jet_maker *m, const struct jet_code *c, int inverse)
{
    struct jet_late late = { 0 };
    int r = convolve(m, c->x, c->w), less = jet_fresh(m);
    if (c->shift == 3)
        jet_at(m, ACT_DIV_SLOT, r, m->whole + 3);
    else
        jet_at(m, ACT_MUL_SLOT, r, jet_slot(m, c->b, 0));
    if (m->k > 1 && jet_sum(m, less, c->a, 1, c->y, 1, m->k - 1, &late))
        jet_do(m, ACT_SUB, r, less);
    integrate(m, c, r, c->a, inverse);
}

static void trig(struct jet_maker *m, const struct jet_code *c)
{
    int s = convolve(m, c->x, c->y);
    divide_by_order(m, s);
    int co = convolve(m, c->x, c->w);
    divide_by_order(m, co);
    if (c->sign < 0)
        jet_do(m, ACT_NEGATE, co, 0);
    jet_put(m, s, c->w);
    jet_put(m, co, c->y);
}

static void tangent(struct jet_maker *m, const struct jet_code *c)
{
    int r = convolve(m, c->x, c->y);
    divide_by_order(m, r);
    jet_put(m, r, c->w);
    r = square(m, c->w);
    if (c->sign < 0)
        jet_do(m, ACT_NEGATE, r, 0);
    jet_put(m, r, c->y);
}

/* Coefficient k >= 1 of one instruction. */
static void later(struct jet_maker *m, const struct jet_code *c, int inverse)
{
    int r;
    if (m->degree[c->w] < m->k)
        return;
    switch ((enum jet_op)c->op) {
    case JET_ADD: case JET_SUB: r = sum(m, c); break;
    case JET_MUL:    r = product(m, c->a, c->b); break;
    case JET_SQUARE: r = square(m, c->a); break;
    case JET_DIV:    r = ratio(m, c, inverse); break;
    case JET_SQRT:   r = root(m, c, inverse); break;
    case JET_INVERSE:
        r = convolve(m, c->a, c->w);
        jet_do(m, ACT_NEGATE, r, 0);
        quotient_by(m, r, jet_slot(m, c->a, 0), jet_slot(m, c->w, 0));
        break;
    case JET_DERIVATIVE:
        r = jet_fresh(m);
        jet_get(m, r, c->a, m->k);
        jet_at(m, ACT_MUL_SLOT, r, m->whole + m->k);
        break;
    case JET_EXP:
        r = convolve(m, c->x, c->w);
        divide_by_order(m, r);
        break;
    case JET_TRIG:     trig(m, c); return;
    case JET_TAN:      tangent(m, c); return;
    case JET_QUOTIENT: quotient(m, c, inverse); return;
    case JET_POWER:    power(m, c, inverse); return;
    default:           /* JET_NEG, JET_AFFINE */
        r = jet_fresh(m);
        jet_get(m, r, c->a, m->k);
        if (c->op == JET_NEG || c->sign < 0)
            jet_do(m, ACT_NEGATE, r, 0);
    }
    jet_put(m, r, c->w);
}

/* Reads of coefficient k, and by later orders. */
static void reads(struct jet_maker *m, int i)
{
    const struct jet_code *c = m->p->code + i;
    int op = c->op;
    bool linear = op == JET_ADD || op == JET_SUB || op == JET_NEG || op == JET_AFFINE || op == JET_DERIVATIVE || op == JET_QUOTIENT;
    bool b = op == JET_ADD || op == JET_SUB || op == JET_MUL || op == JET_DIV || op == JET_POWER;
    bool x = op == JET_EXP || op == JET_TRIG || op == JET_TAN || op == JET_QUOTIENT || op == JET_POWER;
    bool y = op == JET_TRIG || op == JET_TAN || op == JET_QUOTIENT || op == JET_POWER;
    bool scaled = op == JET_MUL && (m->p->flat[c->a] || m->p->flat[c->b]);
    m->last[c->a] = i;
    m->lasting[c->a] |= !linear && !scaled && op != JET_DIV && op != JET_SQRT;
    if (b) {
        m->last[c->b] = i;
        m->lasting[c->b] |= !linear && !scaled;
    }
    if (x) {
        m->last[c->x] = i;
        m->lasting[c->x] = 1;
    }
    if (y)
        m->lasting[c->y] = 1;
    m->lasting[c->w] |= op == JET_DIV || op == JET_SQRT || op == JET_INVERSE || op == JET_EXP || op == JET_TRIG || op == JET_TAN ||
                        op == JET_POWER;
}

/* Which rows are read downwards too, and what degree they have as polynomials of time; who reads them. */
static void look(struct jet_maker *m, int count)
{
    const struct jet_plan *p = m->p;
    int *deg = m->degree;
    for (int r = 0; r < p->rows; r++)
        deg[r] = p->flat[r] ? 0 : JET_ENDLESS;
    deg[count] = 1;
    for (int i = p->fixed; i < p->count; i++) {
        const struct jet_code *c = p->code + i;
        int down = -1, also = -1, a = deg[c->a], b = deg[c->b], d = JET_ENDLESS;
        switch ((enum jet_op)c->op) {
        case JET_ADD: case JET_SUB: d = a > b ? a : b; break;
        case JET_NEG: case JET_AFFINE: case JET_DERIVATIVE: d = a; break;
        case JET_MUL:    d = a + b; down = m->reversed[c->a] >= 0 ? c->a : c->b; break;
        case JET_SQUARE: d = 2 * a; down = c->a; break;
        case JET_DIV:    d = b ? d : a; down = c->w; break;
        case JET_TRIG: case JET_TAN: case JET_POWER: down = c->w; also = c->y; break;
        case JET_QUOTIENT: down = c->x; break;
        default: down = c->w;
        }
        deg[c->w] = d < JET_ENDLESS ? d : JET_ENDLESS;
        reads(m, i);
        m->wide |= i - p->fixed >= WIDE;
        if (down >= 0)
            m->reversed[down] = 0;
        if (also >= 0)
            m->reversed[also] = 0;
    }
    for (int r = 0; r < p->roots && r < count; r++)
        m->last[p->root[r]] = p->count;
}

/* x_{k+1} = scale f_k / (k + 1) */
static void onward(struct jet_maker *m, int count)
{
    int next = m->k + 1;
    SGA_FREED int *at = sga_malloc(((size_t)count + 1) * sizeof *at);
    for (int i = 0; i < count; i++) {
        int r = at[i] = jet_fresh(m), row = m->p->root[i];
        if (m->degree[row] >= m->k) {
            jet_get(m, r, row, m->k);
            bool by = next == 3 || next == 5;
            jet_at(m, ACT_MUL_SLOT, r, m->part + (by ? 1 : next));
            if (by)
                jet_at(m, ACT_DIV_SLOT, r, m->whole + next);
        } else {
            jet_finish(m, r, false);
        }
        jet_keep(m, r, i, next);
        jet_at(m, ACT_OUT, r, next * count + i);
    }
    jet_next_order(m);
    m->k = next;
    for (int i = count > JET_RING_END - JET_RING ? count - (JET_RING_END - JET_RING) : 0; i < count; i++)
        jet_hold(m, at[i], i);
}

static bool write_code(struct jet_maker *m, int count, int order, const int *inverse)
{
    const struct jet_plan *p = m->p;
    for (int i = 0; i <= count; i++) {
        jet_at(m, ACT_LOAD, A, jet_slot(m, i, 0));
        jet_keep(m, A, i, 0);
    }
    jet_at(m, ACT_LOAD, A, m->part + 1);
    jet_keep(m, A, count, 1);
    for (int i = p->fixed; i < p->count; i++)
        if (!jet_first(m, p->code + i, inverse[i]))
            return false;
    onward(m, count);
    while (m->k < order && m->count < MOST_ACTS) {
        jet_do(m, ACT_LEAVE, 0, 0);
        m->act[m->count - 1].number = (short)m->k;
        for (m->at = p->fixed; m->at < p->count; m->at++)
            later(m, p->code + m->at, inverse[m->at]);
        onward(m, count);
    }
    return m->k == order;
}

/* The slots: rows, copies that run downwards, numbers, reciprocals; returns how many. */
static int lay_out(struct jet_maker *m, int order, int *inverse)
{
    const struct jet_plan *p = m->p;
    int at = p->rows * m->stride;
    for (int r = 0; r < p->rows; r++)
        if (m->reversed[r] >= 0) {
            at += m->stride;
            m->reversed[r] = at - 1;
        }
    m->whole = at;
    m->reciprocal = m->whole + order + 2;
    m->part = m->reciprocal + order + 2;
    at = m->part + order + 2;
    for (int i = p->fixed; i < p->count; i++, at += 2)
        inverse[i] = at;
    return at;
}

void jet_series_fill(struct jet_series *q, const struct jet_plan *p, const double *row, size_t stride)
{
    q->memory = sga_calloc((size_t)q->slots + JET_REGISTERS + 1, sizeof *q->memory);
    double *slot = q->slot = q->memory + JET_REGISTERS;
    for (int r = 0; r < p->rows; r++)
        if (p->flat[r])
            slot[r * q->stride] = row[(size_t)r * stride];
    for (int k = 1; k < q->most + 2; k++) {
        slot[q->whole + k] = k;
        slot[q->reciprocal + k] = 1.0 / k;
    }
}

bool jet_series_make(struct jet_series *q, const struct jet_plan *p, int order, int count, const double *row, size_t stride)
{
    int even = (order + 2) / 2 * 2;
    if (p->inputs != count + 1 || p->roots < count || order < 1 || (double)p->rows * even > MOST_ACTS)
        return false;
    assert(even >= order && even % 2 == 0);
    size_t rows = (size_t)p->rows + 1;
    SGA_ARENA(mem);
    int *memory = sga_zeros(&mem, 5 * rows + (size_t)p->count + 1, sizeof *memory), *inverse = memory + 5 * rows;
    unsigned char *flags = sga_zeros(&mem, 2 * rows, 1);
    struct jet_maker m = { .p = p, .stride = even, .degree = memory, .reversed = memory + rows, .held = memory + 2 * rows,
                           .made = memory + 3 * rows, .last = memory + 4 * rows, .lasting = flags, .owed = flags + rows, .ring = JET_RING };
    memset(m.reversed, -1, 2 * rows * sizeof *m.reversed);
    memset(m.holds, -1, sizeof m.holds);
    look(&m, count);
    q->count = count;
    q->most = order;
    q->stride = even;
    q->slots = lay_out(&m, order, inverse);
    q->part = m.part;
    q->whole = m.whole;
    q->reciprocal = m.reciprocal;
    bool ok = write_code(&m, count, order, inverse);
    if (ok) {
        jet_series_fill(q, p, row, stride);
        q->act = m.act;
        q->acts = m.count;
    } else {
        free(m.act);
    }
    return ok;
}
