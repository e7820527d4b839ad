/* From the expression store to straight-line code with derivative rules. */
#include "program.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "enc_tables.h"
#include "error.h"
#include "mem.h"
#include "op.h"

/* What is known while code is made. */
struct maker {
    struct enc_program *p;
    const struct expr_store *st;
    const struct expr_cone *cone;
    int *slot;               /* by position in the cone */
    int *pair; size_t pair_cap; int pairs;   /* by slot x: twice (sin, cos; sinh, cosh), slot of the first of a pair, or 0 */
    int *first; size_t first_cap;            /* by solve of the store: its first component, or 0 */
    int *piece;              /* by table: the slot of its piece's first number, or 0 */
    bool aux;                /* what is emitted now */
};

static int emit(struct maker *m, struct enc_code c)
{
    struct enc_program *p = m->p;
    SGA_RESERVE(p->code, p->cap, p->slots + 1);
    c.aux = m->aux;
    if (c.op != ENC_INPUT && c.op != ENC_INTEGER && c.op != ENC_CONSTANT && c.op != ENC_PIECE && c.op != ENC_SOLVE) {
        bool two = c.op != ENC_NEG && c.op != ENC_SQRT && !(c.op == ENC_FUN && c.fun != EXPR_POW)
                   && !(c.op == ENC_CHOICE && c.fun != EXPR_MIN && c.fun != EXPR_MAX);
        c.varies = p->code[c.a].varies || (two && p->code[c.b].varies);
        c.state = p->code[c.a].state || (two && p->code[c.b].state);
    }
    if (c.op == ENC_FUN || c.op == ENC_ATAN2)
        p->code[c.a].scaled = true;
    if (c.op == ENC_ATAN2)
        p->code[c.b].scaled = true;
    p->code[p->slots] = c;
    return p->slots++;
}

static int two(struct maker *m, enum enc_op op, int a, int b)
{
    return emit(m, (struct enc_code){ .op = op, .a = a, .b = b });
}

static int integer(struct maker *m, int v)
{
    return emit(m, (struct enc_code){ .op = ENC_INTEGER, .a = v });
}

/* sin and cos (which = 0) or sinh and cosh (1) of x, side by side: the slot of the first. */
static int pair(struct maker *m, int x, int which, bool second)
{
    SGA_RESERVE(m->pair, m->pair_cap, 2 * (x + 1));
    for (; m->pairs < 2 * (x + 1); m->pairs++)
        m->pair[m->pairs] = 0;
    int *known = m->pair + 2 * x + which, s = *known;
    if (!s) {
        bool aux = m->aux;
        m->aux = true;
        s = emit(m, (struct enc_code){ .op = ENC_FUN, .fun = which ? EXPR_SINH : EXPR_SIN, .a = x, .sign = 1 });
        emit(m, (struct enc_code){ .op = ENC_FUN, .fun = which ? EXPR_COSH : EXPR_COS, .a = x, .g = s, .sign = which ? 1 : -1 });
        m->p->code[s].g = s + 1;
        m->pair[2 * x + which] = s;
        m->aux = aux;
    }
    s += second;
    m->p->code[s].aux &= m->aux;
    return s;
}

static int power(struct maker *m, int x, long n)
{
    unsigned long k = n < 0 ? -(unsigned long)n : (unsigned long)n;
    int r = -1;
    for (int square = x; k; k >>= 1) {
        if (k & 1)
            r = r < 0 ? square : two(m, ENC_MUL, r, square);
        if (k > 1)
            square = two(m, ENC_MUL, square, square);
    }
    return n < 0 ? two(m, ENC_DIV, integer(m, 1), r) : r;
}

/* The slot of f'(x) but for its sign, u = f(x). */
static int slope(struct maker *m, enum expr_op f, int x, int u)
{
    const struct expr_slope *s = expr_op_slope(f);
    if (f == EXPR_CBRT)          /* of u = 0 too where x is not */
        return two(m, ENC_DIV, u, two(m, ENC_MUL, integer(m, s->factor), x));
    if (f == EXPR_POW)
        return two(m, ENC_DIV, two(m, ENC_MUL, m->p->code[u].b, u), x);
    assert((s->of == EXPR_OF_ARGUMENT || s->of == EXPR_OF_VALUE) && labs(s->factor) == 1);
    int r = s->of == EXPR_OF_VALUE ? u : x, one = s->shift || s->halves < 0 ? integer(m, 1) : -1;
    r = s->power == 1 ? r : two(m, ENC_MUL, r, r);
    if (s->shift)
        r = s->shift < 0 ? two(m, ENC_SUB, r, one) : two(m, s->factor < 0 ? ENC_SUB : ENC_ADD, one, r);
    r = s->halves == -1 ? emit(m, (struct enc_code){ .op = ENC_SQRT, .a = r }) : r;
    return s->halves < 0 ? two(m, ENC_DIV, one, r) : r;
}

