/* The member `trajectory.start_equations`: what holds at the start, of variables, their derivatives and time. */
#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "reader.h"

static int column_of(const struct reader *rd, int symbol)
{
    return symbol >= 0 && symbol < rd->columns ? rd->column[symbol] : -1;
}

/* x' is a variable of the system of first order, or the derivative of one: that has a symbol which nothing else in a request can say. */
static expr_id derivative_at_start(void *ctx, int symbol, int order)
{
    struct reader *rd = ctx;
    struct request_trajectory *t = &rd->r->trajectory;
    struct expr_store *st = &rd->r->store;
    expr_id state = state_derivative(rd, symbol, order);
    if (state)
        return state;
    expr_id below = order == 1 ? st->symbol[symbol].node : state_derivative(rd, symbol, order - 1);
    int k = below ? column_of(rd, st->node[below].a) : -1;
    if (k < 0)
        return EXPR_UNDEF;
    if (t->rate_symbol[k] < 0) {
        SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
        sga_buf_printf(&name, "der(%s) at the start", st->symbol[st->node[below].a].name);
        expr_id e = expr_symbol_add(st, name.data, EXPR_VELOCITY);
        if (!e)
            return EXPR_UNDEF;
        t->rate_symbol[k] = st->node[e].a;
    }
    return st->symbol[t->rate_symbol[k]].node;
}

static bool read_relation(struct reader *rd, const json_t *v)
{
    struct request_trajectory *t = &rd->r->trajectory;
    struct request_relation *r = t->relation + t->relations;
    if (!json_is_string(v))
        return expected(rd, "an equation, a string \"left = right\"", v);
    struct expr_grammar g = rd->grammar;
    g.derivative = derivative_at_start;
    g.ctx = rd;
    r->value = expr_parse_equation(&rd->r->store, json_string_value(v), &g, rd->err);
    if (!r->value) {
        size_t said = strlen(rd->err->detail);
        if (rd->err->code == SGA_E_EXPR_DERIVATIVE)
            snprintf(rd->err->detail + said, sizeof rd->err->detail - said, "; at the start the first derivatives of the variables of the system of first order are known");
        if (rd->err->code != SGA_E_OK)
            snprintf(rd->err->pointer, sizeof rd->err->pointer, "%s", rd->at.data);
        return rd->err->code != SGA_E_OK ? false : store_ok(rd);
    }
    r->text = sga_take_text(&rd->r->mem, json_string_value(v));
    r->place = sga_take_text(&rd->r->mem, rd->at.data);
    t->relations++;
    return true;
}

bool read_start_equations(struct reader *rd, const json_t *v)
{
    struct request_trajectory *t = &rd->r->trajectory;
    size_t n = list_size(v), mark = at_member(rd, "start_equations");
    assert(!t->relations);
    if (n > 16u * REQUEST_MAX_VARIABLES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu equations; the limit is %d", n, 16 * REQUEST_MAX_VARIABLES);
    t->relation = sga_zeros(&rd->r->mem, n + 1, sizeof *t->relation);
    t->rate_symbol = sga_take(&rd->r->mem, ((size_t)rd->r->system.variables + 1) * sizeof *t->rate_symbol);
    for (int k = 0; k < rd->r->system.variables; k++)
        t->rate_symbol[k] = -1;
    for (size_t i = 0; i < n; i++) {
        size_t here = at_item(rd, v, i);
        if (!read_relation(rd, list_item(v, i)) && !at_pass(rd, here))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

void start_equations_written(struct reader *rd, const json_t *v)
{
    struct request_trajectory *t = &rd->r->trajectory;
    for (int i = 0; i < t->relations; i++) {
        struct sga_error at = { .code = SGA_E_INITIAL };
        snprintf(at.pointer, sizeof at.pointer, "%s", t->relation[i].place);
        written_place(rd->written, v, &at);
        t->relation[i].place = sga_take_text(&rd->r->mem, at.pointer);
    }
}
