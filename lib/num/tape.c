/* Compiling expressions to a tape.
 *
 * The nodes of the cones come children first, so one pass in their order emits the
 * code; three passes put what depends on no input in front, and next to it what depends on time alone. Sine and cosine of one
 * argument become one instruction, a matrix of linear solves is factored once for all of their
 * components and right sides. */
#include "tape_code.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "dd.h"
#include "error.h"
#include "mem.h"
#include "switches.h"
#include "value.h"

enum { STATIC, TIMED, LIVE };

struct builder {
    const struct expr_store *st;
    struct num_tape *t;
    struct expr_cone cone;
    int *slot;            /* by node: its slot; -1: none yet */
    unsigned char *live;  /* by node: depends on no input, on time alone, on others */
    int *solve;           /* by linear solve: its index in the tape; -1: none yet */
    int time;             /* the input that is time, or -1 */
    int zero;             /* the slot of the 0 that linear solves read where their matrix has none; -1: none yet */
    int *sine, *cosine;   /* by node: its sine and cosine among the cone, or 0 */
    const struct num_switches *switches;   /* NULL: none */
    struct sga_error *err;
    size_t code_cap, solve_cap, table_cap, held_cap;
};

static bool place_inputs(struct builder *b, const int *inputs)
{
    b->time = -1;
    for (int i = 0; i < b->t->ninputs; i++) {
        assert(b->slot[b->st->symbol[inputs[i]].node] < 0);
        b->slot[b->st->symbol[inputs[i]].node] = i;
        if (b->st->symbol[inputs[i]].kind == EXPR_TIME)
            b->time = i;
    }
    for (int i = 0; i < b->cone.count; i++) {
        expr_id e = b->cone.list[i];
        const struct expr_node *n = b->st->node + e;
        if (n->op == EXPR_UNDEF_OP)
            return sga_fail(b->err, SGA_E_EXPR_UNDEFINED, "an expression to be evaluated has no value");
        if (n->op == EXPR_SYM && b->slot[e] < 0 && !(b->st->symbol[n->a].table && b->time >= 0))
            return sga_fail(b->err, SGA_E_EXPR_NAME, "no value is given for %s", b->st->symbol[n->a].name);
    }
    return true;
}

/* Three constants for the switch of node e, once; which of t->held it is, or -1. */
static int switch_of(struct builder *b, expr_id e)
{
    struct num_tape *t = b->t;
    int k = b->switches ? num_switches_of(b->switches, e) : -1;
    if (k < 0)
        return -1;
    for (int i = 0; i < t->nheld; i++)
        if (t->held[i].of == k)
            return i;
    SGA_RESERVE(t->held, b->held_cap, t->nheld + 1);
    t->held[t->nheld] = (struct tape_switch){ k, t->code_slot, 0 };
    t->code_slot += 3;
    return t->nheld++;
}

/* Slots for the constants; what nodes depend on; which sines have a cosine. */
static void survey(struct builder *b)
{
    const struct expr_store *st = b->st;
    struct num_tape *t = b->t;
    t->code_slot = t->ninputs;
    for (int i = 0; i < b->cone.count; i++) {
        expr_id e = b->cone.list[i];
        const struct expr_node *n = st->node + e;
        if (n->op == EXPR_CONST || n->op == EXPR_PI)
            b->slot[e] = t->code_slot++;
        if (n->op == EXPR_SOLVE && b->zero < 0)
            b->zero = t->code_slot++;
        switch_of(b, e);
        b->live[e] = n->op != EXPR_SYM ? STATIC : b->time >= 0 && (b->slot[e] == b->time || b->slot[e] < 0) ? TIMED : LIVE;
        int children = expr_children(st, e);
        for (int k = 0; k < children; k++) {
            unsigned char of = b->live[expr_child(st, e, k)];
            b->live[e] = of > b->live[e] ? of : b->live[e];
        }
        if (n->op == EXPR_SIN)
            b->sine[n->a] = e;
        if (n->op == EXPR_COS)
            b->cosine[n->a] = e;
    }
}

