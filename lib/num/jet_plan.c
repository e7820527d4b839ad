/* From a tape to steps with recurrences: powers become products, functions get the
 * companion series that their recurrences need (the cosine of a sine, the square root under
 * an inverse sine, derivatives). Rows are the tape's slots and, after them, the companions. */
#include "jet_plan.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "op.h"
#include "tape_code.h"

struct planner {
    struct jet_plan *p;
    const struct num_tape *t;
    int *row;                  /* by slot of the tape */
    int *derivative; size_t derivative_cap;   /* by row: the row of its derivative, or -1 */
    size_t code_cap, turn_cap, flat_cap;
    bool fixed;                /* what is emitted now depends on no input */
};

static int new_row(struct planner *b)
{
    int r = b->p->rows++;
    SGA_RESERVE(b->derivative, b->derivative_cap, b->p->rows);
    SGA_RESERVE(b->p->flat, b->flat_cap, b->p->rows);
    b->derivative[r] = -1;
    b->p->flat[r] = b->fixed;
    return r;
}

static void emit(struct planner *b, struct jet_code c)
{
    struct jet_plan *p = b->p;
    SGA_RESERVE(p->code, b->code_cap, p->count + 1);
    p->code[p->count++] = c;
}

static int emit_new(struct planner *b, int op, int x, int y)
{
    int w = new_row(b);
    emit(b, (struct jet_code){ .op = op, .w = w, .a = x, .b = y });
    return w;
}

static int derivative_of(struct planner *b, int row)
{
    if (b->derivative[row] < 0) {
        int d = emit_new(b, JET_DERIVATIVE, row, 0);
        b->derivative[row] = d;
    }
    return b->derivative[row];
}

static int affine(struct planner *b, int row, int sign, int shift)
{
    int w = new_row(b);
    emit(b, (struct jet_code){ .op = JET_AFFINE, .w = w, .a = row, .sign = sign, .shift = shift });
    return w;
}

/* a^n by products, into row w. */
static void power(struct planner *b, int w, int a, int n)
{
    unsigned k = n < 0 ? -(unsigned)n : (unsigned)n;
    int result = -1, base = a;
    for (; k; k >>= 1) {
        if (k & 1)
            result = result < 0 ? base : emit_new(b, JET_MUL, result, base);
        if (k > 1)
            base = emit_new(b, JET_SQUARE, base, 0);
    }
    if (n < 0)
        emit(b, (struct jet_code){ .op = JET_INVERSE, .w = w, .a = result });
    else
        emit(b, (struct jet_code){ .op = JET_AFFINE, .w = w, .a = result, .sign = 1 });
}

/* w' x = sign a'. */
static void quotient(struct planner *b, int w, int a, int x, int sign, enum expr_op function)
{
    int y = new_row(b);
    b->derivative[w] = y;
    emit(b, (struct jet_code){ .op = JET_QUOTIENT, .w = w, .a = a, .x = x, .y = y, .sign = sign, .function = function });
}

static void real_power(struct planner *b, int w, int a, int e)
{
    if (b->p->flat[e]) {
        int x = derivative_of(b, a), y = new_row(b);
        b->derivative[w] = y;
        emit(b, (struct jet_code){ .op = JET_POWER, .w = w, .a = a, .b = e, .x = x, .y = y });
        return;
    }
    int l = new_row(b);
    quotient(b, l, a, a, 1, EXPR_LOG);
    int product = emit_new(b, JET_MUL, e, l);
    emit(b, (struct jet_code){ .op = JET_EXP, .w = w, .a = product, .x = derivative_of(b, product) });
}

/* f with f'(a) = sign (shift + factor a^power)^-1, or the root of that: w' (...) = sign a'. */
static void inverse_function(struct planner *b, enum expr_op op, int w, int a)
{
    const struct expr_slope *s = expr_op_slope(op);
    assert(s->of == EXPR_OF_ARGUMENT && s->halves < 0);
    int under = s->power == 1 ? a : affine(b, emit_new(b, JET_SQUARE, a, 0), s->factor, s->shift);
    quotient(b, w, a, s->halves == -1 ? emit_new(b, JET_SQRT, under, 0) : under, s->sign, op);
}

