/* Which systems are affine with rational coefficients, and their rows. */
#include "affine.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "derive.h"
#include "facts.h"
#include "flint_ends.h"
#include "mem.h"
#include "signal.h"
#include "system.h"

/* A coefficient on its way into a row. */
struct term {
    int col;
    fmpq value;
};

struct terms {
    struct term *term; int count; size_t cap;
};

static void add_term(struct terms *t, int col, const fmpq_t value)
{
    if (fmpq_is_zero(value))
        return;
    SGA_RESERVE(t->term, t->cap, t->count + 1);
    t->term[t->count].col = col;
    fmpq_init(&t->term[t->count].value);
    fmpq_set(&t->term[t->count++].value, value);
}

static int by_column(const void *x, const void *y)
{
    int a = ((const struct term *)x)->col, b = ((const struct term *)y)->col;
    return (a > b) - (a < b);
}

/* The terms as integers over one denominator; equal columns add up. The terms end. */
static void to_row(struct terms *t, struct exact_row *out, fmpz_t den)
{
    SGA_ENDS(fmpz_end) fmpz_t v = { 0 }, sum = { 0 };
    fmpz_one(den);
    if (t->count)
        qsort(t->term, (size_t)t->count, sizeof *t->term, by_column);
    for (int k = 0; k < t->count; k++)
        fmpz_lcm(den, den, fmpq_denref(&t->term[k].value));
    for (int k = 0; k < t->count; k++) {
        fmpz_divexact(v, den, fmpq_denref(&t->term[k].value));
        fmpz_addmul(sum, v, fmpq_numref(&t->term[k].value));
        if (k + 1 < t->count && t->term[k + 1].col == t->term[k].col)
            continue;
        exact_row_push(out, t->term[k].col, sum);
        fmpz_zero(sum);
    }
    for (int k = 0; k < t->count; k++)
        fmpq_clear(&t->term[k].value);
    free(t->term);
}

static int atom_index(struct affine *a, expr_id e)
{
    size_t before = a->atom_of_cap;
    SGA_RESERVE(a->atom_of, a->atom_of_cap, e + 1);
    if (a->atom_of_cap > before)
        memset(a->atom_of + before, 0, (a->atom_of_cap - before) * sizeof *a->atom_of);
    if (!a->atom_of[e]) {
        SGA_RESERVE(a->atom, a->atom_cap, a->atoms + 1);
        a->atom[a->atoms] = (struct affine_atom){ .expr = e };
        fmpz_init_set_ui(&a->atom[a->atoms].rate.den, 1);
        a->atom_of[e] = ++a->atoms;
    }
    return a->atom_of[e] - 1;
}

struct walk {
    struct affine *a;
    fmpq *weight;              /* by place in the cone: the coefficient of the node in the whole */
    struct terms terms;
};

static void pass(struct walk *w, expr_id child, const fmpq_t value, bool minus)
{
    fmpq *to = w->weight + w->a->cone.place[child];
    if (minus)
        fmpq_sub(to, to, value);
    else
        fmpq_add(to, to, value);
}

/* One node hands its weight on. False: the function is not affine. */
static bool hand_on(struct walk *w, expr_id e)
{
    struct affine *a = w->a;
    const struct expr_node n = a->st->node[e];
    fmpq *v = w->weight + a->cone.place[e];
    bool variable = expr_facts_of(a->facts, a->st, e) & EXPR_HAS_VARIABLE;
    switch ((enum expr_op)n.op) {
    case EXPR_UNDEF_OP: return false;
    case EXPR_CONST:
        fmpq_mul(v, v, expr_const_value(a->st, e));
        add_term(&w->terms, a->n, v);
        return true;
    case EXPR_SYM:
        add_term(&w->terms, a->column[n.a] >= 0 ? a->column[n.a] : a->n + atom_index(a, e), v);
        return true;
    case EXPR_ADD: case EXPR_SUB:
        pass(w, n.a, v, false);
        pass(w, n.b, v, n.op == EXPR_SUB);
        return true;
    case EXPR_NEG:
        pass(w, n.a, v, true);
        return true;
    case EXPR_MUL: {
        expr_id k = expr_is_const(a->st, n.a) ? n.a : n.b;
        if (!expr_is_const(a->st, k))
            break;
        fmpq_mul(v, v, expr_const_value(a->st, k));
        pass(w, k == n.a ? n.b : n.a, v, false);
        return true;
    }
    case EXPR_DIV:
        if (!expr_is_const(a->st, n.b) || expr_is_zero(a->st, n.b))
            break;
        fmpq_div(v, v, expr_const_value(a->st, n.b));
        pass(w, n.a, v, false);
        return true;
    default: break;
    }
    if (variable)
        return false;
    add_term(&w->terms, a->n + atom_index(a, e), v);
    return true;
}

