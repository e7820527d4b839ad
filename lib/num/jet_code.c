/* Series as machine code (x86-64): the recurrences of jet_kernel.h written out for each
 * order, so that sums have no loops and operands are addresses. The sums keep the four
 * parts of jet.c's dot. What is rare (solves, switches) is left to the interpreter, and with
 * it the whole tape. */
#include "jet_code.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "x64.h"

enum { MOST_BYTES = 1 << 20, SIGN = 15, FREE = 8, TEMP = 4 };   /* registers: 0 .. 3 sums, 4 .. 7 products */

struct maker {
    struct x64 code;
    const struct jet_plan *p;
    int stride, k;
    int temp;                  /* the next product register */
};

static int slot(const struct maker *b, int row, int i) { return row * b->stride + i; }

/* sum_{i < n} a[i] b[n - 1 - i] into register 0; a and b are slots, n > 0. */
static void dot(struct maker *m, int a, int b, int n)
{
    int four = n / 4 * 4, used = 0;
    for (int i = 0; i < n; i++) {
        int part = i < four ? i % 4 : 0, at = part < used ? TEMP + m->temp : part;
        x64_load(&m->code, at, a + i);
        x64_op_slot(&m->code, X64_MUL, at, b + n - 1 - i);
        if (part < used) {
            x64_op(&m->code, X64_ADD, part, at);
            m->temp = (m->temp + 1) % 4;
        } else {
            used = part + 1;
        }
    }
    if (four) {
        x64_op(&m->code, X64_ADD, 0, 1);
        x64_op(&m->code, X64_ADD, 2, 3);
        x64_op(&m->code, X64_ADD, 0, 2);
    }
}

static void number(struct maker *m, int to, double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    x64_constant(&m->code, to, bits);
}

static void negate(struct maker *m) { x64_bitwise(&m->code, X64_XOR, 0, SIGN); }

static void divide_by_order(struct maker *m)
{
    number(m, FREE, m->k);
    x64_op(&m->code, X64_DIV, 0, FREE);
}

/* What register 0 is to be taken from. */
static void subtract_from(struct maker *m, int from)
{
    x64_load(&m->code, FREE, from);
    x64_op(&m->code, X64_SUB, FREE, 0);
    x64_move(&m->code, 0, FREE);
}

static void square(struct maker *m, int a)
{
    int k = m->k, half = (k + 1) / 2;
    dot(m, a, a + (k - half + 1), half);
    x64_op(&m->code, X64_ADD, 0, 0);
    if (k % 2 == 0) {
        x64_load(&m->code, FREE, a + k / 2);
        x64_op(&m->code, X64_MUL, FREE, FREE);
        x64_op(&m->code, X64_ADD, 0, FREE);
    }
}

/* With the numerator's coefficient k - 1 in register 9: w' d = numerator. */
static void integrate(struct maker *m, int d, int w, int dw)
{
    if (m->k > 1) {
        dot(m, dw + 1, d + 1, m->k - 1);
        x64_op(&m->code, X64_SUB, 9, 0);
    }
    x64_move(&m->code, 0, 9);
    x64_op_slot(&m->code, X64_DIV, 0, d);
    x64_store(&m->code, 0, dw + m->k);
    divide_by_order(m);
    x64_store(&m->code, 0, w + m->k);
}

static void power(struct maker *m, const struct jet_code *c, int a, int b, int da, int w, int dw)
{
    int k = m->k;
    dot(m, da + 1, w, k);
    if (c->shift == 3) {
        number(m, FREE, 3);
        x64_op(&m->code, X64_DIV, 0, FREE);
    } else {
        x64_op_slot(&m->code, X64_MUL, 0, b);
    }
    if (k > 1) {
        x64_move(&m->code, 9, 0);
        dot(m, a + 1, dw + 1, k - 1);
        x64_op(&m->code, X64_SUB, 9, 0);
        x64_move(&m->code, 0, 9);
    }
    x64_op_slot(&m->code, X64_DIV, 0, a);
    x64_store(&m->code, 0, dw + k);
    divide_by_order(m);
    x64_store(&m->code, 0, w + k);
}

static void trig(struct maker *m, const struct jet_code *c, int da, int s, int co)
{
    dot(m, da + 1, co, m->k);
    divide_by_order(m);
    x64_store(&m->code, 0, s + m->k);
    dot(m, da + 1, s, m->k);
    divide_by_order(m);
    if (c->sign < 0)
        negate(m);
    x64_store(&m->code, 0, co + m->k);
}