static int emit(struct builder *b, int op, int x, int y)
{
    struct num_tape *t = b->t;
    SGA_RESERVE(t->code, b->code_cap, t->ncode + 1);
    t->code[t->ncode] = (struct tape_code){ .op = op, .a = x, .b = y };
    return t->code_slot + t->ncode++;
}

/* A solve before this one with the same matrix, or -1. What does not depend on inputs is factored first, once. */
static int same_matrix(const struct num_tape *t, const struct tape_solve *q)
{
    for (int i = 0; i < t->nsolves; i++)
        if (t->solve[i].m == q->m && t->solve[i].factored < 0
            && !memcmp(t->solve[i].matrix, q->matrix, (size_t)q->m * (size_t)q->m * sizeof *q->matrix))
            return i;
    return -1;
}

static int emit_solve(struct builder *b, int index)
{
    const struct expr_solve *s = b->st->solve + index;
    struct num_tape *t = b->t;
    size_t m = (size_t)s->m;
    SGA_RESERVE(t->solve, b->solve_cap, t->nsolves + 1);
    struct tape_solve *q = t->solve + t->nsolves;
    *q = (struct tape_solve){ .m = s->m };
    q->matrix = sga_malloc(m * m * sizeof *q->matrix);
    q->rhs = sga_malloc(m * sizeof *q->rhs);
    q->y = sga_calloc(m, sizeof *q->y);
    q->work = sga_calloc(m, sizeof *q->work);
    for (size_t i = 0; i < m * m; i++)
        q->matrix[i] = b->zero;
    for (size_t i = 0; i < m; i++) {
        for (int k = s->matrix.start[i]; k < s->matrix.start[i + 1]; k++)
            q->matrix[i * m + (size_t)s->matrix.column[k]] = b->slot[s->matrix.entry[k]];
        q->rhs[i] = b->slot[s->rhs[i]];
    }
    q->factored = same_matrix(t, q);
    q->perm = q->factored < 0 ? sga_malloc(m * sizeof *q->perm) : t->solve[q->factored].perm;
    q->lu = q->factored < 0 ? sga_calloc(m * m, sizeof *q->lu) : t->solve[q->factored].lu;
    q->slot = emit(b, TAPE_FACTOR, t->nsolves, 0);
    return t->nsolves++;
}

static int emit_power(struct builder *b, const struct expr_node *n)
{
    int a = b->slot[n->a];
    if (n->b == 2 || n->b == 3)
        return emit(b, n->b == 2 ? TAPE_SQUARE : TAPE_CUBE, a, 0);
    return emit(b, EXPR_POWI, a, n->b);
}

/* A symbol that is no input is a signal. */
static int emit_signal(struct builder *b, const struct expr_symbol *s)
{
    struct num_tape *t = b->t;
    int k = 0;
    while (k < t->ntables && t->table[k] != s->table)
        k++;
    if (k == t->ntables) {
        SGA_RESERVE(t->table, b->table_cap, k + 1);
        t->table[t->ntables++] = s->table;
    }
    return emit(b, TAPE_SIGNAL, b->time, k << 8 | s->order);
}

/* What can be held on a side s: with the constants p = B for s > 0, else 0, q = B for s < 0, else 0, and p - q, where B is
 * larger than every value, sign(g + p - q), g times that, min(a + p, b + q) and max(a - q, b - p). */
static int emit_switch(struct builder *b, expr_id e, struct tape_switch *w)
{
    const struct expr_node *n = b->st->node + e;
    bool swapped = b->switches->swapped[e];
    int a = b->slot[swapped ? n->b : n->a], slot = w->slot;
    if (n->op == EXPR_MIN)
        return emit(b, EXPR_MIN, emit(b, EXPR_ADD, a, slot), emit(b, EXPR_ADD, b->slot[swapped ? n->a : n->b], slot + 1));
    if (n->op == EXPR_MAX)
        return emit(b, EXPR_MAX, emit(b, EXPR_SUB, a, slot + 1), emit(b, EXPR_SUB, b->slot[swapped ? n->a : n->b], slot));
    if (!w->sign)
        w->sign = emit(b, EXPR_SIGN, emit(b, EXPR_ADD, a, slot + 2), 0);
    return n->op == EXPR_SIGN ? w->sign : emit(b, EXPR_MUL, a, w->sign);
}

