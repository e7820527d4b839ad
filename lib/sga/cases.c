/* Conditions on parameters, part by part: a triangular decomposition of small polynomial systems over the real numbers. */
#include "cases.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "derive.h"
#include "mem.h"
#include "poly.h"
#include "system.h"
#include "warnings.h"
#include "cases_solve.h"

/* A part that is not complete: what is still to vanish. */
struct item {
    struct cases_part part;
    expr_id *left; int lefts;
};

struct work {
    struct cases_space space;
    struct item *item; int items; size_t cap;
    struct cases *out;
};

static void push_expr(expr_id **list, int *count, expr_id e)
{
    for (int i = 0; i < *count; i++)
        if ((*list)[i] == e)
            return;
    *list = sga_realloc(*list, ((size_t)*count + 1) * sizeof **list);
    (*list)[(*count)++] = e;
}

static void *copy_of(const void *from, size_t bytes)
{
    void *to = sga_malloc(bytes + 1);
    if (bytes)
        memcpy(to, from, bytes);
    return to;
}

struct cases_part cases_copy(const struct cases_part *p)
{
    struct cases_part c = *p;
    c.where = copy_of(p->where, (size_t)p->wheres * sizeof *p->where);
    c.put = copy_of(p->put, (size_t)p->puts * sizeof *p->put);
    c.excluded = copy_of(p->excluded, (size_t)p->excludeds * sizeof *p->excluded);
    return c;
}

void cases_part_clear(struct cases_part *p)
{
    free(p->where);
    free(p->put);
    free(p->excluded);
    *p = (struct cases_part){ 0 };
}

void cases_clear(struct cases *c)
{
    for (int i = 0; i < c->parts; i++)
        cases_part_clear(c->part + i);
    free(c->part);
    *c = (struct cases){ 0 };
}

static struct item item_copy(const struct item *from)
{
    struct item to = { .part = cases_copy(&from->part), .lefts = from->lefts };
    to.left = copy_of(from->left, (size_t)from->lefts * sizeof *from->left);
    return to;
}

static void item_clear(struct item *i)
{
    cases_part_clear(&i->part);
    free(i->left);
}

/* Takes over the item. */
static void push_item(struct work *w, struct item it)
{
    if (w->items + w->out->parts >= SGA_MOST_PARAMETER_CASES) {
        w->out->cut = true;
        item_clear(&it);
        return;
    }
    SGA_RESERVE(w->item, w->cap, w->items + 1);
    w->item[w->items++] = it;
}

/* The parameter is put in, in what was put before too. False: something that was excluded vanishes. */
static bool put_in(struct work *w, struct cases_part *p, struct cases_put put)
{
    assert(put.value);
    int n = 0;
    for (int i = 0; i < p->puts; i++)
        p->put[i].value = cases_replace(&w->space, p->put[i].value, &put, 1);
    p->put = sga_realloc(p->put, ((size_t)p->puts + 1) * sizeof *p->put);
    p->put[p->puts++] = put;
    for (int i = 0; i < p->excludeds; i++) {
        expr_id e = cases_replace(&w->space, p->excluded[i], &put, 1);
        enum cases_truth z = cases_zero(&w->space, e);
        if (z == CASES_ZERO)
            return false;
        if (z != CASES_NEVER)
            p->excluded[n++] = e;
    }
    p->excludeds = n;
    return true;
}

static bool is_excluded(const struct cases_part *p, expr_id f)
{
    for (int i = 0; i < p->excludeds; i++)
        if (p->excluded[i] == f)
            return true;
    return false;
}

/* What is divided by: not zero here. False: it is zero everywhere here. */
static void exclude(struct work *w, struct cases_part *p, expr_id e)
{
    struct poly_factors f;
    if (!poly_numerator_factors(w->space.st, e, &w->space.limits, &f)) {
        push_expr(&p->excluded, &p->excludeds, e);
        return;
    }
    for (int i = 0; i < f.factors; i++)
        if (!f.factor[i].never_zero && cases_zero(&w->space, f.factor[i].expr) != CASES_NEVER)
            push_expr(&p->excluded, &p->excludeds, f.factor[i].expr);
    poly_factors_clear(&f);
}

