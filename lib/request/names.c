/* Names: new ones are checked, given ones are looked up. */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "lex.h"
#include "mem.h"
#include "names_family.h"
#include "reader.h"
#include "suggest.h"

bool is_identifier(const char *s)
{
    struct lex_token t = lex_next(s, 0);
    return t.kind == LEX_NAME && t.start == 0 && !s[t.length];
}

/* A name of the grammar, with indices or without. */
static bool is_reserved(const char *name)
{
    char base[REQUEST_MAX_NAME + 1];
    snprintf(base, sizeof base, "%.*s", (int)strcspn(name, "["), name);
    return expr_reserved(base);
}

static const char *const kind_text[] = {
    [EXPR_VARIABLE] = "a variable", [EXPR_PARAMETER] = "a parameter", [EXPR_TIME] = "the independent variable",
    [EXPR_VELOCITY] = "a derivative", [EXPR_FREE] = "a free function",
    [EXPR_SIGNAL] = "a table",
};

/* What the name of an old symbol is. */
static const char *kind_of_name(const struct reader *rd, int old)
{
    for (int k = 0; k < rd->r->modes; k++)
        if (rd->r->store.symbol[old].kind == EXPR_PARAMETER && !strcmp(rd->r->mode[k].name, rd->r->store.symbol[old].name))
            return "a mode (system.modes)";
    return kind_text[rd->r->store.symbol[old].kind];
}

int new_name(struct reader *rd, const char *name, enum expr_symbol_kind kind)
{
    struct expr_store *st = &rd->r->store;
    if (strlen(name) > REQUEST_MAX_NAME)
        return at_fail(rd, SGA_E_BAD_NAME, "a name has %zu bytes; the limit is %d", strlen(name), REQUEST_MAX_NAME), -1;
    if (!is_identifier(name))
        return at_fail(rd, SGA_E_BAD_NAME, "\"%s\" is not a name: letters, digits and _, not beginning with a digit",
                       name), -1;
    if (strchr(name, '[') && (kind == EXPR_TIME || kind == EXPR_SIGNAL))
        return at_fail(rd, SGA_E_BAD_NAME, "\"%s\" has an index, which %s cannot have", name, kind_text[kind]), -1;
    if (is_reserved(name))
        return at_fail(rd, SGA_E_BAD_NAME, "\"%s\" is a name of the grammar and cannot be %s", name, kind_text[kind]), -1;
    int old = expr_symbol_find(st, name, strlen(name));
    if (old >= 0 && st->symbol[old].kind == kind)
        return at_fail(rd, SGA_E_DUPLICATE_NAME, "\"%s\" is given twice", name), -1;
    if (old >= 0)
        return at_fail(rd, SGA_E_BAD_NAME, "\"%s\" is already %s%s", name, kind_of_name(rd, old),
                       st->symbol[old].kind == EXPR_TIME ? "; rename one of them (system.time)" : ""), -1;
    expr_id e = expr_symbol_add(st, name, kind);
    return e ? st->node[e].a : (store_ok(rd), -1);
}

void set_value(struct reader *rd, int symbol, expr_id e)
{
    SGA_RESERVE(rd->value, rd->value_cap, symbol + 1);
    while (rd->grammar.values <= symbol)
        rd->value[rd->grammar.values++] = EXPR_UNDEF;
    rd->grammar.value = rd->value;
    rd->value[symbol] = e;
}

bool read_alias(struct reader *rd, const json_t *v, expr_id e)
{
    int symbol = read_new_name(rd, v, EXPR_PARAMETER);
    if (symbol < 0)
        return false;
    rd->r->store.symbol[symbol].mentioned = true;
    set_value(rd, symbol, e);
    return true;
}

int read_new_name(struct reader *rd, const json_t *v, enum expr_symbol_kind kind)
{
    const char *name = read_string(rd, v);
    return name ? new_name(rd, name, kind) : -1;
}

static int column_of(const struct reader *rd, int symbol)
{
    return symbol >= 0 && symbol < rd->columns ? rd->column[symbol] : -1;
}

expr_id state_derivative(void *ctx, int symbol, int order)
{
    assert(symbol >= 0 && symbol < ((struct reader *)ctx)->r->store.symbols && order > 0);
    struct reader *rd = ctx;
    const struct expr_store *st = &rd->r->store;
    SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
    sga_buf_puts(&name, st->symbol[symbol].name);
    for (int k = 0; k < order; k++)
        sga_buf_put(&name, "'", 1);
    int s = expr_symbol_find(st, name.data, name.len);
    return column_of(rd, s) >= 0 ? st->symbol[s].node : EXPR_UNDEF;
}

/* Nothing has this name exactly: it may be spelled der(x), or be wrong. */
static int other_spelling(struct reader *rd, const char *name)
{
    const struct expr_store *st = &rd->r->store;
    if (strchr(name, '\'') || strchr(name, '(')) {
        struct sga_error why = { 0 };
        expr_id e = expr_parse(&rd->r->store, name, &rd->grammar, &why);
        if (e && expr_op_of(st, e) == EXPR_SYM && column_of(rd, st->node[e].a) >= 0)
            return column_of(rd, st->node[e].a);
        if (why.code == SGA_E_EXPR_DERIVATIVE)
            return at_fail(rd, SGA_E_EXPR_DERIVATIVE,
                           "%.100s is not a variable of the system of first order; it follows from the others", name), -1;
    }
    char family[NAMES_FAMILY];
    if (names_family(st, name, strlen(name), family))
        return at_fail(rd, SGA_E_EXPR_NAME, "\"%.100s\" is not a variable of the system; %s", name, family), -1;
    struct suggest s;
    suggest_begin(&s, name, strlen(name));
    for (int i = 0; i < rd->r->system.variables; i++)
        suggest_offer(&s, st->symbol[rd->r->system.variable[i].symbol].name);
    return at_fail(rd, SGA_E_EXPR_NAME, "\"%.100s\" is not a variable of the system%s%s%s", name,
                   s.best ? "; did you mean \"" : "", s.best ? s.best : "", s.best ? "\"?" : ""), -1;
}

int state_variable(struct reader *rd, const char *name)
{
    int symbol = expr_symbol_find(&rd->r->store, name, strlen(name));
    int column = column_of(rd, symbol);
    if (column >= 0)
        return column;
    if (symbol >= 0 && rd->r->store.symbol[symbol].kind == EXPR_PARAMETER)
        return at_fail(rd, SGA_E_EXPR_NAME, "\"%.100s\" is a parameter, not a variable", name), -1;
    return other_spelling(rd, name);
}
