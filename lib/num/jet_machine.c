/* Programs of series: performed one act after the other, and once they have been often enough as machine code (x86-64),
 * with the same operations in the same order. */
#define _GNU_SOURCE    /* sincos */
#include "jet_machine.h"

#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "exec.h"
#include "jet_programs.h"
#include "mem.h"
#include "tape_code.h"
#include "value.h"
#include "x64.h"

enum { MOST_BYTES = 1 << 20, MINUS = 15 };

/* sum of n products as the routines below have it: four sums, of which the first and the second two make one each. */
static double products(const double *a, const double *b, int n)
{
    double s0 = a[0] * b[0], s1 = a[1] * b[1];
    if (n >= 4) {
        double s2 = a[2] * b[2], s3 = a[3] * b[3];
        int i = 4;
        for (; i + 3 < n; i += 4) {
            s0 += a[i] * b[i];
            s1 += a[i + 1] * b[i + 1];
            s2 += a[i + 2] * b[i + 2];
            s3 += a[i + 3] * b[i + 3];
        }
        if (i + 1 < n) {
            s0 += a[i] * b[i];
            s1 += a[i + 1] * b[i + 1];
        }
        s0 += s2;
        s1 += s3;
    }
    return n % 2 ? (s0 + s1) + a[n - 1] * b[n - 1] : s0 + s1;
}

static void perform(const struct jet_series *q, double *series, int last)
{
    double *slot = q->slot, *r = q->memory;
    for (const struct jet_act *c = q->act, *end = c + q->acts; c < end; c++) {
        switch ((enum jet_act_kind)c->kind) {
        case ACT_MOVE:       r[c->to] = r[c->from]; break;
        case ACT_LOAD:       r[c->to] = slot[c->slot]; break;
        case ACT_STORE:      slot[c->slot] = r[c->to]; break;
        case ACT_ADD:        r[c->to] += r[c->from]; break;
        case ACT_SUB:        r[c->to] -= r[c->from]; break;
        case ACT_MUL:        r[c->to] *= r[c->from]; break;
        case ACT_DIV:        r[c->to] /= r[c->from]; break;
        case ACT_ADD_SLOT:   r[c->to] += slot[c->slot]; break;
        case ACT_SUB_SLOT:   r[c->to] -= slot[c->slot]; break;
        case ACT_MUL_SLOT:   r[c->to] *= slot[c->slot]; break;
        case ACT_DIV_SLOT:   r[c->to] /= slot[c->slot]; break;
        case ACT_SQRT:       r[c->to] = sqrt(r[c->from]); break;
        case ACT_NEGATE:     r[c->to] = -r[c->to]; break;
        case ACT_ZERO:       r[c->to] = 0; break;
        case ACT_PRODUCT: {
            double v = slot[c->slot] * slot[c->other];
            r[c->to] = c->number == 2 ? v + v : v;
            break;
        }
        case ACT_ADD_PRODUCT: {
            double v = slot[c->slot] * slot[c->other];
            r[c->to] += c->number == 2 ? v + v : v;
            break;
        }
        case ACT_SUB_PRODUCT: {
            double v = slot[c->slot] * slot[c->other];
            r[c->to] -= c->number == 2 ? v + v : v;
            break;
        }
        case ACT_STORE_BOTH: slot[c->slot] = slot[c->other] = r[c->to]; break;
        case ACT_PRODUCTS:   r[c->to] = products(slot + c->slot, slot + c->other, c->number); break;
        case ACT_OUT:        series[c->slot] = r[c->to]; break;
        case ACT_CALL:       r[0] = expr_function_value((enum expr_op)c->number, r[0]); break;
        case ACT_REAL_POWER: r[0] = tape_real_power(r[0], r[1]); break;
        case ACT_SINCOS:     sincos(r[0], slot + c->slot, slot + c->other); break;
        case ACT_LEAVE:
            if (c->number == last)
                return;
        }
    }
}

/* Routine n: the sum of n products of what rsi and rdx point to, into register 0. */
static void routine(struct x64 *x, int n)
{
    for (int i = 0; i + 1 < n; i += 2) {
        int sum = i / 2 % 2, reg = i < 4 ? sum : 2 + sum;
        x64_pair_load_rsi(x, reg, i);
        x64_pair_mul_rdx(x, reg, i);
        if (i >= 4)
            x64_pair(x, X64_PAIR_ADD, sum, reg);
    }
    if (n >= 4)
        x64_pair(x, X64_PAIR_ADD, 0, 1);
    if (n % 2) {
        x64_load_rsi(x, 2, n - 1);
        x64_mul_rdx(x, 2, n - 1);
    }
    x64_move(x, 1, 0);
    x64_pair(x, X64_PAIR_HIGH, 1, 1);
    x64_op(x, X64_ADD, 0, 1);
    if (n % 2)
        x64_op(x, X64_ADD, 0, 2);
    x64_return(x);
}

static void sign(struct x64 *x) { x64_constant(x, MINUS, 0x8000000000000000u); }

static void call(struct x64 *x, const struct jet_act *c)
{
    if (c->kind == ACT_SINCOS) {
        x64_slot_address(x, X64_RDI, c->slot);
        x64_slot_address(x, X64_RSI, c->other);
        x64_call(x, (uintptr_t)sincos);
    } else if (c->kind == ACT_CALL) {
        x64_word(x, X64_RDI, (uint64_t)c->number);
        x64_call(x, (uintptr_t)expr_function_value);
    } else {
        x64_call(x, (uintptr_t)tape_real_power);
    }
    sign(x);
}