/* A factor of the one condition that there is, or of what was a part of it. */
static expr_id root_of(const struct item *it, expr_id f)
{
    return it->part.root || it->lefts || it->part.wheres ? it->part.root : f;
}

/* The zero set of one irreducible factor, the rest of `it` still to do. */
static void branch(struct work *w, const struct item *it, expr_id f)
{
    struct cases_roots roots;
    bool solved = cases_solve(&w->space, f, &roots);
    f = roots.function;
    if (is_excluded(&it->part, f))
        return;
    if (!solved) {
        struct item open = item_copy(it);
        open.part.root = root_of(it, f);
        push_expr(&open.part.where, &open.part.wheres, f);
        open.part.open = true;
        open.lefts = 0;
        push_item(w, open);
        return;
    }
    for (int i = 0; i < roots.count; i++) {
        struct item next = item_copy(it);
        next.part.root = root_of(it, f);
        push_expr(&next.part.where, &next.part.wheres, f);
        if (roots.leading)
            exclude(w, &next.part, roots.leading);
        if (put_in(w, &next.part, (struct cases_put){ roots.symbol, roots.value[i] }))
            push_item(w, next);
        else
            item_clear(&next);
    }
    if (roots.instead) {
        struct item next = item_copy(it);
        next.part.root = root_of(it, f);
        push_expr(&next.part.where, &next.part.wheres, f);
        push_expr(&next.left, &next.lefts, roots.instead);
        push_item(w, next);
    }
    if (roots.leading) {              /* where the coefficient vanishes too */
        struct item next = item_copy(it);
        next.part.root = root_of(it, f);
        push_expr(&next.left, &next.lefts, f);
        push_expr(&next.left, &next.lefts, roots.leading);      /* first */
        push_item(w, next);
    }
}

/* All of its radicals vanish together. */
static void together(struct work *w, const struct item *it, const struct poly_factor *f)
{
    struct item next = item_copy(it);
    next.part.root = root_of(it, f->expr);
    for (int i = 0; i < f->radicals; i++)
        push_expr(&next.left, &next.lefts, f->radical[i]);
    push_item(w, next);
}

/* Parameters are put in once each, and a part that is open keeps the function that has no zero in closed form. */
static bool part_sane(const struct cases_part *p)
{
    bool sane = !p->open || p->wheres > 0;
    for (int i = 0; i < p->puts && sane; i++)
        for (int k = 0; k < i && sane; k++)
            sane = p->put[i].symbol != p->put[k].symbol;
    return sane;
}

static void finish(struct work *w, struct item *it)
{
    assert(part_sane(&it->part));
    struct cases *out = w->out;
    out->part = sga_realloc(out->part, ((size_t)out->parts + 1) * sizeof *out->part);
    out->part[out->parts++] = it->part;
    it->part = (struct cases_part){ 0 };
}

/* By all its factors over the rationals. */
static void branches(struct work *w, const struct item *it, expr_id e)
{
    struct poly_factors f;
    if (!poly_numerator_factors(w->space.st, e, &w->space.limits, &f)) {
        branch(w, it, e);
        return;
    }
    for (int i = 0; i < f.factors; i++) {
        const struct poly_factor *q = f.factor + i;
        if (q->never_zero || cases_zero(&w->space, q->expr) == CASES_NEVER)
            continue;
        if (q->sum_of_even_powers && q->radicals > 0)
            together(w, it, q);
        else
            branch(w, it, q->expr);
    }
    poly_factors_clear(&f);
}

/* Prime for sure, and with real zeros: no factorisation is needed. */
static bool prime(const struct work *w, expr_id e)
{
    const struct sys_system *sys = w->space.system;
    struct expr_store *st = w->space.st;
    for (int i = 0; i < sys->parameters; i++) {
        expr_id d = expr_diff(st, e, sys->parameter[i]);
        if (expr_is_const(st, d) && !expr_is_zero(st, d))
            return true;
    }
    return false;
}