/* Nodes from the root down, below atoms not at all: their weights are 0 and they have no variables. */
bool affine_function(struct affine *a, expr_id e, struct exact_row *out, fmpz_t den)
{
    struct walk w = { .a = a };
    bool ok = e != EXPR_UNDEF;
    if (!ok)
        return false;
    expr_cone_of(a->st, &a->cone, &e, 1);
    expr_cone_index(&a->cone);
    int count = a->cone.count;
    w.weight = sga_malloc((size_t)count * sizeof *w.weight);
    for (int k = 0; k < count; k++)
        fmpq_init(w.weight + k);
    fmpq_one(w.weight + a->cone.place[e]);
    for (int k = count - 1; k >= 0 && ok; k--) {
        expr_id x = a->cone.list[k];
        if (!fmpq_is_zero(w.weight + k) || expr_facts_of(a->facts, a->st, x) & EXPR_HAS_VARIABLE)
            ok = hand_on(&w, x);
    }
    for (int k = 0; k < count; k++)
        fmpq_clear(w.weight + k);
    free(w.weight);
    to_row(&w.terms, out, den);
    assert(!ok || fmpz_sgn(den) > 0);
    return ok;
}

/* Both sides of a row, over their denominators la and lb, to integers without a common factor. */
static void to_integers(struct affine_row *to, fmpz_t la, fmpz_t lb)
{
    SGA_ENDS(fmpz_end) fmpz_t m = { 0 };
    fmpz_lcm(m, la, lb);
    fmpz_divexact(la, m, la);
    fmpz_divexact(lb, m, lb);
    for (int k = 0; k < to->a.entries; k++)
        fmpz_mul(to->a.value + k, to->a.value + k, la);
    for (int k = 0; k < to->b.entries; k++)
        fmpz_mul(to->b.value + k, to->b.value + k, lb);
    fmpz_zero(la);
    exact_row_content(la, &to->a);
    exact_row_content(la, &to->b);
    if (fmpz_is_zero(la))
        fmpz_one(la);
    exact_row_divide(&to->a, la);
    exact_row_divide(&to->b, la);
    fmpq_set_fmpz_frac(&to->scale, m, la);
}

/* False where the right side is not affine, or has no value. */
static bool read_row(struct affine *a, int i)
{
    const struct sys_row *r = a->sys->row + i;
    struct affine_row *to = a->row + i;
    struct terms left = { 0 };
    SGA_ENDS(fmpz_end) fmpz_t la = { 0 }, lb = { 0 };
    for (int k = 0; k < r->entries; k++)
        add_term(&left, r->entry[k].col, expr_const_value(a->st, r->entry[k].value));
    to_row(&left, &to->a, la);
    bool ok = affine_function(a, r->alpha, &to->b, lb);
    if (ok)
        to_integers(to, la, lb);
    return ok;
}

static bool read_restriction(struct affine *a, int i)
{
    SGA_ENDS(fmpz_end) fmpz_t g = { 0 };
    bool ok = affine_function(a, a->sys->restriction[i], a->restriction + i, g);
    fmpz_zero(g);
    exact_row_content(g, a->restriction + i);
    if (!fmpz_is_zero(g))
        exact_row_divide(a->restriction + i, g);
    return ok;
}

static bool numbers_only(const struct sys_system *sys)
{
    for (int i = 0; i < sys->rows; i++)
        for (int k = 0; k < sys->row[i].entries; k++)
            if (!sys->row[i].entry[k].value || !expr_is_const(sys->store, sys->row[i].entry[k].value))
                return false;
    return true;
}

bool affine_read(struct affine *a, struct state *s)
{
    const struct sys_system *sys = s->sys;
    *a = (struct affine){ .sys = sys, .st = s->st, .n = sys->variables, .column = s->column, .facts = s->facts, .flow = s->flow };
    if (!numbers_only(sys))
        return false;
    expr_cone_init(&a->cone);
    a->row = sga_calloc((size_t)sys->rows + 1, sizeof *a->row);
    a->restriction = sga_calloc((size_t)sys->restrictions + 1, sizeof *a->restriction);
    atom_index(a, expr_int(a->st, 1));
    assert(a->atoms == 1);
    for (int i = 0; i < sys->rows; i++)
        fmpq_init(&a->row[i].scale);
    bool ok = true;
    for (int i = 0; i < sys->restrictions && ok; i++)
        ok = read_restriction(a, i);
    for (int i = 0; i < sys->rows && ok; i++)
        ok = read_row(a, i) && (i % 64 || sga_budget_ok(s->options->budget, NULL));
    if (!ok)
        affine_clear(a);
    return ok;
}

