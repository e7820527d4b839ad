/* Names, copies and prints of a derivation's expressions. */
#include "sheet.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "derive.h"
#include "error.h"
#include "job_texts.h"
#include "lines.h"
#include "math_name.h"
#include "parse.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "signal.h"

/* Longer texts are for programs: a step without one says so. */
enum { STEP_BYTES = 4000 };

static expr_id primed(void *ctx, int symbol, int order)
{
    struct expr_store *st = ctx;
    SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
    sga_buf_puts(&name, st->symbol[symbol].name);
    for (int k = 0; k < order; k++)
        sga_buf_puts(&name, "'");
    int found = expr_symbol_find(st, name.data, name.len);
    return found < 0 ? EXPR_UNDEF : st->symbol[found].node;
}

/* A symbol named `name`, or with lines behind where that is taken. */
static int new_symbol(struct expr_store *st, const char *name, enum expr_symbol_kind kind)
{
    SGA_ENDS(sga_buf_free) struct sga_buf b = { 0 };
    sga_buf_puts(&b, name);
    while (expr_symbol_find(st, b.data, b.len) >= 0)
        sga_buf_puts(&b, "_");
    expr_symbol_add(st, b.data, kind);
    return st->symbols - 1;
}

/* The parts that the answer's texts share, by name: read once, put in wherever they stand. */
static void read_parts(struct derivation_sheet *s)
{
    const struct job *j = s->j;
    struct expr_store *st = &s->m.store;
    int parts = j->texts && j->texts->has ? j->texts->names.count : 0, first = st->symbols;
    for (int k = 0; k < parts; k++)
        expr_symbol_add(st, j->texts->names.name[k], EXPR_PARAMETER);
    s->aliases = st->symbols;
    s->alias = sga_zeros(&s->m.memory, (size_t)s->aliases + 1, sizeof *s->alias);
    for (int k = 0; k < parts && st->symbols == first + parts; k++)
        s->alias[first + k] = derivation_sheet_read(s, j->texts->names.text[k]);
}

void derivation_sheet_open(struct derivation_sheet *s, struct job *j)
{
    const struct expr_store *from = &j->request->store;
    const struct sys_system *sys = &j->request->system;
    *s = (struct derivation_sheet){ .j = j, .m = { .language = EXPORT_LATEX } };
    struct expr_store *st = &s->m.store;
    s->m.source = &s->source;
    expr_store_init(st);
    expr_copy_symbols(st, from);
    st->max_nodes = from->max_nodes;
    st->max_bits = from->max_bits;
    st->deadline = from->deadline;
    st->seconds = from->seconds;
    s->none = sga_zeros(&s->m.memory, (size_t)from->symbols + 1, sizeof *s->none);
    s->first = st->symbols;
    for (int i = 0; i < sys->variables; i++) {
        SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
        sga_buf_printf(&name, "der(%s)", from->symbol[sys->variable[i].symbol].name);
        new_symbol(st, name.data, EXPR_VELOCITY);
    }
    s->free = st->symbols;
    for (int k = 0; k < j->solution->free_columns; k++) {
        char name[160];
        answer_free_name(j, k, name, sizeof name);
        new_symbol(st, name, EXPR_FREE);
    }
    read_parts(s);
}

void derivation_sheet_close(struct derivation_sheet *s)
{
    export_model_clear(&s->m);
}

expr_id derivation_sheet_copy(struct derivation_sheet *s, expr_id e)
{
    if (e)
        expr_copy(&s->m.store, &s->j->request->store, &e, 1, s->none);
    return e;
}

expr_id derivation_sheet_read(struct derivation_sheet *s, const char *text)
{
    struct expr_store *st = &s->m.store;
    struct expr_grammar g = { .derivative = primed, .ctx = st, .value = s->alias, .values = s->aliases, .max_length = 1 << 28, .max_depth = 1 << 20,
                              .max_exponent = 1L << 30, .max_digits = 1 << 20 };
    struct sga_error err = { 0 };
    return text ? expr_parse(st, text, &g, &err) : EXPR_UNDEF;
}

expr_id derivation_sheet_velocity(const struct derivation_sheet *s, int variable)
{
    return s->m.store.symbol[s->first + variable].node;
}

expr_id derivation_sheet_rate(struct derivation_sheet *s, expr_id e)
{
    struct expr_store *st = &s->m.store;
    const struct sys_system *sys = &s->j->request->system;
    SGA_ARENA(mem);
    unsigned char *active = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    int *variable = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *variable);
    for (int i = 0; i < sys->variables; i++) {
        active[sys->variable[i].symbol] = 1;
        variable[sys->variable[i].symbol] = i;
    }
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    int terms = expr_gradient(st, &cone, e, active, &term, &cap);
    expr_id sum = expr_time_partial(st, e, sys->time);
    for (int k = 0; k < terms; k++)
        sum = expr_add(st, sum, expr_mul(st, term[k].value, derivation_sheet_velocity(s, variable[term[k].symbol])));
    return sum;
}

void derivation_sheet_velocities(struct derivation_sheet *s, expr_id e, unsigned char *marked)
{
    const struct expr_store *st = &s->m.store;
    int n = s->j->request->system.variables;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    for (int i = 0; i < cone.count; i++) {
        int symbol = expr_op_of(st, cone.list[i]) == EXPR_SYM ? st->node[cone.list[i]].a : -1;
        if (symbol >= s->first && symbol < s->first + n)
            marked[symbol - s->first] = 1;
    }
}

bool derivation_sheet_text(struct derivation_sheet *s, expr_id e, struct sga_buf *out)
{
    return e && expr_print(&s->m.store, e, STEP_BYTES, out);
}

/* The LaTeX of each symbol; of a velocity a dot over its variable. */
static void name_symbols(struct derivation_sheet *s)
{
    const struct expr_store *st = &s->m.store;
    int n = s->j->request->system.variables;
    if (s->m.symbol)
        return;
    s->m.symbol = sga_zeros(&s->m.memory, (size_t)st->symbols + 1, sizeof *s->m.symbol);
    for (int i = 0; i < st->symbols; i++) {
        bool velocity = i >= s->first && i < s->first + n;
        if (!velocity) {
            s->m.symbol[i] = math_name(&s->m.memory, EXPORT_LATEX, s->m.symbol, i, st->symbol[i].name);
            continue;
        }
        SGA_ENDS(sga_buf_free) struct sga_buf b = { 0 };
        sga_buf_printf(&b, "\\dot{%s}", s->m.symbol[s->j->request->system.variable[i - s->first].symbol]);
        s->m.symbol[i] = sga_take_text(&s->m.memory, b.data);
    }
}

bool derivation_sheet_latex(struct derivation_sheet *s, expr_id e, struct sga_buf *out)
{
    struct sga_error err = { 0 };
    if (!e)
        return false;
    name_symbols(s);
    size_t before = out->len;
    bool ok = export_value(&s->m, e, out, &err);
    if (!ok)
        out->len = before;
    return ok;
}