static void switching(struct planner *b, enum expr_op op, int w, int a, int c)
{
    bool two = op == EXPR_MIN || op == EXPR_MAX;
    int turn = two ? emit_new(b, JET_SUB, a, c) : a;
    int kind = op == EXPR_ABS ? JET_ABS : op == EXPR_SIGN ? JET_SIGN : op == EXPR_MIN ? JET_MIN : JET_MAX;
    emit(b, (struct jet_code){ .op = kind, .w = w, .a = a, .b = c, .x = turn });
    if (b->p->flat[turn])
        return;
    SGA_RESERVE(b->p->turn, b->turn_cap, b->p->turns + 1);
    b->p->turn[b->p->turns++] = turn;
}

/* sine and cosine (or hyperbolic) of a; either row may be -1. */
static void pair(struct planner *b, int sine, int cosine, int a, bool hyperbolic)
{
    int w = sine < 0 ? new_row(b) : sine, y = cosine < 0 ? new_row(b) : cosine;
    emit(b, (struct jet_code){ .op = JET_TRIG, .w = w, .a = a, .y = y, .x = derivative_of(b, a), .sign = hyperbolic ? 1 : -1 });
}

static void function(struct planner *b, int op, int w, int a, int c)
{
    switch (op) {
    case TAPE_SQUARE: emit(b, (struct jet_code){ .op = JET_SQUARE, .w = w, .a = a }); break;
    case TAPE_CUBE:   emit(b, (struct jet_code){ .op = JET_MUL, .w = w, .a = emit_new(b, JET_SQUARE, a, 0), .b = a }); break;
    case EXPR_POW:    real_power(b, w, a, c); break;
    case TAPE_SINCOS: pair(b, w, w + 1, a, false); break;
    case EXPR_SIN:    pair(b, w, -1, a, false); break;
    case EXPR_COS:    pair(b, -1, w, a, false); break;
    case EXPR_SINH:   pair(b, w, -1, a, true); break;
    case EXPR_COSH:   pair(b, -1, w, a, true); break;
    case EXPR_TAN: case EXPR_TANH: {
        int x = derivative_of(b, a), y = new_row(b);
        emit(b, (struct jet_code){ .op = JET_TAN, .w = w, .a = a, .x = x, .y = y, .sign = op == EXPR_TAN ? 1 : -1, .function = (enum expr_op)op });
        break;
    }
    case EXPR_EXP:    emit(b, (struct jet_code){ .op = JET_EXP, .w = w, .a = a, .x = derivative_of(b, a) }); break;
    case EXPR_SQRT:   emit(b, (struct jet_code){ .op = JET_SQRT, .w = w, .a = a }); break;
    case EXPR_CBRT: {
        int x = derivative_of(b, a), y = new_row(b);
        b->derivative[w] = y;
        emit(b, (struct jet_code){ .op = JET_POWER, .w = w, .a = a, .b = a, .x = x, .y = y, .shift = 3 });
        break;
    }
    case EXPR_ATAN2: {
        int p = derivative_of(b, a), q = derivative_of(b, c);
        int x = emit_new(b, JET_ADD, emit_new(b, JET_SQUARE, a, 0), emit_new(b, JET_SQUARE, c, 0)), y = new_row(b);
        b->derivative[w] = y;
        emit(b, (struct jet_code){ .op = JET_ATAN2, .w = w, .a = a, .b = c, .x = x, .y = y, .p = p, .q = q });
        break;
    }
    case EXPR_ABS: case EXPR_SIGN: case EXPR_MIN: case EXPR_MAX: switching(b, (enum expr_op)op, w, a, c); break;
    default:          inverse_function(b, (enum expr_op)op, w, a); break;
    }
}

