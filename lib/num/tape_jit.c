/* Tapes as machine code (x86-64).
 *
 * One pass over the straight-line code; each instruction becomes a load, an operation and
 * a store, of which most loads and stores are left out: fifteen registers hold the values
 * that are read soonest, and a value goes to its slot when its register is wanted for one
 * that is read earlier (Belady's rule, which is exact here, as the code has no branches), before
 * a call, or when somebody will look at the slot. Each operation is the same IEEE operation, and each
 * function the same function of libm, that the interpreter uses; what is rare is left to
 * the interpreter, one instruction at a time. The sixteenth register is for constants. */
#define _GNU_SOURCE    /* sincos */
#include "tape_jit.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "exec.h"
#include "mem.h"
#include "tape_compiler.h"

static bool is_input(const struct compiler *c, int slot)
{
    return c->t->reads_inputs && !c->stages && slot < c->t->ninputs - 1;
}

void compiler_load(struct compiler *c, int reg, int slot)
{
    if (is_input(c, slot))
        x64_load_input(&c->code, reg, slot);
    else
        x64_load(&c->code, reg, slot);
}

static void op_slot(struct compiler *c, enum x64_sd op, int to, int slot)
{
    if (is_input(c, slot))
        x64_op_input(&c->code, op, to, slot);
    else
        x64_op_slot(&c->code, op, to, slot);
}

static double (*const function[EXPR_OP_COUNT])(double) = {
#define X(sym, name) [EXPR_##sym] = name,
    EXPR_ELEMENTARY_TABLE(X)
#undef X
    [EXPR_CBRT] = cbrt,
    [EXPR_SIGN] = tape_sign,
};
static double (*const function2[EXPR_OP_COUNT])(double, double) = {
    [EXPR_POW] = tape_real_power, [EXPR_ATAN2] = atan2, [EXPR_MIN] = tape_least, [EXPR_MAX] = tape_greatest,
};

/* Backwards: who reads each value next. */
void compiler_find_uses(struct compiler *c, int from)
{
    const struct num_tape *t = c->t;
    for (int s = 0; s < t->slots; s++)
        c->next[s] = NEVER;
    for (int r = 0; c->stages && r < t->first_roots; r++)
        c->next[t->root[r]] = t->ncode;
    for (int i = t->ncode - 1; i >= from; i--) {
        const struct tape_code *q = t->code + i;
        c->after[i] = c->next[t->code_slot + i];
        if (q->op == TAPE_PAIRED || q->op == TAPE_COMPONENT)
            continue;
        if (q->op == TAPE_FACTOR) {
            const struct tape_solve *s = t->solve + q->a;
            for (int k = 0; k < s->m * s->m; k++)
                c->next[s->matrix[k]] = i;
            for (int k = 0; k < s->m; k++)
                c->next[s->rhs[k]] = i;
            continue;
        }
        if (q->op == TAPE_SLOPE_A || q->op == TAPE_SLOPE_B) {
            const struct tape_code *of = t->code + q->a - t->code_slot;
            c->next[q->a] = c->next[of->a] = i;
            if (tape_reads_two(of->op))
                c->next[of->b] = i;
            continue;
        }
        bool two = tape_reads_two(q->op);
        c->after_a[i] = c->next[q->a];
        c->after_b[i] = two ? c->next[q->b] : NEVER;
        c->next[q->a] = i;
        if (two)
            c->next[q->b] = i;
    }
    assert(from <= t->ncode);
}

void compiler_release(struct compiler *c, int reg)
{
    assert(reg >= 0 && reg < REGISTERS);
    if (c->held[reg] != NONE)
        c->where[c->held[reg]] = NONE;
    c->held[reg] = NONE;
}

static void save(struct compiler *c, int reg)
{
    int slot = c->held[reg];
    if (slot == NONE || !c->unsaved[slot] || c->next[slot] == NEVER)
        return;
    x64_store(&c->code, reg, slot);
    c->unsaved[slot] = 0;
}

void compiler_bind(struct compiler *c, int reg, int slot)
{
    assert(reg >= 0 && reg < REGISTERS && slot >= 0);
    c->held[reg] = slot;
    c->where[slot] = (signed char)reg;
}

int compiler_register(struct compiler *c, int not_this, int nor_this)
{
    int best = NONE;
    for (int r = 0; r < REGISTERS; r++) {
        if (c->held[r] == NONE)
            return r;
        if (r != not_this && r != nor_this && (best == NONE || c->next[c->held[r]] > c->next[c->held[best]]))
            best = r;
    }
    save(c, best);
    compiler_release(c, best);
    return best;
}

