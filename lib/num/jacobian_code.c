/* A Jacobian as a tape of its own: the code of the function, then the partial derivatives,
 * then the sums that the sweeps of jacobian_eval.c form, written out; so it can become
 * machine code like any tape.
 *
 * Factors 1 and -1 are not multiplied by, signs are carried along, and sums that the
 * structure makes 0 are left out: nothing of that changes a bit, save the sign of a zero,
 * which both ways end without. The sweeps skip what is multiplied by 0; here an infinite
 * slope times 0 gives NaN, which no later sum or product removes: so where all
 * results are finite they are those of the sweeps, and otherwise the sweeps are asked. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "jacobian.h"
#include "jacobian_plan.h"
#include "mem.h"

/* Beyond so many instructions the sweeps are kept. */
enum { MOST = 60000 };

/* A number while code is made: 0, or +-1, or +- what a slot of the new tape holds. Constants
 * have negative slots until all of them are known. */
struct factor {
    int slot;
    bool negative;
};
enum { NOTHING = INT32_MIN, UNIT, ZERO_SLOT = -1, ONE_SLOT = -2 };

struct maker {
    const struct num_jacobian *j;
    const struct num_jacobian_plan *p;
    struct num_tape *t;          /* made here; code_slot is still that of the function's tape, less its constants */
    size_t code_cap, constant_cap;
    double *constant;            /* constant k has slot -1 - k */
    int constants;
    struct factor *pa, *pb;      /* by step: its partials, once known */
    unsigned char *known;
    struct factor *sum;          /* by id: adjoint or tangent */
};

static int emit(struct maker *m, int op, int a, int b)
{
    SGA_RESERVE(m->t->code, m->code_cap, m->t->ncode + 1);
    m->t->code[m->t->ncode] = (struct tape_code){ .op = op, .a = a, .b = b };
    return m->t->code_slot + m->t->ncode++;
}

static int constant(struct maker *m, double value)
{
    for (int k = 0; k < m->constants; k++)
        if (m->constant[k] == value)
            return -1 - k;
    SGA_RESERVE(m->constant, m->constant_cap, m->constants + 1);
    m->constant[m->constants] = value;
    return -1 - m->constants++;
}

static struct factor product(struct maker *m, struct factor x, struct factor y)
{
    if (x.slot == NOTHING || y.slot == NOTHING)
        return (struct factor){ NOTHING, false };
    bool negative = x.negative != y.negative;
    if (x.slot == UNIT || y.slot == UNIT)
        return (struct factor){ x.slot == UNIT ? y.slot : x.slot, negative };
    return (struct factor){ emit(m, EXPR_MUL, x.slot, y.slot), negative };
}

static struct factor sum(struct maker *m, struct factor x, struct factor y)
{
    if (x.slot == NOTHING || y.slot == NOTHING)
        return x.slot == NOTHING ? y : x;
    x.slot = x.slot == UNIT ? ONE_SLOT : x.slot;
    y.slot = y.slot == UNIT ? ONE_SLOT : y.slot;
    if (x.negative == y.negative)
        return (struct factor){ emit(m, EXPR_ADD, x.slot, y.slot), x.negative };
    return (struct factor){ x.negative ? emit(m, EXPR_SUB, y.slot, x.slot) : emit(m, EXPR_SUB, x.slot, y.slot), false };
}

static struct factor plus(int slot) { return (struct factor){ slot, false }; }
static struct factor minus(int slot) { return (struct factor){ slot, true }; }