static void emit_node(struct builder *b, expr_id e)
{
    const struct expr_node *n = b->st->node + e;
    int args = expr_op_args((enum expr_op)n->op), held = switch_of(b, e);
    if (held >= 0) {
        b->slot[e] = emit_switch(b, e, b->t->held + held);
    } else if (n->op == EXPR_SYM) {
        b->slot[e] = emit_signal(b, b->st->symbol + n->a);
    } else if ((n->op == EXPR_SIN || n->op == EXPR_COS) && b->sine[n->a] && b->cosine[n->a]) {
        b->slot[b->sine[n->a]] = emit(b, TAPE_SINCOS, b->slot[n->a], 0);
        b->slot[b->cosine[n->a]] = emit(b, TAPE_PAIRED, 0, 0);
    } else if (n->op == EXPR_SOLVE) {
        if (b->solve[n->a] < 0)
            b->solve[n->a] = emit_solve(b, n->a);
        b->slot[e] = emit(b, TAPE_COMPONENT, b->solve[n->a], n->b);
    } else if (n->op == EXPR_POWI) {
        b->slot[e] = emit_power(b, n);
    } else {
        b->slot[e] = emit(b, n->op, b->slot[n->a], args == 2 ? b->slot[n->b] : 0);
    }
}

static void emit_code(struct builder *b)
{
    struct num_tape *t = b->t;
    for (int live = STATIC; live <= LIVE; live++) {
        for (int i = 0; i < b->cone.count; i++) {
            expr_id e = b->cone.list[i];
            if (b->live[e] == live && b->slot[e] < 0)
                emit_node(b, e);
        }
        if (live == STATIC)
            t->nstatic = t->ncode;
        if (live <= TIMED)
            t->ntimed = t->ncode;
    }
    t->slots = t->code_slot + t->ncode;
}

/* What the nearest double leaves of a constant. */
static double low_part(const fmpq *q, double high)
{
    if (!isfinite(high) || (fmpz_is_one(fmpq_denref(q)) && fmpz_bits(fmpq_numref(q)) <= 53))
        return 0;
    num_dd v = num_dd_of_fmpq(q);
    return (v.hi - high) + v.lo;
}

static void fill(struct builder *b, const expr_id *roots)
{
    struct num_tape *t = b->t;
    t->value = sga_calloc((size_t)t->slots + 1, sizeof *t->value);
    tape_forget_time(t);
    t->low = sga_calloc((size_t)(t->code_slot - t->ninputs) + 1, sizeof *t->low);
    for (int i = 0; i < b->cone.count; i++) {
        expr_id e = b->cone.list[i];
        int slot = b->slot[e];
        if (expr_op_of(b->st, e) == EXPR_CONST) {
            t->value[slot] = expr_nearest_double(expr_const_value(b->st, e));
            t->low[slot - t->ninputs] = low_part(expr_const_value(b->st, e), t->value[slot]);
        }
        if (expr_op_of(b->st, e) == EXPR_PI) {
            t->value[slot] = num_dd_pi().hi;
            t->low[slot - t->ninputs] = num_dd_pi().lo;
        }
    }
    t->root = sga_malloc(((size_t)t->nroots + 1) * sizeof *t->root);
    for (int r = 0; r < t->nroots; r++)
        t->root[r] = b->slot[roots[r]];
    tape_run(t, 0, t->nstatic);
}

