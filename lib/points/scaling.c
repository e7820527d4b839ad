/* Sizes of variables from the terms of the equations. */
#include "scaling.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "scaling_rows.h"

enum { DEPTH = 200, EACH = 60, EQUATIONS = SGA_MOST_SCALED_TERMS, LEAST = 3, MOST = 900, VISITS = 200000 };

/* A product: coefficient and powers of the unknowns that it has. */
struct term {
    double log;                /* log2 of the coefficient */
    int *unknown; double *power; int count, cap;
};

struct scaling {
    const struct expr_store *st;
    int n, *index;             /* unknowns: variables, and time where `timed`; by symbol: unknown, or -1 */
    bool timed, time_met;
    int *level, levels;        /* by node: the unknown that is the size of a sum, 0: none yet; how many there are, those of rows too */
    int nodes;
    struct scaling_rows rows;  /* sum power_j s_j = -log, one for each term of a sum: as large as the sum's level */
    struct term first, now, apart;
    int own;                   /* the level of the row that was begun, or 0; first is its only term so far */
    bool has_first, cut;
    bool even;                 /* see scaling_even; otherwise sums have the size of their first term */
    int visits;                /* shared sums are walked over each time: not without end */
    struct later { expr_id e; bool unit; } later[DEPTH]; int laters;   /* inner sums, and arguments */
};

struct scaling *scaling_new(const struct expr_store *st, const int *variable, int variables)
{
    if (variables > SCALING_MOST)
        return NULL;
    struct scaling *w = sga_calloc(1, sizeof *w);
    w->st = st;
    w->n = variables;
    w->index = sga_malloc((size_t)(st->symbols + 1) * sizeof *w->index);
    for (int i = 0; i < st->symbols; i++)
        w->index[i] = -1;
    for (int j = 0; j < variables; j++)
        w->index[variable[j]] = j;
    w->nodes = st->nodes;
    w->level = sga_calloc((size_t)w->nodes + 1, sizeof *w->level);
    scaling_rows_init(&w->rows, variables + 1);
    return w;
}

/* Levels come after variables and time. */
static int new_level(struct scaling *w)
{
    return w->n + w->levels++;
}


void scaling_time(struct scaling *w, int symbol)
{
    assert(!w->timed && w->index[symbol] < 0);
    w->timed = true;
    w->index[symbol] = w->n++;
}

static void term_free(struct term *t)
{
    free(t->unknown);
    free(t->power);
}

void scaling_free(struct scaling *w)
{
    if (!w)
        return;
    scaling_rows_clear(&w->rows);
    term_free(&w->first);
    term_free(&w->now);
    term_free(&w->apart);
    free(w->index);
    free(w->level);
    free(w);
}

bool scaling_has_time(const struct scaling *w)
{
    return w->time_met;
}

void scaling_sum(struct scaling *w)
{
    w->has_first = false;
    w->own = 0;
}

static void postpone(struct scaling *w, expr_id e, bool unit)
{
    w->cut |= w->laters == DEPTH;
    if (w->laters < DEPTH)
        w->later[w->laters++] = (struct later){ e, unit };
}

/* log2 |q| */
static double log_of(const fmpq *q)
{
    double m;
    slong e;
    if (fmpq_is_zero(q))
        return 0;
    m = fmpz_get_d_2exp(&e, fmpq_numref(q));
    double log = log2(fabs(m)) + (double)e;
    m = fmpz_get_d_2exp(&e, fmpq_denref(q));
    return log - log2(fabs(m)) - (double)e;
}

static void add_power(struct term *t, int unknown, double p)
{
    int k = 0;
    while (k < t->count && t->unknown[k] != unknown)
        k++;
    if (k == t->count) {
        if (t->count == t->cap) {
            t->cap = 2 * t->cap + 8;
            t->unknown = sga_realloc(t->unknown, (size_t)t->cap * sizeof *t->unknown);
            t->power = sga_realloc(t->power, (size_t)t->cap * sizeof *t->power);
        }
        t->unknown[t->count] = unknown;
        t->power[t->count++] = 0;
    }
    t->power[k] += p;
}

