/* Order reduction and prolongation: F(x, x', ..., t) = 0 to A x' = alpha.
 *
 * "Top" derivatives are the symbols of the highest derivatives x^(r), r >= 1, as long
 * as they are not prolonged. The gradient of each equation with respect to the tops says
 * what is linear; what is not is prolonged, and leaves the tops. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "derivatives.h"
#include "derive.h"
#include "equations.h"
#include "error.h"
#include "mem.h"
#include "system.h"

struct reduction {
    struct form_equations *f;
    struct expr_store *st;
    struct sys_system *s;
    struct expr_cone cone;
    struct expr_term *term; size_t terms, term_cap;   /* of all equations, one after the other */
    size_t *first;                     /* equation -> its first term; one more at the end */
    unsigned char *top;                /* symbol -> it is a top derivative */
    expr_id *rest;                     /* the equations at top derivatives = 0 */
};

/* The unknown that a symbol is a derivative of (or is), or NULL. */
static struct form_unknown *owner(const struct reduction *r, int symbol)
{
    if (symbol >= r->f->known || r->f->owner[symbol] < 0)
        return NULL;
    return r->f->unknown + r->f->owner[symbol];
}

static void find_orders(struct reduction *r)
{
    expr_cone_of(r->st, &r->cone, r->f->equation, r->f->equations);
    for (int i = 0; i < r->cone.count; i++) {
        const struct expr_node *n = r->st->node + r->cone.list[i];
        struct form_unknown *u = n->op == EXPR_SYM ? owner(r, n->a) : NULL;
        if (u && r->f->rank[n->a] > u->order)
            u->order = r->f->rank[n->a];
    }
}

/* Symbols of all orders up to the highest; those below it are state variables now. */
static bool make_symbols(struct reduction *r)
{
    for (int u = 0; u < r->f->unknowns; u++)
        for (int k = 1; k <= r->f->unknown[u].order; k++) {
            int symbol = form_derivative_symbol(r->f, u, k);
            if (symbol < 0)
                return false;
            if (k < r->f->unknown[u].order)
                r->st->symbol[symbol].kind = EXPR_VARIABLE;
        }
    return true;
}

static void mark_tops(struct reduction *r)
{
    r->top = sga_calloc((size_t)r->st->symbols + 1, 1);
    for (int i = 0; i < r->f->unknowns; i++)
        if (r->f->unknown[i].order)
            r->top[r->f->unknown[i].symbol[r->f->unknown[i].order]] = 1;
}

/* r->term[first[i] .. first[i+1]): the gradient of equation i in the tops. */
static void find_gradients(struct reduction *r)
{
    SGA_FREED struct expr_term *one = NULL;
    size_t cap = 0;
    r->first = sga_calloc((size_t)r->f->equations + 1, sizeof *r->first);
    for (int i = 0; i < r->f->equations; i++) {
        int n = expr_gradient(r->st, &r->cone, r->f->equation[i], r->top, &one, &cap);
        SGA_RESERVE(r->term, r->term_cap, r->terms + (size_t)n);
        if (n)
            memcpy(r->term + r->terms, one, (size_t)n * sizeof *one);
        r->terms += (size_t)n;
        r->first[i + 1] = r->terms;
    }
}

static void prolong(struct reduction *r, int symbol)
{
    owner(r, symbol)->prolonged = true;
    r->top[symbol] = 0;
}

static void prolong_in_cone(struct reduction *r)
{
    for (int i = 0; i < r->cone.count; i++) {
        const struct expr_node *n = r->st->node + r->cone.list[i];
        if (n->op == EXPR_SYM && r->top[n->a])
            prolong(r, n->a);
    }
}

/* sign(x') has the derivative 0 and is not linear: the gradient does not show it. */
static void prolong_steps(struct reduction *r)
{
    SGA_FREED expr_id *step = NULL;
    size_t cap = 0;
    int steps = 0;
    expr_cone_of(r->st, &r->cone, r->f->equation, r->f->equations);
    for (int i = 0; i < r->cone.count; i++)
        if (expr_op_of(r->st, r->cone.list[i]) == EXPR_SIGN) {
            SGA_RESERVE(step, cap, steps + 1);
            step[steps++] = r->cone.list[i];
        }
    expr_cone_of(r->st, &r->cone, step, steps);
    prolong_in_cone(r);
}

/* Prolong every top whose own coefficient depends on it (pass 0), then those whose
 * coefficient depends on another top that is left, with that one (pass 1). */