void affine_clear(struct affine *a)
{
    for (int i = 0; i < a->sys->rows && a->row; i++) {
        exact_row_clear(&a->row[i].a);
        exact_row_clear(&a->row[i].b);
        fmpq_clear(&a->row[i].scale);
    }
    for (int i = 0; i < a->sys->restrictions && a->restriction; i++)
        exact_row_clear(a->restriction + i);
    for (int k = 0; k < a->atoms; k++) {
        exact_row_clear(&a->atom[k].rate.row);
        fmpz_clear(&a->atom[k].rate.den);
    }
    free(a->row);
    free(a->restriction);
    free(a->atom);
    free(a->atom_of);
    expr_cone_clear(&a->cone);
    a->row = NULL;
    a->restriction = NULL;
    a->atom = NULL;
    a->atom_of = NULL;
    a->atoms = 0;
}

/* Derivatives of products grow where they are taken one after the other: past this many nodes the
 * higher ones are Taylor coefficients of the first. */
enum { PLAIN_NODES = 60 };

static void higher(struct affine *a, int k)
{
    expr_id base = a->atom[k].order ? a->atom[k].base : a->atom[k].expr;
    int order = a->atom[k].order + 1;
    SGA_ENDS(fmpq_end) fmpq_t f = { { 0, 1 } };
    SGA_ENDS(fmpz_end) fmpz_t one;
    fmpz_init_set_ui(one, 1);
    fmpz_fac_ui(fmpq_numref(f), (ulong)order);
    expr_id e = expr_mul(a->st, expr_fmpq(a->st, f), expr_flow_coefficient(a->flow, base, order));
    if (e && !expr_is_zero(a->st, e)) {
        int m = atom_index(a, e);
        if (!a->atom[m].order && m) {
            a->atom[m].base = base;
            a->atom[m].order = order;
        }
        exact_row_push(&a->atom[k].rate.row, m, one);
    }
}

static void find_rate(struct affine *a, int k)
{
    struct exact_row r = { 0 };
    a->atom[k].rate.known = true;
    if (!a->atom[k].order) {
        expr_id d = expr_time_partial(a->st, a->atom[k].expr, a->sys->time);
        if (!d)
            return;            /* the store is full, which the caller asks for in the end */
        expr_cone_of(a->st, &a->cone, &d, 1);
        if (a->cone.count <= PLAIN_NODES) {
            SGA_ENDS(fmpz_end) fmpz_t den = { 0 };
            affine_function(a, d, &r, den);
            fmpz_set(&a->atom[k].rate.den, den);
            for (int q = 0; q < r.entries; q++)
                exact_row_push(&a->atom[k].rate.row, r.col[q] - a->n, r.value + q);
            exact_row_clear(&r);
            return;
        }
    }
    higher(a, k);
}

void affine_rate(struct affine *a, const struct exact_row *r, struct exact_row *out, fmpz_t den)
{
    struct terms t = { 0 };
    SGA_ENDS(fmpq_end) fmpq_t v = { { 0, 1 } };
    for (int q = exact_row_before(r, a->n); q < r->entries; q++) {
        int k = r->col[q] - a->n;
        if (!a->atom[k].rate.known)
            find_rate(a, k);
        const struct affine_rate *d = &a->atom[k].rate;
        for (int m = 0; m < d->row.entries; m++) {
            fmpz_mul(fmpq_numref(v), d->row.value + m, r->value + q);
            fmpz_set(fmpq_denref(v), &d->den);
            fmpq_canonicalise(v);
            add_term(&t, a->n + d->row.col[m], v);
        }
    }
    to_row(&t, out, den);
}

expr_id affine_expression_from(struct affine *a, const struct exact_row *r, int from, const fmpz_t den)
{
    struct expr_store *st = a->st;
    expr_id e = expr_int(st, 0);
    SGA_ENDS(fmpq_end) fmpq_t v = { { 0, 1 } };
    int first = exact_row_before(r, from), constant = -1;
    for (int k = first; k <= r->entries; k++) {
        int q = k < r->entries ? k : constant;      /* the number comes last */
        if (k < r->entries && r->col[k] == a->n)
            constant = k;
        if (q < 0 || (k < r->entries && r->col[k] == a->n))
            continue;
        bool minus = fmpz_sgn(r->value + q) != fmpz_sgn(den);
        fmpz_abs(fmpq_numref(v), r->value + q);
        fmpz_abs(fmpq_denref(v), den);
        fmpq_canonicalise(v);
        expr_id x = r->col[q] < a->n ? st->symbol[a->sys->variable[r->col[q]].symbol].node : a->atom[r->col[q] - a->n].expr;
        expr_id t = expr_mul(st, expr_fmpq(st, v), x);
        e = expr_is_zero(st, e) ? minus ? expr_neg(st, t) : t : minus ? expr_sub(st, e, t) : expr_add(st, e, t);
    }
    return e;
}

expr_id affine_expression(struct affine *a, const struct exact_row *r)
{
    SGA_ENDS(fmpz_end) fmpz_t one;
    fmpz_init_set_ui(one, 1);
    return affine_expression_from(a, r, 0, one);
}