static void copy(struct term *to, const struct term *from)
{
    to->log = from->log;
    to->count = 0;
    for (int k = 0; k < from->count; k++)
        add_power(to, from->unknown[k], from->power[k]);
}

/* Its level, an unknown; its terms follow later. 0: as an unknown it comes too late. */
static int level_of(struct scaling *w, expr_id e)
{
    if (!w->even || (int)e >= w->nodes)
        return 0;
    if (!w->level[e]) {
        w->level[e] = new_level(w);
        postpone(w, e, false);
    }
    return w->level[e];
}

/* The size of a product; an inner sum has its level. */
static bool term_of(struct scaling *w, expr_id e, struct term *t)
{
    struct { expr_id e; double p; } stack[DEPTH];
    int depth = 0;
    stack[depth].e = e;
    stack[depth++].p = 1;
    while (depth) {
        expr_id at = stack[--depth].e;
        double p = stack[depth].p;
        const struct expr_node n = w->st->node[at];
        if (depth + 2 > DEPTH)
            return false;
        switch ((enum expr_op)n.op) {
        case EXPR_CONST:
            if (expr_is_zero(w->st, at))
                return false;
            t->log += p * log_of(w->st->constant + n.a);
            break;
        case EXPR_SYM:
            w->time_met |= w->timed && w->index[n.a] == w->n - 1;
            if (w->index[n.a] >= 0)
                add_power(t, w->index[n.a], p);
            break;
        case EXPR_MUL: case EXPR_DIV:
            stack[depth].e = n.a;
            stack[depth++].p = p;
            stack[depth].e = n.b;
            stack[depth++].p = n.op == EXPR_MUL ? p : -p;
            break;
        case EXPR_NEG: case EXPR_ABS:
        case EXPR_SQRT: case EXPR_CBRT: case EXPR_POWI:
            stack[depth].e = n.a;
            stack[depth++].p = n.op == EXPR_SQRT ? p / 2 : n.op == EXPR_CBRT ? p / 3 : n.op == EXPR_POWI ? p * n.b : p;
            break;
        case EXPR_ADD: case EXPR_SUB: case EXPR_MIN: case EXPR_MAX: {
            int level = level_of(w, at);
            if (level) {
                add_power(t, level, p);
                break;
            }
            if (n.op == EXPR_ADD || n.op == EXPR_SUB)
                postpone(w, at, false);
            stack[depth].e = expr_is_zero(w->st, n.a) ? n.b : n.a;
            stack[depth++].p = p;
            break;
        }
        default:
            for (int k = 0; k < expr_children(w->st, at) && n.op != EXPR_SOLVE; k++)
                postpone(w, expr_child(w->st, at, k), true);
        }
    }
    return true;
}

/* The terms of a sum, one after the other. */
struct walk {
    expr_id stack[DEPTH];
    int depth;
};

static bool next_term(struct scaling *w, struct walk *at, struct term *t)
{
    w->cut |= at->depth && w->visits >= VISITS + EACH * w->n;
    while (at->depth && w->visits++ < VISITS + EACH * w->n) {
        expr_id e = at->stack[--at->depth];
        const struct expr_node n = w->st->node[e];
        bool sum = n.op == EXPR_ADD || n.op == EXPR_SUB || (w->even && (n.op == EXPR_MIN || n.op == EXPR_MAX));
        if (sum && at->depth + 2 <= DEPTH) {
            at->stack[at->depth++] = n.b;
            at->stack[at->depth++] = n.a;
            continue;
        }
        t->log = t->count = 0;
        if (term_of(w, e, t))
            return true;
    }
    return false;
}

/* sum power_j s_j + log = the level, if any */
static void equation(struct scaling *w, struct term *t, int level)
{
    if (level)
        add_power(t, level, -1);
    w->cut |= w->rows.count > EQUATIONS + EACH * w->n;
    if (w->rows.count <= EQUATIONS + EACH * w->n)
        scaling_rows_add(&w->rows, t->unknown, t->power, t->count, t->log);
}

