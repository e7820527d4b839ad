/* Names that the mechanical forms add: velocities q', multipliers lambda1, lambda2, ... */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "reader.h"

expr_id read_velocity_of(void *ctx, int symbol, int order)
{
    const struct reader *rd = ctx;
    const struct expr_store *st = &rd->r->store;
    char name[REQUEST_MAX_NAME + 2];
    if (order != 1 || strchr(st->symbol[symbol].name, '\''))
        return EXPR_UNDEF;
    snprintf(name, sizeof name, "%s'", st->symbol[symbol].name);
    int s = expr_symbol_find(st, name, strlen(name));
    return s < 0 ? EXPR_UNDEF : st->symbol[s].node;
}

int *read_make_velocities(struct reader *rd, const int *coordinate, int n)
{
    struct expr_store *st = &rd->r->store;
    int *velocity = sga_zeros(&rd->r->mem, (size_t)n + 1, sizeof *velocity);
    for (int i = 0; i < n; i++) {
        char name[REQUEST_MAX_NAME + 2];
        snprintf(name, sizeof name, "%s'", st->symbol[coordinate[i]].name);
        expr_id e = expr_symbol_add(st, name, EXPR_VARIABLE);
        if (!e) {
            store_ok(rd);
            return NULL;
        }
        velocity[i] = st->node[e].a;
    }
    return velocity;
}

bool read_motion_fits(struct reader *rd, int coordinates, int multipliers)
{
    assert(coordinates > 0 && multipliers >= 0);
    long count = 2L * coordinates + multipliers;
    return count <= REQUEST_MAX_VARIABLES
           || at_fail(rd, SGA_E_LIMIT_VARIABLES, "the system of first order has %ld variables; the limit is %d", count,
                      REQUEST_MAX_VARIABLES);
}

int *read_make_multipliers(struct reader *rd, int n)
{
    struct expr_store *st = &rd->r->store;
    SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
    bool ok = true;
    int *multiplier = sga_zeros(&rd->r->mem, (size_t)n + 1, sizeof *multiplier);
    for (int i = 0; i < n && ok; i++) {
        sga_buf_clear(&name);
        sga_buf_printf(&name, "lambda%d", i + 1);
        while (expr_symbol_find(st, name.data, name.len) >= 0)
            sga_buf_put(&name, "_", 1);
        expr_id e = expr_symbol_add(st, name.data, EXPR_VARIABLE);
        ok = e != EXPR_UNDEF;
        multiplier[i] = ok ? st->node[e].a : -1;
    }
    if (ok)
        return multiplier;
    store_ok(rd);
    return NULL;
}