/* The register of a value; one that is read again later is given one. NONE: in memory, for this once. */
static int operand(struct compiler *c, int slot, int other)
{
    int r = c->where[slot];
    if (r != NONE || c->next[slot] == NEVER)
        return r;
    r = compiler_register(c, other, NONE);
    compiler_load(c, r, slot);
    compiler_bind(c, r, slot);
    return r;
}

static void copy(struct compiler *c, int to, int slot)
{
    if (c->where[slot] == NONE)
        compiler_load(c, to, slot);
    else
        x64_move(&c->code, to, c->where[slot]);
}

static void forget_dead(struct compiler *c, int slot)
{
    if (c->where[slot] != NONE && c->next[slot] == NEVER)
        compiler_release(c, c->where[slot]);
}

void compiler_deliver(struct compiler *c, int reg, int slot)
{
    int first = c->t->first_roots;
    for (int r = c->root[slot]; r != NONE; r = c->next_root[r]) {
        if (r < first && c->stages)
            continue;
        x64_store_out(&c->code, reg, r >= first, r >= first ? c->rest_at + r - first : r);
        c->delivered[r] = 1;
    }
}

static bool wanted(const struct compiler *c, int slot)
{
    return c->next[slot] != NEVER || c->root[slot] != NONE;
}

/* The value of instruction i now stands in a register. */
static void define(struct compiler *c, int i, int reg)
{
    int slot = c->t->code_slot + i;
    c->next[slot] = c->after[i];
    c->unsaved[slot] = !c->t->keep_all;
    if (c->t->keep_all)
        x64_store(&c->code, reg, slot);
    if (c->timed && i < c->t->ntimed && wanted(c, slot)) {      /* for the next evaluation at this time */
        x64_store(&c->code, reg, slot);
        c->unsaved[slot] = 0;
    } else {
        compiler_deliver(c, reg, slot);
    }
    compiler_bind(c, reg, slot);
    forget_dead(c, slot);
}

static void binary(struct compiler *c, int i, enum x64_sd op, int a, int b)
{
    c->next[a] = c->after_a[i];
    c->next[b] = a == b ? c->after_a[i] : c->after_b[i];
    int ra = operand(c, a, c->where[b]), rb = operand(c, b, ra), to = NONE;
    bool either = op == X64_ADD || op == X64_MUL;
    if (ra != NONE && c->next[a] == NEVER) {
        to = ra;
    } else if (either && rb != NONE && c->next[b] == NEVER) {
        to = rb;
        rb = ra;
        b = a;
    } else {
        to = compiler_register(c, ra, rb);
        copy(c, to, a);
    }
    if (rb != NONE)
        x64_op(&c->code, op, to, rb);
    else
        op_slot(c, op, to, b);
    compiler_release(c, to);
    forget_dead(c, c->t->code[i].a);
    if (tape_reads_two(c->t->code[i].op))
        forget_dead(c, c->t->code[i].b);
    define(c, i, to);
}

/* Square-and-multiply as in the interpreter, the base in SCRATCH. */
static void power(struct x64 *x, int to, int n)
{
    bool begun = false;
    for (unsigned k = n < 0 ? -(unsigned)n : (unsigned)n; k; k >>= 1) {
        if (k & 1 && begun)
            x64_op(x, X64_MUL, to, SCRATCH);
        else if (k & 1)
            x64_move(x, to, SCRATCH);
        begun |= k & 1;
        if (k > 1)
            x64_op(x, X64_MUL, SCRATCH, SCRATCH);
    }
    if (n >= 0)
        return;
    x64_constant(x, SCRATCH, 0x3FF0000000000000u);
    x64_op(x, X64_DIV, SCRATCH, to);
    x64_move(x, to, SCRATCH);
}

static void unary(struct compiler *c, int i)
{
    const struct tape_code *q = c->t->code + i;
    struct x64 *x = &c->code;
    c->next[q->a] = c->after_a[i];
    int ra = operand(c, q->a, NONE), to = compiler_register(c, ra, NONE);
    if (q->op == EXPR_NEG || q->op == EXPR_ABS) {
        copy(c, to, q->a);
        x64_constant(x, SCRATCH, q->op == EXPR_NEG ? 0x8000000000000000u : 0x7FFFFFFFFFFFFFFFu);
        x64_bitwise(x, q->op == EXPR_NEG ? X64_XOR : X64_AND, to, SCRATCH);
    } else {
        copy(c, SCRATCH, q->a);
        if (q->op == EXPR_SQRT)
            x64_op(x, X64_SQRT, to, SCRATCH);
        else
            power(x, to, q->op == TAPE_CUBE ? 3 : q->b);
    }
    forget_dead(c, q->a);
    define(c, i, to);
}