static int function(struct maker *m, enum expr_op f, int x, int exponent)
{
    int u = emit(m, (struct enc_code){ .op = ENC_FUN, .fun = f, .a = x, .b = exponent, .sign = expr_op_slope(f)->sign < 0 ? -1 : 1 });
    bool aux = m->aux;
    m->aux = true;
    int g = slope(m, f, x, u);
    m->p->code[u].g = g;
    m->aux = aux;
    return u;
}

static int real_power(struct maker *m, int x, int y)
{
    if (!m->p->code[y].varies)
        return function(m, EXPR_POW, x, y);
    return function(m, EXPR_EXP, two(m, ENC_MUL, y, function(m, EXPR_LOG, x, 0)), 0);
}

static int arc_tangent(struct maker *m, int y, int x)
{
    int u = emit(m, (struct enc_code){ .op = ENC_ATAN2, .a = y, .b = x });
    bool aux = m->aux;
    m->aux = true;
    int r = two(m, ENC_ADD, two(m, ENC_MUL, x, x), two(m, ENC_MUL, y, y));
    int g = two(m, ENC_DIV, x, r), g2 = two(m, ENC_DIV, y, r);
    m->p->code[u].g = g;
    m->p->code[u].g2 = g2;
    m->aux = aux;
    return u;
}

static int slot_of(struct maker *m, expr_id e)
{
    return m->slot[m->cone->place[e]];
}

/* The slot of e, which is put into a system: what varies with e then varies with the system. */
static int read(struct maker *m, expr_id e, bool *varies, bool *state)
{
    int k = slot_of(m, e);
    *varies |= m->p->code[k].varies;
    *state |= m->p->code[k].state;
    return k;
}

static int component(struct maker *m, int solve, int which)
{
    struct enc_program *p = m->p;
    if (!m->first[solve]) {
        const struct expr_solve *s = m->st->solve + solve;
        size_t mm = (size_t)s->m * (size_t)s->m;
        int zero = integer(m, 0);
        SGA_RESERVE(p->system, p->system_cap, p->systems + 1);
        struct enc_system *q = p->system + p->systems;
        *q = (struct enc_system){ s->m, sga_malloc((mm + 1) * sizeof(int)), sga_malloc((size_t)(s->m + 1) * sizeof(int)), p->slots };
        bool varies = false, state = false;
        for (size_t i = 0; i < mm; i++)
            q->matrix[i] = zero;
        for (int i = 0; i < s->m; i++) {
            for (int k = s->matrix.start[i]; k < s->matrix.start[i + 1]; k++)
                q->matrix[i * s->m + s->matrix.column[k]] = read(m, s->matrix.entry[k], &varies, &state);
            q->rhs[i] = read(m, s->rhs[i], &varies, &state);
        }
        for (int k = 0; k < s->m; k++)
            emit(m, (struct enc_code){ .op = ENC_SOLVE, .a = p->systems, .b = k, .varies = varies, .state = state });
        m->first[solve] = q->first;
        p->systems++;
    }
    return m->first[solve] + which;
}

/* Coefficient i of a table's piece, of the derivative of this order: times i (i - 1) ... */
static int coefficient(struct maker *m, int piece, int i, int order)
{
    int factor = 1;
    for (int k = 0; k < order; k++)
        factor *= i - k;
    return factor == 1 ? piece + 1 + i : two(m, ENC_MUL, integer(m, factor), piece + 1 + i);
}

/* A derivative of table k of the program: the polynomial of its piece in the time since that began. */
static int table_value(struct maker *m, int k, int order)
{
    int degree = m->p->tables->table[k]->kind == EXPR_LINEAR ? 1 : EXPR_TABLE_DEGREE;
    if (!m->piece[k]) {
        m->piece[k] = m->p->slots;
        for (int i = 0; i < NUM_TABLE_PIECE; i++)
            emit(m, (struct enc_code){ .op = ENC_PIECE, .a = k * NUM_TABLE_PIECE + i });
        two(m, ENC_SUB, m->p->n, m->piece[k]);
    }
    if (order > degree)
        return integer(m, 0);
    int piece = m->piece[k], since = piece + NUM_TABLE_PIECE, v = coefficient(m, piece, degree, order);
    for (int i = degree - 1; i >= order; i--)
        v = two(m, ENC_ADD, two(m, ENC_MUL, v, since), coefficient(m, piece, i, order));
    return v;
}

