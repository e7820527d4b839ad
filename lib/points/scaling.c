/* Sizes of variables from the terms of the equations. */
#include "scaling.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    struct scaling_rows rows;  /* sum power_j s_j = -log, one for each pair of terms */
    struct term first, now, apart;
    bool has_first, cut;
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
    scaling_rows_init(&w->rows, variables + 1);
    return w;
}

void scaling_time(struct scaling *w, int symbol)
{
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
    free(w);
}

bool scaling_has_time(const struct scaling *w)
{
    return w->time_met;
}

void scaling_sum(struct scaling *w)
{
    w->has_first = false;
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

/* The size of a product; of an inner sum that of its first term. */
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
        case EXPR_MIN: case EXPR_MAX:
            stack[depth].e = expr_is_zero(w->st, n.a) ? n.b : n.a;
            stack[depth++].p = p;
            break;
        case EXPR_NEG: case EXPR_ABS:
        case EXPR_SQRT: case EXPR_CBRT: case EXPR_POWI:
            stack[depth].e = n.a;
            stack[depth++].p = n.op == EXPR_SQRT ? p / 2 : n.op == EXPR_CBRT ? p / 3 : n.op == EXPR_POWI ? p * n.b : p;
            break;
        case EXPR_ADD: case EXPR_SUB:
            postpone(w, at, false);
            stack[depth].e = n.a;
            stack[depth++].p = p;
            break;
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
        if ((n.op == EXPR_ADD || n.op == EXPR_SUB) && at->depth + 2 <= DEPTH) {
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

/* sum power_j s_j + log = 0 */
static void equation(struct scaling *w, const struct term *t)
{
    w->cut |= w->rows.count > EQUATIONS + EACH * w->n;
    if (w->rows.count <= EQUATIONS + EACH * w->n)
        scaling_rows_add(&w->rows, t->unknown, t->power, t->count, t->log);
}

static void add_terms(struct scaling *w, expr_id e, int velocity, bool unit)
{
    struct walk at = { { e }, 1 };
    struct term *t = &w->now;
    while (next_term(w, &at, t)) {
        if (velocity >= 0)
            add_power(t, velocity, 1);
        if (velocity >= 0 && w->timed)
            add_power(t, w->n - 1, -1);
        if (unit) {
            equation(w, t);
        } else if (!w->has_first) {
            copy(&w->first, t);
            w->has_first = true;
        } else {
            t->log -= w->first.log;
            for (int k = 0; k < w->first.count; k++)
                add_power(t, w->first.unknown[k], -w->first.power[k]);
            equation(w, t);
        }
    }
}

void scaling_add(struct scaling *w, expr_id e, int velocity)
{
    add_terms(w, e, velocity, false);
    bool had = w->has_first;
    copy(&w->apart, &w->first);
    for (int guard = 0; w->laters && guard < DEPTH; guard++) {
        struct later l = w->later[--w->laters];
        w->has_first = false;
        add_terms(w, l.e, -1, l.unit);
    }
    w->laters = 0;
    copy(&w->first, &w->apart);
    w->has_first = had;
}

bool scaling_cut(const struct scaling *w)
{
    return w->cut;
}

void scaling_anchor(struct scaling *w, int j, double log, double weight)
{
    scaling_rows_add(&w->rows, &j, &weight, 1, -weight * log);
}

double scaling_size(struct scaling *w, expr_id e, const double *log)
{
    struct walk at = { { e }, 1 };
    struct term *t = &w->now;
    double most = -INFINITY;
    w->visits = 0;
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
    scaling_rows_solve(&w->rows, w->n, log);
}

int *scaling_rounded(const double *log, int count)
{
    int *scale = sga_malloc((size_t)(count + 1) * sizeof *scale), largest = 0;
    for (int i = 0; i < count; i++) {
        scale[i] = (int)lrint(fmax(-MOST, fmin(MOST, log[i])));
        largest = abs(scale[i]) > largest ? abs(scale[i]) : largest;
    }
    if (largest >= LEAST)
        return scale;
    free(scale);
    return NULL;
}

int *scaling_solve(struct scaling *w)
{
    double *log = sga_malloc((size_t)(w->n + 1) * sizeof *log);
    scaling_logs(w, log);
    int *scale = scaling_rounded(log, w->n);
    free(log);
    return scale;
}