static void product(struct maker *m, const struct jet_code *c, int a, int b)
{
    if (m->p->flat[c->a] || m->p->flat[c->b]) {
        bool first = m->p->flat[c->a];
        x64_load(&m->code, 0, a + (first ? 0 : m->k));
        x64_op_slot(&m->code, X64_MUL, 0, b + (first ? m->k : 0));
    } else {
        dot(m, a, b, m->k + 1);
    }
}

/* Coefficient k of one instruction into register 0 and, where it is not the only one, into its
 * rows. False: the interpreter's. */
static bool step(struct maker *m, const struct jet_code *c)
{
    int k = m->k, a = slot(m, c->a, 0), b = slot(m, c->b, 0), w = slot(m, c->w, 0), x = slot(m, c->x, 0), y = slot(m, c->y, 0);
    switch ((enum jet_op)c->op) {
    case JET_ADD: case JET_SUB:
        x64_load(&m->code, 0, a + k);
        x64_op_slot(&m->code, c->op == JET_ADD ? X64_ADD : X64_SUB, 0, b + k);
        break;
    case JET_NEG: case JET_AFFINE:
        x64_load(&m->code, 0, a + k);
        if (c->op == JET_NEG || c->sign < 0)
            negate(m);
        break;
    case JET_MUL:    product(m, c, a, b); break;
    case JET_SQUARE: square(m, a); break;
    case JET_DIV:
        if (m->p->flat[c->b]) {
            x64_load(&m->code, 0, a + k);
        } else {
            dot(m, b + 1, w, k);
            subtract_from(m, a + k);
        }
        x64_op_slot(&m->code, X64_DIV, 0, b);
        break;
    case JET_INVERSE:
        dot(m, a + 1, w, k);
        negate(m);
        x64_op_slot(&m->code, X64_DIV, 0, a);
        break;
    case JET_DERIVATIVE:
        number(m, FREE, k);
        x64_load(&m->code, 0, a + k);
        x64_op(&m->code, X64_MUL, 0, FREE);
        break;
    case JET_EXP:
        dot(m, x + 1, w, k);
        divide_by_order(m);
        break;
    case JET_SQRT:
        x64_load(&m->code, 0, a + k);
        if (k > 1) {
            dot(m, w + 1, w + 1, k - 1);
            subtract_from(m, a + k);
        }
        x64_load(&m->code, FREE, w);
        x64_op(&m->code, X64_ADD, FREE, FREE);
        x64_op(&m->code, X64_DIV, 0, FREE);
        break;
    case JET_TRIG:   trig(m, c, x, w, y); return true;
    case JET_POWER:  power(m, c, a, b, x, w, y); return true;
    case JET_TAN:
        dot(m, x + 1, y, k);
        divide_by_order(m);
        x64_store(&m->code, 0, w + k);
        square(m, w);
        if (c->sign < 0)
            negate(m);
        x64_store(&m->code, 0, y + k);
        return true;
    case JET_QUOTIENT:
        number(m, FREE, k * c->sign);
        x64_load(&m->code, 9, a + k);
        x64_op(&m->code, X64_MUL, 9, FREE);
        integrate(m, x, w, y);
        return true;
    default:
        return false;
    }
    x64_store(&m->code, 0, w + k);
    return true;
}

static bool one_order(struct maker *m)
{
    x64_enter(&m->code);
    number(m, SIGN, -0.0);
    for (int i = m->p->fixed; i < m->p->count; i++)
        if (!step(m, m->p->code + i))
            return false;
    x64_leave(&m->code);
    return m->code.count < MOST_BYTES;
}

bool jet_compile(struct jet_machine *machine, const struct jet_plan *p, int order, size_t stride)
{
    struct maker m = { .code.leaf = true, .p = p, .stride = (int)stride };
    if (!machine->memory || (double)p->rows * (double)stride > 1e7)
        return false;
    size_t *begin = sga_calloc((size_t)order + 1, sizeof *begin);
    bool ok = true;
    for (m.k = 1; m.k < order && ok; m.k++) {
        begin[m.k] = m.code.count;
        ok = one_order(&m);
    }
    machine->base = ok ? sga_exec_add(machine->memory, m.code.byte, m.code.count) : NULL;
    if (machine->base) {
        machine->at = sga_calloc((size_t)order + 1, sizeof *machine->at);
        for (int k = 1; k < order; k++)
            machine->at[k] = (void (*)(double *, double *, double *))((uintptr_t)machine->base + begin[k]);
    }
    free(begin);
    free(m.code.byte);
    return machine->base != NULL;
}

void jet_machine_clear(struct jet_machine *m)
{
    if (m->base)
        sga_exec_drop(m->memory, m->base);
    free(m->at);
    *m = (struct jet_machine){ .memory = m->memory };
}