/* What jacobian_partials computes, as code. What is rare is left to that function. */
static void find_partials(struct maker *m, int step)
{
    const struct jacobian_step *s = m->p->step + step;
    const struct tape_code *c = m->p->tape->code + s->slot - m->p->tape->code_slot;
    int u = s->slot, x = s->op == TAPE_PAIRED ? c[-1].a : c->a, y = c->b;
    struct factor pa = plus(NOTHING), pb = plus(NOTHING);
    bool by_a = s->a != m->p->sink, by_b = s->b != m->p->sink;
    switch (s->op) {
    case EXPR_ADD: pa = pb = plus(UNIT); break;
    case EXPR_SUB: pa = plus(UNIT); pb = minus(UNIT); break;
    case EXPR_MUL: pa = plus(y); pb = plus(x); break;
    case EXPR_DIV:
        pa = by_a ? plus(emit(m, EXPR_DIV, ONE_SLOT, y)) : pa;
        pb = by_b ? minus(emit(m, EXPR_DIV, u, y)) : pb;
        break;
    case EXPR_NEG:    pa = minus(UNIT); break;
    case TAPE_SQUARE: pa = plus(emit(m, EXPR_MUL, constant(m, 2), x)); break;
    case TAPE_CUBE:   pa = plus(emit(m, EXPR_MUL, emit(m, EXPR_MUL, constant(m, 3), x), x)); break;
    case EXPR_POWI:   pa = plus(emit(m, EXPR_MUL, constant(m, c->b), emit(m, EXPR_POWI, x, c->b - 1))); break;
    case TAPE_SINCOS: pa = plus(u + 1); break;
    case TAPE_PAIRED: pa = minus(u - 1); break;
    case EXPR_SIN:    pa = plus(emit(m, EXPR_COS, x, 0)); break;
    case EXPR_COS:    pa = minus(emit(m, EXPR_SIN, x, 0)); break;
    case EXPR_EXP:    pa = plus(u); break;
    case EXPR_LOG:    pa = plus(emit(m, EXPR_DIV, ONE_SLOT, x)); break;
    case EXPR_SQRT:   pa = plus(emit(m, EXPR_DIV, constant(m, 0.5), u)); break;
    default:
        pa = by_a ? plus(emit(m, TAPE_SLOPE_A, u, 0)) : pa;
        pb = by_b ? plus(emit(m, TAPE_SLOPE_B, u, 0)) : pb;
        break;
    }
    m->pa[step] = pa;
    m->pb[step] = pb;
    m->known[step] = 1;
}

static void row_by_reverse(struct maker *m, int row, struct factor *value)
{
    const struct num_jacobian_plan *p = m->p;
    const struct jacobian_lists *l = &p->lists;
    int cols = m->j->cols, n = l->all[row] ? p->steps : l->start[row + 1] - l->start[row];
    m->sum[p->root[row]] = plus(UNIT);
    for (int i = n - 1; i >= 0; i--) {
        int k = l->all[row] ? i : l->item[l->start[row] + i];
        const struct jacobian_step *s = p->step + k;
        struct factor w = m->sum[cols + k];
        m->sum[cols + k].slot = NOTHING;
        if (w.slot == NOTHING)
            continue;
        if (!m->known[k])
            find_partials(m, k);
        if (s->a != p->sink)
            m->sum[s->a] = sum(m, m->sum[s->a], product(m, w, m->pa[k]));
        if (s->b != p->sink)
            m->sum[s->b] = sum(m, m->sum[s->b], product(m, w, m->pb[k]));
    }
    for (int i = m->j->start[row]; i < m->j->start[row + 1]; i++) {
        value[i] = m->sum[m->j->col[i]];
        m->sum[m->j->col[i]].slot = NOTHING;
    }
    m->sum[p->sink].slot = NOTHING;
}

static void column_by_forward(struct maker *m, int col, struct factor *value)
{
    const struct num_jacobian_plan *p = m->p;
    const struct jacobian_lists *l = &p->lists;
    int cols = m->j->cols, n = l->all[col] ? p->steps : l->start[col + 1] - l->start[col];
    m->sum[col] = plus(UNIT);
    for (int i = 0; i < n; i++) {
        int k = l->all[col] ? i : l->item[l->start[col] + i];
        const struct jacobian_step *s = p->step + k;
        struct factor x = m->sum[s->a], y = m->sum[s->b];
        if (x.slot == NOTHING && y.slot == NOTHING)
            continue;
        if (!m->known[k])
            find_partials(m, k);
        m->sum[cols + k] = sum(m, product(m, x, m->pa[k]), product(m, y, m->pb[k]));
    }
    for (int i = p->by_col[col]; i < p->by_col[col + 1]; i++)
        value[p->entry[i]] = m->sum[p->root[p->entry_row[i]]];
    for (int i = 0; i < n; i++)
        m->sum[cols + (l->all[col] ? i : l->item[l->start[col] + i])].slot = NOTHING;
    m->sum[col].slot = NOTHING;
}