static void prolong_nonlinear(struct reduction *r, int pass)
{
    SGA_FREED unsigned char *found = sga_calloc((size_t)r->st->symbols + 1, 1);
    for (size_t k = 0; k < r->terms; k++) {
        int v = r->term[k].symbol;
        if (!r->top[v])
            continue;
        expr_cone_of(r->st, &r->cone, &r->term[k].value, 1);
        for (int i = 0; i < r->cone.count; i++) {
            const struct expr_node *n = r->st->node + r->cone.list[i];
            if (n->op == EXPR_SYM && r->top[n->a] && (n->a == v || pass == 1))
                found[v] = found[n->a] = 1;
        }
    }
    for (int j = 0; j < r->st->symbols; j++)
        if (found[j])
            prolong(r, j);
}

static void set_tops_to_zero(struct reduction *r, expr_id *roots, int nroots)
{
    SGA_FREED expr_id *map = sga_calloc((size_t)r->st->symbols + 1, sizeof *map);
    expr_id zero = expr_int(r->st, 0);
    for (int j = 0; j < r->st->symbols; j++)
        map[j] = r->top[j] ? zero : EXPR_UNDEF;
    expr_substitute(r->st, roots, nroots, map);
}

static void find_rests(struct reduction *r)
{
    size_t bytes = (size_t)r->f->equations * sizeof *r->rest;
    r->rest = sga_malloc(bytes + 1);
    if (bytes)
        memcpy(r->rest, r->f->equation, bytes);
    set_tops_to_zero(r, r->rest, r->f->equations);
}

/* The number of derivatives of u that are state variables (0: u itself). */
static int last_state(const struct form_unknown *u)
{
    return u->prolonged ? u->order : u->order > 0 ? u->order - 1 : 0;
}

static bool add_variables(struct reduction *r, int max_variables, struct sga_error *err)
{
    long count = 0;
    int highest = 0;
    for (int i = 0; i < r->f->unknowns; i++) {
        int last = last_state(r->f->unknown + i);
        count += 1 + last;
        highest = last > highest ? last : highest;
    }
    if (count > max_variables)
        return sga_fail(err, SGA_E_LIMIT_VARIABLES, "the system of first order has %ld variables; the limit is %d",
                        count, max_variables);
    for (int k = 0; k <= highest; k++)
        for (int i = 0; i < r->f->unknowns; i++) {
            struct form_unknown *u = r->f->unknown + i;
            if (k > last_state(u))
                continue;
            r->st->symbol[u->symbol[k]].kind = EXPR_VARIABLE;
            sys_add_variable(r->s, u->symbol[k], k ? "derivative" : "variable");
        }
    return true;
}

static int *columns(const struct reduction *r)
{
    int *column = sga_malloc(((size_t)r->st->symbols + 1) * sizeof *column);
    for (int j = 0; j < r->s->variables; j++)
        column[r->s->variable[j].symbol] = j;
    return column;
}

static void add_rows(struct reduction *r)
{
    SGA_FREED int *column = columns(r);
    for (int i = 0; i < r->f->equations; i++) {
        char source[40];
        snprintf(source, sizeof source, "equations[%d]", i);
        int row = sys_add_row(r->s, expr_neg(r->st, r->rest[i]), source);
        for (size_t k = r->first[i]; k < r->first[i + 1]; k++) {
            const struct expr_term *t = r->term + k;
            if (r->top[t->symbol])
                sys_add_entry(r->s, row, column[owner(r, t->symbol)->symbol[r->f->rank[t->symbol] - 1]], t->value);
        }
    }
    struct sga_buf source = { 0 };
    for (int i = 0; i < r->f->unknowns; i++) {
        const struct form_unknown *u = r->f->unknown + i;
        for (int k = 1; k <= last_state(u); k++) {
            const struct expr_symbol *v = r->st->symbol + u->symbol[k];
            sga_buf_clear(&source);
            sga_buf_printf(&source, "definition of %s", v->name);
            int row = sys_add_row(r->s, v->node, source.data);
            sys_add_entry(r->s, row, column[u->symbol[k - 1]], expr_int(r->st, 1));
        }
    }
    sga_buf_free(&source);
}

bool form_equations_reduce(struct form_equations *f, struct sys_system *s, int max_variables, struct sga_error *err)
{
    struct reduction r = { .f = f, .st = f->store, .s = s };
    expr_cone_init(&r.cone);
    find_orders(&r);
    bool ok = make_symbols(&r);
    if (ok) {
        mark_tops(&r);
        find_gradients(&r);
    }
    if (ok && expr_store_ok(r.st)) {
        prolong_steps(&r);
        prolong_nonlinear(&r, 0);
        prolong_nonlinear(&r, 1);
        find_rests(&r);
        ok = add_variables(&r, max_variables, err);
        if (ok)
            add_rows(&r);
    }
    s->square = f->equations == f->unknowns;
    expr_cone_clear(&r.cone);
    free(r.term);
    free(r.first);
    free(r.top);
    free(r.rest);
    if (!expr_store_ok(r.st))
        return sga_fail(err, r.st->error->code, "%s", r.st->error->detail);
    return ok || sga_fail(err, SGA_E_INTERNAL, "a derivative's symbol could not be made");
}