static void product(struct x64 *x, const struct jet_act *c)
{
    int at = c->kind == ACT_PRODUCT ? c->to : c->from;
    if (c->slot < 0)
        x64_move(x, at, c->slot + JET_REGISTERS);
    else
        x64_load(x, at, c->slot);
    if (c->other < 0)
        x64_op(x, X64_MUL, at, c->other + JET_REGISTERS);
    else
        x64_op_slot(x, X64_MUL, at, c->other);
    if (c->number == 2)
        x64_op(x, X64_ADD, at, at);
    if (c->kind != ACT_PRODUCT)
        x64_op(x, c->kind == ACT_ADD_PRODUCT ? X64_ADD : X64_SUB, c->to, at);
}

static void encode(struct x64 *x, const struct jet_act *c, const size_t *begin)
{
    static const enum x64_sd op[] = { X64_ADD, X64_SUB, X64_MUL, X64_DIV };
    switch ((enum jet_act_kind)c->kind) {
    case ACT_MOVE:       x64_move(x, c->to, c->from); break;
    case ACT_LOAD:       x64_load(x, c->to, c->slot); break;
    case ACT_STORE:      x64_store(x, c->to, c->slot); break;
    case ACT_ADD: case ACT_SUB: case ACT_MUL: case ACT_DIV: x64_op(x, op[c->kind - ACT_ADD], c->to, c->from); break;
    case ACT_ADD_SLOT: case ACT_SUB_SLOT: case ACT_MUL_SLOT: case ACT_DIV_SLOT:
        x64_op_slot(x, op[c->kind - ACT_ADD_SLOT], c->to, c->slot);
        break;
    case ACT_SQRT:       x64_op(x, X64_SQRT, c->to, c->from); break;
    case ACT_NEGATE:     x64_bitwise(x, X64_XOR, c->to, MINUS); break;
    case ACT_PRODUCT: case ACT_ADD_PRODUCT: case ACT_SUB_PRODUCT: product(x, c); break;
    case ACT_STORE_BOTH:
        x64_store(x, c->to, c->slot);
        x64_store(x, c->to, c->other);
        break;
    case ACT_ZERO:       x64_bitwise(x, X64_XOR, c->to, c->to); break;
    case ACT_PRODUCTS:
        x64_slot_address(x, X64_RSI, c->slot);
        x64_slot_address(x, X64_RDX, c->other);
        x64_call_back(x, begin[c->number]);
        x64_move(x, c->to, 0);
        break;
    case ACT_OUT:        x64_store_out(x, c->to, false, c->slot); break;
    case ACT_CALL: case ACT_REAL_POWER: case ACT_SINCOS: call(x, c); break;
    case ACT_LEAVE:      break;
    }
}

static void compile(struct jet_machine *m)
{
    const struct jet_series *q = &m->series;
    struct x64 x = { 0 };
    SGA_FREED size_t *begin = sga_calloc(2 * (size_t)q->most + 4, sizeof *begin);
    size_t *leave = begin + q->most + 2;
    for (int n = JET_PAIRS_FROM; n <= q->most + 1; n++) {
        begin[n] = x.count;
        routine(&x, n);
    }
    size_t entry = x.count;
    int leaves = 0;
    x64_enter(&x);
    sign(&x);
    for (size_t i = 0; i < q->acts && x.count < MOST_BYTES; i++) {
        if (q->act[i].kind == ACT_LEAVE)
            leave[leaves++] = x64_leave_if(&x, q->act[i].number);
        else
            encode(&x, q->act + i, begin);
    }
    while (leaves)
        x64_arrive(&x, leave[--leaves]);
    x64_leave(&x);
    m->base = x.count < MOST_BYTES ? sga_exec_add(m->memory, x.byte, x.count) : NULL;
    m->bytes = x.count;
    if (m->base)
        m->run = (void (*)(double *, double *, double *, long))((uintptr_t)m->base + entry);
    free(x.byte);
}

static bool all_finite(const double *v, int n)
{
    double a = 0, b = 0;
    int i = 0;
    for (; i + 1 < n; i += 2) {
        a += 0.0 * v[i];
        b += 0.0 * v[i + 1];
    }
    return (i < n ? a + 0.0 * v[i] : a) + b == 0;
}

bool jet_machine_along(struct jet_machine *m, int order, double t, double scale, double *series)
{
    const struct jet_series *q = &m->series;
    double *slot = q->slot;
    if (m->scale != scale) {
        m->scale = scale;
        for (int k = 1; k < q->most + 2; k++)
            slot[q->part + k] = scale * (1.0 / k);
    }
    for (int i = 0; i < q->count; i++)
        slot[i * q->stride] = series[i];
    slot[q->count * q->stride] = t;
    if (!m->run && m->memory && ++m->runs == JET_RUNS_BEFORE)
        compile(m);
    if (m->run)
        m->run(slot, series, NULL, order);
    else
        perform(q, series, order);
    return all_finite(series + q->count, q->count * order);
}

void jet_machine_begin(struct jet_machine *m, const struct jet_plan *p, int order, int count, const double *row, size_t stride)
{
    m->asked = true;
    if (m->kept && m->memory && jet_programs_find(m->kept, m, p, order, count)) {
        m->has = m->shared = true;
        jet_series_fill(&m->series, p, row, stride);
    } else {
        m->has = jet_series_make(&m->series, p, order, count, row, stride);
    }
}

void jet_machine_clear(struct jet_machine *m, const struct jet_plan *p)
{
    free(m->series.memory);
    if (!m->shared && !(m->base && m->kept && jet_programs_keep(m->kept, m, p))) {
        if (m->base)
            sga_exec_drop(m->memory, m->base);
        free(m->series.act);
    }
    *m = (struct jet_machine){ .memory = m->memory, .kept = m->kept };
}