/* Terms of the row: one alone says nothing. */
static void add_even(struct scaling *w, struct term *t)
{
    if (!w->has_first) {
        copy(&w->first, t);
        w->has_first = true;
        return;
    }
    if (!w->own) {
        w->own = new_level(w);
        equation(w, &w->first, w->own);
    }
    equation(w, t, w->own);
}

/* As large as the first term. */
static void add_by_first(struct scaling *w, struct term *t)
{
    if (!w->has_first) {
        copy(&w->first, t);
        w->has_first = true;
        return;
    }
    t->log -= w->first.log;
    for (int k = 0; k < w->first.count; k++)
        add_power(t, w->first.unknown[k], -w->first.power[k]);
    equation(w, t, 0);
}

static void add_terms(struct scaling *w, expr_id e, int velocity)
{
    struct walk at = { { e }, 1 };
    struct term *t = &w->now;
    while (next_term(w, &at, t)) {
        if (velocity >= 0)
            add_power(t, velocity, 1);
        if (velocity >= 0 && w->timed)
            add_power(t, w->n - 1, -1);
        (w->even ? add_even : add_by_first)(w, t);
    }
}

/* An inner sum, or an argument. */
static void add_later(struct scaling *w, struct later l)
{
    struct walk at = { { l.e }, 1 };
    w->has_first = false;
    while (next_term(w, &at, &w->now))
        if (l.unit || w->even)
            equation(w, &w->now, l.unit ? 0 : w->level[l.e]);
        else
            add_by_first(w, &w->now);
}

void scaling_add(struct scaling *w, expr_id e, int velocity)
{
    add_terms(w, e, velocity);
    bool had = w->has_first;
    copy(&w->apart, &w->first);
    for (long guard = 0; w->laters && guard < (w->even ? VISITS : DEPTH); guard++)
        add_later(w, w->later[--w->laters]);
    w->laters = 0;
    copy(&w->first, &w->apart);
    w->has_first = had;
}

void scaling_even(struct scaling *w)
{
    w->even = true;
}

bool scaling_cut(const struct scaling *w)
{
    return w->cut;
}

void scaling_anchor(struct scaling *w, int j, double log, double weight)
{
    assert(j >= 0 && j < w->n && weight > 0);
    scaling_rows_add(&w->rows, &j, &weight, 1, -weight * log);
}

double scaling_size(struct scaling *w, expr_id e, const double *log)
{
    struct walk at = { { e }, 1 };
    struct term *t = &w->now;
    double most = -INFINITY;
    w->visits = 0;
    w->even = false;
    while (next_term(w, &at, t)) {
        for (int k = 0; k < t->count; k++)
            t->log += t->power[k] * log[t->unknown[k]];
        most = fmax(most, t->log);
    }
    w->laters = 0;
    return most;
}

void scaling_logs(struct scaling *w, double *log)
{
    SGA_FREED double *all = sga_malloc((size_t)(w->n + w->levels + 1) * sizeof *all);
    scaling_rows_solve(&w->rows, w->n + w->levels, w->even, all);
    memcpy(log, all, (size_t)w->n * sizeof *log);
}

int *scaling_rounded(const double *log, int count)
{
    int *scale = sga_malloc((size_t)(count + 1) * sizeof *scale), largest = 0;
    for (int i = 0; i < count; i++) {
        scale[i] = (int)lrint(fmax(-MOST, fmin(MOST, log[i])));
        assert(abs(scale[i]) <= MOST);
        largest = abs(scale[i]) > largest ? abs(scale[i]) : largest;
    }
    if (largest >= LEAST)
        return scale;
    free(scale);
    return NULL;
}

int *scaling_solve(struct scaling *w)
{
    SGA_FREED double *log = sga_malloc((size_t)(w->n + 1) * sizeof *log);
    scaling_logs(w, log);
    int *scale = scaling_rounded(log, w->n);
    return scale;
}
