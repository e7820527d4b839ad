/* Symbols of given functions of time, and derivatives that go through them. */
#include "signal.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "derive.h"
#include "error.h"
#include "mem.h"

static expr_id add(struct expr_store *st, const char *name, struct expr_table *table, int order)
{
    expr_id e = expr_symbol_add(st, name, EXPR_SIGNAL);
    if (e) {
        struct expr_symbol *s = st->symbol + st->node[e].a;
        s->table = table;
        s->order = order;
    }
    return e;
}

expr_id expr_signal_add(struct expr_store *st, const char *name, struct expr_table *table)
{
    return expr_symbol_find(st, name, strlen(name)) >= 0 ? EXPR_UNDEF : add(st, name, table, 0);
}

int expr_signal_next(const struct expr_store *st, int symbol)
{
    SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
    sga_buf_printf(&name, "%s'", st->symbol[symbol].name);
    return expr_symbol_find(st, name.data, name.len);
}

expr_id expr_signal_rate(struct expr_store *st, int symbol)
{
    const struct expr_symbol s = st->symbol[symbol];
    SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
    sga_buf_printf(&name, "%s'", s.name);
    int next = expr_symbol_find(st, name.data, name.len);
    expr_id e = next >= 0 ? st->symbol[next].node : EXPR_UNDEF;
    if (!e && (st->signals_fixed || s.order >= EXPR_SIGNAL_ORDERS))
        sga_fail(st->error, SGA_E_LIMIT_GENERATIONS, "a derivative of %.100s of an order past %d is needed; give it as an expression "
                 "of time instead of a table", s.name, s.order);
    else if (!e)
        e = add(st, name.data, s.table, s.order + 1);
    return e;
}

expr_id expr_signal_coefficient(struct expr_store *st, int symbol, int m)
{
    expr_id scale = expr_int(st, 1), e = EXPR_UNDEF;
    for (int k = 1; k <= m; k++) {
        e = expr_signal_rate(st, symbol);
        if (!e)
            return EXPR_UNDEF;
        symbol = st->node[e].a;
        scale = expr_mul(st, scale, expr_rational(st, 1, k));
    }
    return expr_mul(st, scale, e);
}

expr_id expr_time_partial(struct expr_store *st, expr_id e, int time)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    SGA_FREED unsigned char *active = sga_calloc((size_t)st->symbols + 1, 1);
    for (int i = 0; i < st->symbols; i++)
        active[i] = i == time || st->symbol[i].kind == EXPR_SIGNAL;
    expr_cone_init(&cone);
    int terms = expr_gradient(st, &cone, e, active, &term, &cap);
    expr_id sum = expr_int(st, 0);
    for (int k = 0; k < terms && sum; k++) {
        expr_id rate = term[k].symbol == time ? expr_int(st, 1) : expr_signal_rate(st, term[k].symbol);
        sum = rate ? expr_add(st, sum, expr_mul(st, term[k].value, rate)) : EXPR_UNDEF;
    }
    return expr_store_ok(st) ? sum : EXPR_UNDEF;
}