static int compile(struct maker *m, expr_id e)
{
    const struct expr_node *n = m->st->node + e;
    enum expr_op op = (enum expr_op)n->op;
    if (op == EXPR_CONST || op == EXPR_PI)
        return emit(m, (struct enc_code){ .op = ENC_CONSTANT, .a = op == EXPR_PI ? -1 : n->a });
    if (op == EXPR_SOLVE)
        return component(m, n->a, n->b);
    int x = slot_of(m, n->a), y = expr_op_args(op) == 2 ? slot_of(m, n->b) : 0;
    switch (op) {
    case EXPR_ADD:  return two(m, ENC_ADD, x, y);
    case EXPR_SUB:  return two(m, ENC_SUB, x, y);
    case EXPR_MUL:  return two(m, ENC_MUL, x, y);
    case EXPR_DIV:  return two(m, ENC_DIV, x, y);
    case EXPR_NEG:  return emit(m, (struct enc_code){ .op = ENC_NEG, .a = x });
    case EXPR_SQRT: return emit(m, (struct enc_code){ .op = ENC_SQRT, .a = x });
    case EXPR_POWI: return power(m, x, n->b);
    case EXPR_POW:  return real_power(m, x, y);
    case EXPR_SIN: case EXPR_COS:   return pair(m, x, 0, op == EXPR_COS);
    case EXPR_SINH: case EXPR_COSH: return pair(m, x, 1, op == EXPR_COSH);
    case EXPR_ATAN2: return arc_tangent(m, x, y);
    case EXPR_ABS: case EXPR_SIGN: case EXPR_MIN: case EXPR_MAX:
        return emit(m, (struct enc_code){ .op = ENC_CHOICE, .fun = op, .a = x, .b = y });
    default:        return function(m, op, x, 0);
    }
}

/* A symbol that is no input; -1 with an error where it is no table. */
static int given(struct maker *m, const struct expr_symbol *s, struct sga_error *err)
{
    int k = s->table ? enc_tables_find(m->p->tables, s->table) : -1;
    if (k < 0)
        sga_fail(err, SGA_E_EXPR_NAME, "the motion depends on \"%.100s\", which has no value", s->name);
    return k < 0 ? -1 : table_value(m, k, s->order);
}

static bool make(struct maker *m, const struct enc_of *of, struct sga_error *err)
{
    const struct expr_store *st = m->st;
    SGA_FREED int *input = sga_malloc((size_t)(st->symbols + 1) * sizeof *input);
    for (int k = 0; k < st->symbols; k++)
        input[k] = -1;
    for (int j = 0; j < m->p->n; j++)
        input[of->variable[j]] = j;
    if (of->time >= 0)
        input[of->time] = m->p->n;
    bool ok = true;
    for (int i = 0; i < m->cone->count && ok; i++) {
        const struct expr_node *n = st->node + m->cone->list[i];
        if (n->op == EXPR_UNDEF_OP)
            ok = sga_fail(err, SGA_E_EXPR_UNDEFINED, "an expression of the motion has no value");
        else if (n->op == EXPR_SYM)
            ok = (m->slot[i] = input[n->a] >= 0 ? input[n->a] : given(m, st->symbol + n->a, err)) >= 0;
        else
            m->slot[i] = compile(m, m->cone->list[i]);
    }
    return ok;
}

bool enc_program_init(struct enc_program *p, const struct enc_of *of, const expr_id *roots, int count, struct sga_error *err)
{
    const struct expr_store *st = of->st;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, roots, count);
    expr_cone_index(&cone);
    *p = (struct enc_program){ .st = st, .tables = of->tables, .n = of->n, .roots = count, .root = sga_malloc((size_t)(count + 1) * sizeof(int)) };
    SGA_FREED int *slot = sga_malloc((size_t)(cone.count + 1) * sizeof(int)), *first = sga_calloc((size_t)st->solves + 1, sizeof(int));
    SGA_FREED int *piece = sga_calloc((size_t)(of->tables ? of->tables->count : 0) + 1, sizeof(int));
    struct maker m = { .p = p, .st = st, .cone = &cone, .slot = slot, .first = first, .piece = piece };
    for (int j = 0; j <= of->n; j++)
        emit(&m, (struct enc_code){ .op = ENC_INPUT, .a = j, .varies = true, .state = j < of->n });
    bool ok = make(&m, of, err);
    for (int i = 0; i < count && ok; i++)
        p->root[i] = slot_of(&m, roots[i]);
    free(m.pair);
    return ok;
}

void enc_program_clear(struct enc_program *p)
{
    for (int k = 0; k < p->systems; k++) {
        free(p->system[k].matrix);
        free(p->system[k].rhs);
    }
    free(p->system);
    free(p->code);
    free(p->root);
    *p = (struct enc_program){ 0 };
}