static void builder_init(struct builder *b)
{
    size_t n = (size_t)b->st->nodes;
    expr_cone_init(&b->cone);
    b->slot = sga_malloc(n * sizeof *b->slot);
    memset(b->slot, -1, n * sizeof *b->slot);
    b->live = sga_calloc(n, 1);
    b->sine = sga_calloc(n, sizeof *b->sine);
    b->cosine = sga_calloc(n, sizeof *b->cosine);
    b->solve = sga_malloc(((size_t)b->st->solves + 1) * sizeof *b->solve);
    memset(b->solve, -1, ((size_t)b->st->solves + 1) * sizeof *b->solve);
}

static void builder_clear(struct builder *b)
{
    expr_cone_clear(&b->cone);
    free(b->slot);
    free(b->live);
    free(b->sine);
    free(b->cosine);
    free(b->solve);
}

struct num_tape *num_tape_new(const struct expr_store *st, const expr_id *roots, int nroots,
                              const int *inputs, int ninputs, struct sga_error *err)
{
    return num_tape_new_switched(st, NULL, roots, nroots, inputs, ninputs, err);
}

void num_tape_hold(struct num_tape *t, const signed char *side)
{
    static const double beyond = 1e300;
    for (int i = 0; i < t->nheld; i++) {
        const struct tape_switch *w = t->held + i;
        double *c = t->value + w->slot;
        int s = side ? side[w->of] : 0;
        assert(s >= -1 && s <= 1);
        c[0] = s > 0 ? beyond : 0;
        c[1] = s < 0 ? beyond : 0;
        c[2] = c[0] - c[1];
    }
    tape_forget_time(t);
}

/* Single assignment: an instruction reads slots before its own, and roots are slots. Linear. */
static bool tape_sane(const struct num_tape *t)
{
    bool sane = t->slots == t->code_slot + t->ncode && t->nstatic <= t->ntimed && t->ntimed <= t->ncode && t->ninputs <= t->code_slot;
    for (int i = 0; i < t->ncode && sane; i++)
        if (t->code[i].op < EXPR_OP_COUNT)
            sane = t->code[i].a >= 0 && t->code[i].a < t->code_slot + i
                   && (!tape_reads_two(t->code[i].op) || (t->code[i].b >= 0 && t->code[i].b < t->code_slot + i));
    for (int r = 0; r < t->nroots && sane; r++)
        sane = t->root[r] >= 0 && t->root[r] < t->slots;
    return sane;
}

struct num_tape *num_tape_new_switched(const struct expr_store *st, const struct num_switches *w, const expr_id *roots, int nroots,
                                       const int *inputs, int ninputs, struct sga_error *err)
{
    struct num_tape *t = sga_calloc(1, sizeof *t);
    SGA_ENDS(builder_clear) struct builder b = { .st = st, .t = t, .zero = -1, .switches = w, .err = err };
    t->ninputs = ninputs;
    t->nroots = t->first_roots = nroots;
    builder_init(&b);
    if (nroots > 0)
        expr_cone_of(st, &b.cone, roots, nroots);
    bool ok = place_inputs(&b, inputs);
    if (ok) {
        survey(&b);
        emit_code(&b);
        fill(&b, roots);
    }
    if (!ok) {
        num_tape_free(t);
        return NULL;
    }
    assert(tape_sane(t));
    return t;
}

void num_tape_free(struct num_tape *t)
{
    if (!t)
        return;
    num_tape_compile(t, NULL);
    for (int i = 0; i < t->nsolves; i++) {
        struct tape_solve *s = t->solve + i;
        free(s->matrix);
        free(s->rhs);
        if (s->factored < 0) {
            free(s->perm);
            free(s->lu);
        }
        free(s->y);
        free(s->work);
    }
    free(t->solve);
    free(t->table);
    free(t->held);
    free(t->code);
    free(t->value);
    free(t->low);
    free(t->root);
    free(t);
}

int num_tape_inputs(const struct num_tape *t) { return t->ninputs; }
int num_tape_roots(const struct num_tape *t) { return t->nroots; }
int num_tape_length(const struct num_tape *t) { return t->ncode - t->nstatic; }