static void solve(struct planner *b, int index)
{
    const struct tape_solve *s = b->t->solve + index;
    struct jet_solve *q = b->p->solve + index;
    size_t m = (size_t)s->m;
    q->m = s->m;
    q->matrix = sga_malloc(m * m * sizeof(int));
    q->rhs = sga_malloc(m * sizeof(int));
    q->y = sga_malloc(m * sizeof(int));
    for (size_t i = 0; i < m * m; i++)
        q->matrix[i] = b->row[s->matrix[i]];
    for (size_t i = 0; i < m; i++) {
        q->rhs[i] = b->row[s->rhs[i]];
        q->y[i] = new_row(b);
    }
    emit(b, (struct jet_code){ .op = JET_SOLVE, .a = index });
}

static void take(struct planner *b, int i)
{
    const struct tape_code *c = b->t->code + i;
    int slot = b->t->code_slot + i, w = b->row[slot];
    b->p->flat[w] = b->fixed;
    switch (c->op) {
    case EXPR_ADD: case EXPR_SUB: case EXPR_MUL: case EXPR_DIV: {
        int op = c->op == EXPR_ADD ? JET_ADD : c->op == EXPR_SUB ? JET_SUB : c->op == EXPR_MUL ? JET_MUL : JET_DIV;
        emit(b, (struct jet_code){ .op = op, .w = w, .a = b->row[c->a], .b = b->row[c->b] });
        break;
    }
    case EXPR_NEG:  emit(b, (struct jet_code){ .op = JET_NEG, .w = w, .a = b->row[c->a] }); break;
    case EXPR_POWI: power(b, w, b->row[c->a], c->b); break;
    case TAPE_PAIRED: break;
    case TAPE_FACTOR: solve(b, c->a); break;
    case TAPE_SIGNAL: emit(b, (struct jet_code){ .op = JET_TABLE, .w = w, .a = b->row[c->a], .b = c->b }); break;
    case TAPE_COMPONENT: b->row[slot] = b->p->solve[c->a].y[c->b]; break;
    default: function(b, c->op, w, b->row[c->a], expr_op_args((enum expr_op)(c->op < EXPR_OP_COUNT ? c->op : EXPR_NEG)) == 2 ? b->row[c->b] : 0);
    }
}

static void constants(struct jet_plan *p, const struct num_tape *t)
{
    p->first_constant = t->ninputs;
    p->constants = t->code_slot - t->ninputs;
    p->constant = sga_calloc((size_t)p->constants + 1, sizeof *p->constant);
    for (int i = 0; i < p->constants; i++)
        p->constant[i] = (num_dd){ t->value[t->ninputs + i], t->low[i] };
}

void jet_plan_make(struct jet_plan *p, const struct num_tape *t)
{
    *p = (struct jet_plan){ .inputs = t->ninputs, .roots = t->nroots, .solves = t->nsolves };
    struct planner b = { .p = p, .t = t };
    b.row = sga_malloc(((size_t)t->slots + 1) * sizeof *b.row);
    p->solve = sga_calloc((size_t)t->nsolves + 1, sizeof *p->solve);
    for (int s = 0; s < t->slots; s++) {
        b.fixed = s >= t->ninputs && s < t->code_slot + t->nstatic;
        b.row[s] = new_row(&b);
    }
    constants(p, t);
    p->tables = t->ntables;
    p->table = sga_malloc(((size_t)t->ntables + 1) * sizeof *p->table);
    for (int k = 0; k < t->ntables; k++)
        p->table[k] = t->table[k];
    for (int i = 0; i < t->ncode; i++) {
        b.fixed = i < t->nstatic;
        if (i == t->nstatic)
            p->fixed = p->count;
        take(&b, i);
    }
    if (t->nstatic == t->ncode)
        p->fixed = p->count;
    p->root = sga_malloc(((size_t)t->nroots + 1) * sizeof *p->root);
    for (int r = 0; r < t->nroots; r++)
        p->root[r] = b.row[t->root[r]];
    free(b.row);
    free(b.derivative);
}

void jet_plan_clear(struct jet_plan *p)
{
    for (int i = 0; i < p->solves; i++) {
        free(p->solve[i].matrix);
        free(p->solve[i].rhs);
        free(p->solve[i].y);
    }
    free(p->solve);
    free(p->table);
    free(p->code);
    free(p->root);
    free(p->turn);
    free(p->constant);
    free(p->flat);
    *p = (struct jet_plan){ 0 };
}
