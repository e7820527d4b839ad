/* See pole_named.h. */
#include "pole_named.h"

#include <stdlib.h>

#include "definition.h"
#include "error.h"
#include "field.h"
#include "manifold.h"
#include "mem.h"
#include "reduction.h"
#include "system.h"
#include "tape.h"

struct pole_named {
    struct sga_solution rest;      /* of its lists only constraints are set */
    struct manifold manifold;
    struct num_tape *value;
};

static bool divides(const struct expr_store *st, expr_id e)
{
    struct expr_cone cone;
    bool any = false;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    for (int i = 0; i < cone.count && !any; i++) {
        expr_id divisor = expr_divisor(st, cone.list[i]);
        any = divisor && !expr_is_const(st, divisor);
    }
    expr_cone_clear(&cone);
    return any;
}

/* The constraints with the definitions put in; those that say nothing then are left out. */
static void put_in(struct pole_named *q, const struct field *f, const struct definitions *names)
{
    q->rest.constraint = sga_calloc((size_t)f->c + 1, sizeof *q->rest.constraint);
    for (int i = 0; i < f->c; i++) {
        expr_id e = f->constraint[i];
        definitions_through(names, f->sys, &e, 1);
        if (e && !expr_is_zero(f->sys->store, e))
            q->rest.constraint[q->rest.constraints++].expr = e;
    }
}

struct pole_named *pole_named_new(const struct field *f)
{
    struct definitions names = { 0 };
    struct sga_error ignored = { 0 };
    int count = 0, *inputs = field_inputs(f->sys);
    definitions_find(&names, f->sys, DEFINITIONS_ALL, NULL);
    SGA_FREED expr_id *value = sga_malloc(((size_t)names.count + 1) * sizeof *value);
    for (int i = 0; i < names.count; i++)
        if (divides(f->sys->store, names.at[i].value))
            value[count++] = names.at[i].value;
    struct pole_named *q = count ? sga_calloc(1, sizeof *q) : NULL;
    if (q) {
        put_in(q, f, &names);
        q->value = num_tape_new(f->sys->store, value, count, inputs, f->n + 1, &ignored);
    }
    if (q && (!q->value || !manifold_init(&q->manifold, f->sys, &q->rest, NULL, &ignored))) {
        pole_named_free(q);
        q = NULL;
    }
    definitions_clear(&names);
    free(inputs);
    return q;
}

void pole_named_free(struct pole_named *q)
{
    if (!q)
        return;
    manifold_clear(&q->manifold);
    num_tape_free(q->value);
    free(q->rest.constraint);
    free(q);
}

struct manifold *pole_named_rest(struct pole_named *q) { return &q->manifold; }

int pole_named_count(const struct pole_named *q) { return num_tape_roots(q->value); }

void pole_named_values(struct pole_named *q, const double *in, double *w) { num_tape_eval(q->value, in, w); }