/* Calls leave nothing in the registers. */
static void save_all(struct compiler *c)
{
    for (int r = 0; r < REGISTERS; r++)
        save(c, r);
}

static void release_all(struct compiler *c)
{
    for (int r = 0; r < REGISTERS; r++)
        compiler_release(c, r);
}

/* sin and the like: argument and value in register 0. */
static void call(struct compiler *c, int i)
{
    const struct tape_code *q = c->t->code + i;
    int s = c->t->code_slot + i;
    c->next[q->a] = c->after_a[i];
    save_all(c);
    copy(c, 0, q->a);
    release_all(c);
    if (q->op != TAPE_SINCOS) {
        x64_call(&c->code, (uintptr_t)function[q->op]);
        define(c, i, 0);
        return;
    }
    x64_slot_address(&c->code, X64_RDI, s);
    x64_slot_address(&c->code, X64_RSI, s + 1);
    x64_call(&c->code, (uintptr_t)sincos);
    c->next[s] = c->after[i];
    c->next[s + 1] = c->after[i + 1];
}

/* pow and the like: arguments in registers 0 and 1. */
static void call2(struct compiler *c, int i)
{
    const struct tape_code *q = c->t->code + i;
    c->next[q->a] = c->after_a[i];
    c->next[q->b] = q->a == q->b ? c->after_a[i] : c->after_b[i];
    save_all(c);
    copy(c, SCRATCH, q->b);
    copy(c, 0, q->a);
    x64_move(&c->code, 1, SCRATCH);
    release_all(c);
    x64_call(&c->code, (uintptr_t)function2[q->op]);
    define(c, i, 0);
}

static void interpret(struct compiler *c, int i)
{
    save_all(c);
    release_all(c);
    x64_word(&c->code, X64_RDI, (uintptr_t)c->t);
    x64_word(&c->code, X64_RSI, (uint64_t)i);
    x64_word(&c->code, X64_RDX, (uint64_t)i + 1);
    x64_call(&c->code, (uintptr_t)tape_run);
    c->next[c->t->code_slot + i] = c->after[i];
}

static void component(struct compiler *c, int i)
{
    const struct tape_code *q = c->t->code + i;
    int to = compiler_register(c, NONE, NONE);
    x64_load_at(&c->code, to, c->t->solve[q->a].y + q->b);
    define(c, i, to);
}

/* No call, and no interpreter. */
static bool in_line(int op)
{
    static const int all[] = { EXPR_ADD, EXPR_SUB, EXPR_MUL, EXPR_DIV, EXPR_NEG, EXPR_ABS, EXPR_SQRT, EXPR_POWI,
                               TAPE_SQUARE, TAPE_CUBE, TAPE_COMPONENT, TAPE_PAIRED };
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (op == all[k])
            return true;
    return false;
}

void compiler_instruction(struct compiler *c, int i)
{
    assert(i >= 0 && i < c->t->ncode);
    const struct tape_code *q = c->t->code + i;
    switch (q->op) {
    case EXPR_ADD: binary(c, i, X64_ADD, q->a, q->b); break;
    case EXPR_SUB: binary(c, i, X64_SUB, q->a, q->b); break;
    case EXPR_MUL: binary(c, i, X64_MUL, q->a, q->b); break;
    case EXPR_DIV: binary(c, i, X64_DIV, q->a, q->b); break;
    case TAPE_SQUARE: binary(c, i, X64_MUL, q->a, q->a); break;
    case EXPR_NEG: case EXPR_ABS: case EXPR_SQRT: case TAPE_CUBE: case EXPR_POWI: unary(c, i); break;
    case TAPE_COMPONENT: component(c, i); break;
    case TAPE_PAIRED: break;
    default:
        if (q->op == TAPE_SINCOS || (q->op < EXPR_OP_COUNT && function[q->op]))
            call(c, i);
        else if (q->op < EXPR_OP_COUNT && function2[q->op])
            call2(c, i);
        else
            interpret(c, i);
    }
}

/* Without calls the code is a leaf; what is left to the interpreter reads inputs in their slots. */
void compiler_look(struct compiler *c)
{
    struct num_tape *t = c->t;
    c->code.leaf = true;
    t->reads_inputs = !t->keep_all;
    c->timed = false;
    bool changes = false;
    for (int i = t->nstatic; i < t->ncode; i++) {
        int op = t->code[i].op;
        if (op == TAPE_SINCOS || (op < EXPR_OP_COUNT && (function[op] || function2[op]))) {
            c->code.leaf = false;
            c->timed |= i < t->ntimed && !t->keep_all;
        } else if (!in_line(op)) {
            c->code.leaf = t->reads_inputs = false;
            changes |= op == TAPE_SIGNAL;
        }
    }
    c->timed &= !changes;      /* where its pieces meet, a signal has two values at one time */
}