/* Zeros end without sign, as after the sweeps. */
static int finish(struct maker *m, struct factor v)
{
    if (v.slot == NOTHING)
        return ZERO_SLOT;
    if (v.slot == UNIT)
        return v.negative ? constant(m, -1) : ONE_SLOT;
    return v.negative ? emit(m, EXPR_SUB, ZERO_SLOT, v.slot) : emit(m, EXPR_ADD, v.slot, ZERO_SLOT);
}

/* The constants get their place between the function's values that are fixed and its code. */
static int settle_slot(const struct maker *m, int slot, int fixed)
{
    return slot < 0 ? fixed - 1 - slot : slot < fixed ? slot : slot + m->constants;
}

static void settle(struct maker *m)
{
    struct num_tape *t = m->t;
    const struct num_tape *from = m->p->tape;
    int fixed = t->code_slot;
    for (int i = 0; i < t->ncode; i++) {
        t->code[i].a = settle_slot(m, t->code[i].a, fixed);
        if (tape_reads_two(t->code[i].op))
            t->code[i].b = settle_slot(m, t->code[i].b, fixed);
    }
    for (int r = 0; r < t->nroots; r++)
        t->root[r] = settle_slot(m, t->root[r], fixed);
    t->code_slot = fixed + m->constants;
    t->slots = t->code_slot + t->ncode;
    t->value = sga_calloc((size_t)t->slots + 1, sizeof *t->value);
    memcpy(t->value, from->value, (size_t)fixed * sizeof *t->value);
    if (m->constants)
        memcpy(t->value + fixed, m->constant, (size_t)m->constants * sizeof *t->value);
}

static void make(struct maker *m)
{
    const struct num_tape *from = m->p->tape;
    const struct num_jacobian *j = m->j;
    struct num_tape *t = m->t;
    SGA_FREED struct factor *value = sga_malloc(((size_t)j->nnz + 1) * sizeof *value);
    t->ninputs = from->ninputs;
    t->nroots = j->rows + j->nnz;
    t->first_roots = j->rows;
    t->root = sga_malloc(((size_t)t->nroots + 1) * sizeof *t->root);
    t->code_slot = from->code_slot + from->nstatic;
    t->ntables = from->ntables;
    t->table = sga_malloc(((size_t)t->ntables + 1) * sizeof *t->table);
    for (int k = 0; k < t->ntables; k++)
        t->table[k] = from->table[k];
    constant(m, 0);
    constant(m, 1);
    for (int i = from->nstatic; i < from->ncode; i++)
        emit(m, from->code[i].op, from->code[i].a, from->code[i].b);
    for (int i = 0; i < (m->p->forward ? j->cols : j->rows); i++) {
        if (m->p->forward)
            column_by_forward(m, i, value);
        else
            row_by_reverse(m, i, value);
    }
    memcpy(t->root, from->root, (size_t)j->rows * sizeof *t->root);
    for (int i = 0; i < j->nnz; i++)
        t->root[j->rows + i] = finish(m, value[i]);
    settle(m);
}

bool jacobian_may_be_code(const struct num_jacobian *j)
{
    const struct num_jacobian_plan *p = j->plan;
    const struct num_tape *t = p->tape;
    long steps = t->ncode + j->nnz;
    for (int i = t->nstatic; i < t->ncode; i++)
        if (t->code[i].op == TAPE_FACTOR)
            return false;
    for (int i = 0; i < (p->forward ? j->cols : j->rows); i++)
        steps += 2L * (p->lists.all[i] ? p->steps : p->lists.start[i + 1] - p->lists.start[i]);
    return steps <= MOST;
}

struct num_tape *jacobian_code(const struct num_jacobian *j)
{
    const struct num_jacobian_plan *p = j->plan;
    struct maker m = { .j = j, .p = p, .t = sga_calloc(1, sizeof *m.t) };
    m.pa = sga_malloc(((size_t)p->steps + 1) * sizeof *m.pa);
    m.pb = sga_malloc(((size_t)p->steps + 1) * sizeof *m.pb);
    m.known = sga_calloc((size_t)p->steps + 1, 1);
    m.sum = sga_malloc(((size_t)p->sink + 1) * sizeof *m.sum);
    for (int i = 0; i <= p->sink; i++)
        m.sum[i] = plus(NOTHING);
    make(&m);
    free(m.constant);
    free(m.pa);
    free(m.pb);
    free(m.known);
    free(m.sum);
    return m.t;
}