/* A product as it is written, part by part. */
static void factors(struct work *w, const struct item *it, expr_id e)
{
    enum { PARTS = 32 };
    expr_id part[PARTS] = { e };
    for (int n = 1; n > 0; ) {
        expr_id top = part[--n];
        const struct expr_node node = w->space.st->node[top];
        if (node.op == EXPR_MUL && n + 2 <= PARTS) {
            part[n++] = node.a;
            part[n++] = node.b;
        } else if (node.op == EXPR_NEG || (node.op == EXPR_POWI && node.b > 0)) {
            part[n++] = node.a;
        } else if (prime(w, top)) {
            branch(w, it, top);
        } else if (cases_zero(&w->space, top) != CASES_NEVER) {
            branches(w, it, top);
        }
    }
}

/* A number that could not be told from 0 is no condition. */
static bool has_parameter(const struct work *w, expr_id e)
{
    const struct sys_system *sys = w->space.system;
    bool has = false;
    for (int i = 0; i < sys->parameters && !has; i++)
        has = !expr_is_zero(w->space.st, expr_diff(w->space.st, e, sys->parameter[i]));
    return has;
}

static void advance(struct work *w, struct item *it)
{
    assert(it->lefts >= 0);
    if (!it->lefts) {
        finish(w, it);
        return;
    }
    expr_id e = cases_replace(&w->space, it->left[--it->lefts], it->part.put, it->part.puts);
    enum cases_truth z = cases_zero(&w->space, e);
    if (z == CASES_ZERO)
        push_item(w, item_copy(it));
    else if (z != CASES_NEVER && has_parameter(w, e))
        factors(w, it, e);
}

bool cases_zero_on(const struct sys_system *system, const struct cases_part *part, expr_id f)
{
    struct cases_space space = cases_space_of(system, NULL);
    return cases_zero(&space, cases_replace(&space, f, part->put, part->puts)) == CASES_ZERO;
}

bool cases_within(const struct sys_system *system, const struct cases_part *part, const struct cases_part *other)
{
    struct expr_store *st = system->store;
    if (part->open || other->open)
        return part->open && other->open && part->wheres == other->wheres
               && memcmp(part->where, other->where, (size_t)part->wheres * sizeof *part->where) == 0;
    for (int i = 0; i < other->puts; i++)
        if (!cases_zero_on(system, part, expr_sub(st, st->symbol[other->put[i].symbol].node, other->put[i].value)))
            return false;
    for (int i = 0; i < other->excludeds; i++)
        if (cases_zero_on(system, part, other->excluded[i]))
            return false;
    return true;
}

/* Those that lie in others go. */
static void thin(const struct sys_system *system, struct cases *c)
{
    int n = 0;
    for (int i = 0; i < c->parts; i++) {
        bool within = false;
        for (int k = 0; k < c->parts && !within; k++)
            within = k != i && c->part[k].wheres && cases_within(system, c->part + i, c->part + k)
                     && !(k > i && cases_within(system, c->part + k, c->part + i));
        if (within)
            cases_part_clear(c->part + i);
    }
    for (int i = 0; i < c->parts; i++)
        if (c->part[i].wheres)
            c->part[n++] = c->part[i];
    c->parts = n;
}

void cases_of(const struct sys_system *system, const expr_id *function, int functions, const expr_id *excluded, int excludeds,
              const struct sga_budget *budget, struct cases *out)
{
    struct work w = { .space = cases_space_of(system, budget), .out = out };
    *out = (struct cases){ .part = NULL };
    struct item first = { .lefts = functions, .left = copy_of(function, (size_t)functions * sizeof *function) };
    first.part.excluded = copy_of(excluded, (size_t)excludeds * sizeof *excluded);
    first.part.excludeds = excludeds;
    push_item(&w, first);
    while (w.items && sga_budget_ok(budget, NULL) && expr_store_ok(system->store)) {
        SGA_ENDS(item_clear) struct item it = w.item[--w.items];
        advance(&w, &it);
    }
    out->cut |= w.items > 0;
    while (w.items)
        item_clear(w.item + --w.items);
    free(w.item);
    thin(system, out);
}