void compiler_begin(struct compiler *c, struct num_tape *t)
{
    size_t code = (size_t)t->ncode + 1, slots = (size_t)t->slots + OWN_SLOTS;
    *c = (struct compiler){ .t = t };
    c->after_a = sga_malloc(3 * code * sizeof *c->after_a);
    c->after_b = c->after_a + code;
    c->after = c->after_b + code;
    c->next = sga_malloc(slots * sizeof *c->next);
    c->where = sga_malloc(slots);
    c->unsaved = sga_calloc(slots, 1);
    c->root = sga_malloc(slots * sizeof *c->root);
    c->next_root = sga_malloc(((size_t)t->nroots + 1) * sizeof *c->next_root);
    c->delivered = sga_calloc((size_t)t->nroots + 1, 1);
    memset(c->where, NONE, slots);
    memset(c->root, NONE, slots * sizeof *c->root);
    for (int r = 0; r < t->nroots; r++) {
        c->next_root[r] = c->root[t->root[r]];
        c->root[t->root[r]] = r;
    }
    for (int r = 0; r < REGISTERS; r++)
        c->held[r] = NONE;
}

void compiler_end(struct compiler *c)
{
    free(c->after_a);
    free(c->next);
    free(c->where);
    free(c->unsaved);
    free(c->root);
    free(c->next_root);
    free(c->delivered);
    free(c->code.byte);
}

void compiler_deliver_rest(struct compiler *c)
{
    for (int r = 0; r < c->t->nroots; r++) {
        if (c->delivered[r] || (r < c->t->first_roots && c->stages))
            continue;
        compiler_load(c, SCRATCH, c->t->root[r]);
        compiler_deliver(c, SCRATCH, c->t->root[r]);
    }
}

/* Whether the code holds no address of the tape's own. */
static bool by_structure(const struct num_tape *t)
{
    for (int i = t->nstatic; i < t->ncode; i++) {
        int op = t->code[i].op;
        if (op == TAPE_COMPONENT || !(in_line(op) || op == TAPE_SINCOS || (op < EXPR_OP_COUNT && (function[op] || function2[op]))))
            return false;
    }
    return true;
}

/* All that tape_compile reads of a tape by_structure; malloced. */
static void *key_of(const struct num_tape *t, size_t *bytes)
{
    const int head[] = { t->ninputs, t->nroots, t->code_slot, t->ncode, t->nstatic, t->ntimed, t->slots, t->first_roots, t->keep_all };
    size_t code = (size_t)(t->ncode - t->nstatic) * sizeof *t->code, roots = (size_t)t->nroots * sizeof *t->root;
    *bytes = sizeof head + code + roots;
    char *key = sga_malloc(*bytes);
    memcpy(key, head, sizeof head);
    if (code)
        memcpy(key + sizeof head, t->code + t->nstatic, code);
    if (roots)
        memcpy(key + sizeof head + code, t->root, roots);
    return key;
}

static const void *make(struct num_tape *t)
{
    struct compiler c;
    compiler_begin(&c, t);
    compiler_find_uses(&c, t->nstatic);
    compiler_look(&c);
    x64_enter(&c.code);
    int i = t->nstatic;
    if (c.timed) {
        size_t jump = x64_if_other(&c.code, t->ninputs - 1, t->slots);
        for (; i < t->ntimed; i++)
            compiler_instruction(&c, i);
        release_all(&c);
        x64_arrive(&c.code, jump);
    }
    for (; i < t->ncode; i++)
        compiler_instruction(&c, i);
    compiler_deliver_rest(&c);
    x64_leave(&c.code);
    const void *at = sga_exec_add(t->memory, c.code.byte, c.code.count);
    compiler_end(&c);
    return at;
}

bool tape_compile(struct num_tape *t)
{
    if (t->slots > INT_MAX / 16)
        return false;
    size_t bytes = 0;
    SGA_FREED void *key = by_structure(t) ? key_of(t, &bytes) : NULL;
    const void *at = key ? sga_exec_known(t->memory, key, bytes) : NULL;
    if (at) {
        compiler_look(&(struct compiler){ .t = t });
    } else {
        at = make(t);
        if (at && key)
            sga_exec_name(t->memory, at, key, bytes);
    }
    tape_forget_time(t);
    if (at)
        t->compiled = (void (*)(double *, double *, double *, const double *))(uintptr_t)at;
    return at != NULL;
}
