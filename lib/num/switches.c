/* Finding switches in expressions. */
#include "switches.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "facts.h"
#include "mem.h"

static bool switches(int op) { return op == EXPR_ABS || op == EXPR_SIGN || op == EXPR_MIN || op == EXPR_MAX; }

/* By node: the switch that it is the argument of, or -1. Differences are made on the way. */
struct arguments { int *number; size_t cap; int known; };

static int number_of(struct num_switches *w, struct arguments *a, expr_id argument, size_t *cap)
{
    SGA_RESERVE(a->number, a->cap, (int)argument + 1);
    for (; a->known <= (int)argument; a->known++)
        a->number[a->known] = -1;
    if (a->number[argument] < 0) {
        SGA_RESERVE(w->argument, *cap, w->count + 1);
        w->argument[w->count] = argument;
        a->number[argument] = w->count++;
    }
    return a->number[argument];
}

/* min(x, 1/2) and sign(x - 1/2), which derivatives of it have, are one switch, in whatever order min has the two: where sign or abs has the difference the
 * other way round, so has min. Those come first. */
static bool is_first(int op) { return op == EXPR_ABS || op == EXPR_SIGN; }

void num_switches_find(struct num_switches *w, struct expr_store *st, const expr_id *root, int roots)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_ENDS(expr_facts_clear) struct expr_facts facts;
    struct arguments arguments = { 0 };
    size_t cap = 0;
    *w = (struct num_switches){ 0 };
    expr_facts_init(&facts);
    expr_cone_init(&cone);
    if (roots)
        expr_cone_of(st, &cone, root, roots);
    int nodes = st->nodes;
    for (int i = 0; i < 2 * cone.count; i++) {
        expr_id e = cone.list[i % cone.count];
        struct expr_node n = st->node[e];
        if (!switches(n.op) || is_first(n.op) != (i < cone.count))
            continue;
        expr_id g = n.op == EXPR_ABS || n.op == EXPR_SIGN ? n.a : expr_sub(st, n.a, n.b);
        expr_id other = is_first(n.op) ? EXPR_UNDEF : expr_sub(st, n.b, n.a);
        bool swapped = other && (int)other < arguments.known && arguments.number[other] >= 0;
        g = swapped ? other : g;
        if (expr_is_const(st, g) || !(expr_facts_of(&facts, st, g) & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
            continue;
        if (!w->of) {
            w->nodes = nodes;
            w->of = sga_malloc((size_t)w->nodes * sizeof *w->of);
            memset(w->of, -1, (size_t)w->nodes * sizeof *w->of);
            w->swapped = sga_calloc((size_t)w->nodes, 1);
        }
        w->of[e] = number_of(w, &arguments, g, &cap);
        w->swapped[e] = swapped;
        assert(w->of[e] >= 0 && w->of[e] < w->count);
    }
    free(arguments.number);
    assert(!w->count == !w->of);
}

void num_switches_clear(struct num_switches *w)
{
    free(w->argument);
    free(w->of);
    free(w->swapped);
    *w = (struct num_switches){ 0 };
}
