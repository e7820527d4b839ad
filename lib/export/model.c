/* Texts to nodes. Names such as x'' are symbols of that name: the order reduction made variables of them. */
#include "model.h"

#include "budget.h"
#include "derive.h"
#include "dialect.h"
#include "error.h"
#include "math_name.h"
#include "parse.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* An export is made while a client waits: what an answer of many megabytes would need beyond these is refused. */
enum { EXPORT_NODES = 4000000, EXPORT_SECONDS = 10 };

static expr_id primed(void *ctx, int symbol, int order)
{
    struct expr_store *st = ctx;
    SGA_ARENA(mem);
    size_t n = strlen(st->symbol[symbol].name);
    char *name = sga_take(&mem, n + (size_t)order + 1);
    memcpy(name, st->symbol[symbol].name, n);
    memset(name + n, '\'', (size_t)order);
    int found = expr_symbol_find(st, name, n + (size_t)order);
    return found < 0 ? EXPR_UNDEF : st->symbol[found].node;
}

/* The text of the k-th place of an array, counted as the language counts. */
static const char *place(struct export_model *m, const char *pattern, int k)
{
    char *text = sga_take(&m->memory, 32);
    snprintf(text, 32, pattern, k + export_dialect(m->language)->first);
    return text;
}

static bool name_it(struct export_model *m, const char *name, enum expr_symbol_kind kind, const char *text, struct sga_error *err)
{
    int symbols = m->store.symbols;
    if (!expr_symbol_add(&m->store, name, kind) || m->store.symbols != symbols + 1)
        return sga_fail(err, SGA_E_NO_CODE, "The name %.80s stands for two things in the answer.", name);
    assert(symbols < 1 + m->source->variables + m->source->parameters + m->source->definitions);
    m->symbol[symbols] = text;
    return true;
}

/* k: how many parameters with values come before. */
static const char *constant(struct export_model *m, const char *name, int k)
{
    const struct export_dialect *d = export_dialect(m->language);
    if (d->constant)
        return place(m, d->constant, k);
    /* Indices become lines: P_k_2_1 for k[2,1]; a name that is taken gets lines behind. */
    size_t n = strlen(name) + 3 + (size_t)m->store.symbols;
    char *text = sga_take(&m->memory, n), *to = text + 2;
    memcpy(text, "P_", 2);
    for (const char *s = name; *s; s++)
        if (*s != ']')
            *to++ = *s == '[' || *s == ',' ? '_' : *s;
    *to = 0;
    for (bool taken = strpbrk(name, "[_") != NULL; taken; ) {
        taken = false;
        for (int i = 0; i < m->store.symbols && !taken; i++)
            taken = m->symbol[i] && strcmp(m->symbol[i], text) == 0;
        if (taken)
            memcpy(to++, "_", 2);
    }
    return text;
}

/* Print has names where programs have places. */
static const char *text_of(struct export_model *m, const char *name, const char *pattern, int k)
{
    return export_is_print(m->language) ? math_name(&m->memory, m->language, m->symbol, m->store.symbols, name) : place(m, pattern, k);
}

static bool name_parameter(struct export_model *m, int i, struct sga_error *err)
{
    const struct export_parameter *p = &m->source->parameter[i];
    const char *text = !p->value ? text_of(m, p->name, export_dialect(m->language)->argument, m->free_parameters++)
                       : export_is_print(m->language) ? text_of(m, p->name, NULL, 0) : constant(m, p->name, i - m->free_parameters);
    return name_it(m, p->name, EXPR_PARAMETER, text, err);
}

static bool name_all(struct export_model *m, struct sga_error *err)
{
    const struct export_source *s = m->source;
    bool ok = name_it(m, s->time, EXPR_TIME, export_is_print(m->language) ? text_of(m, s->time, NULL, 0) : "t", err);
    for (int i = 0; i < s->variables && ok; i++)
        ok = name_it(m, s->variable[i], EXPR_VARIABLE, text_of(m, s->variable[i], export_dialect(m->language)->variable, i), err);
    for (int i = 0; i < s->parameters && ok; i++)
        ok = name_parameter(m, i, err);
    for (int i = 0; i < s->definitions && ok; i++)
        ok = name_it(m, s->definition[i].name, EXPR_FREE, NULL, err);
    return ok;
}

static bool read_text(struct export_model *m, const char *text, const struct expr_grammar *g, const char *what, expr_id *out, struct sga_error *err)
{
    struct sga_error why = { 0 };
    *out = expr_parse(&m->store, text, g, &why);
    return *out != EXPR_UNDEF || sga_fail(err, SGA_E_NO_CODE, "%s cannot be read for an export: %.500s", what, why.detail);
}

static bool read_list(struct export_model *m, int n, const char *const *text, const struct expr_grammar *g, const char *what, expr_id **out, struct sga_error *err)
{
    *out = sga_zeros(&m->memory, (size_t)n, sizeof **out);
    for (int i = 0; i < n; i++)
        if (!read_text(m, text[i], g, what, &(*out)[i], err))
            return false;
    return true;
}

static bool read_values(struct export_model *m, struct sga_error *err)
{
    const struct export_source *s = m->source;
    struct expr_store empty;
    bool ok = true;
    m->value = sga_zeros(&m->memory, (size_t)s->parameters, sizeof *m->value);
    expr_store_init(&empty);            /* values use no names */
    for (int i = 0; i < s->parameters && ok; i++) {
        struct sga_error why = { 0 };
        if (s->parameter[i].value && !(m->value[i] = expr_parse(&empty, s->parameter[i].value, NULL, &why)))
            ok = sga_fail(err, SGA_E_NO_CODE, "The value of the parameter %.80s cannot be read for an export: %.400s", s->parameter[i].name, why.detail);
    }
    if (ok)
        expr_copy(&m->store, &empty, m->value, s->parameters, NULL);
    expr_store_clear(&empty);
    return ok;
}

static bool read_texts(struct export_model *m, struct sga_error *err)
{
    const struct export_source *s = m->source;
    int symbols = m->store.symbols, first = symbols - s->definitions;
    assert(first == 1 + s->variables + s->parameters);
    expr_id *alias = sga_zeros(&m->memory, (size_t)symbols, sizeof *alias);
    struct expr_grammar g = { .derivative = primed, .ctx = &m->store, .value = alias, .values = symbols };
    const char **constraint = sga_take(&m->memory, (size_t)s->constraints * sizeof *constraint);
    for (int i = 0; i < s->definitions; i++)
        if (!read_text(m, s->definition[i].text, &g, "A definition", &alias[first + i], err))
            return false;
    for (int i = 0; i < s->constraints; i++)
        constraint[i] = s->constraint[i].text;
    return read_list(m, s->constraints, constraint, &g, "A constraint", &m->constraint, err) &&
           read_list(m, s->variables, s->component, &g, "A component of the vector field", &m->component, err) &&
           read_list(m, s->gauges * s->variables, s->gauge, &g, "A gauge field", &m->gauge, err) &&
           read_list(m, s->outputs, s->output, &g, "One of the outputs", &m->output, err);
}

/* Symbols 1 to n are the variables, in their order. */
static void differentiate(struct export_model *m)
{
    int n = m->source->variables, rows = m->source->constraints;
    unsigned char *active = sga_zeros(&m->memory, (size_t)m->store.symbols, 1);
    struct expr_term *term = NULL;
    size_t cap = 0, room = 0;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    memset(active + 1, 1, (size_t)n);
    for (int r = 0; r < rows; r++) {
        int terms = expr_gradient(&m->store, &cone, m->constraint[r], active, &term, &cap);
        for (int k = 0; k < terms; k++) {
            assert(term[k].symbol >= 1 && term[k].symbol <= n);
            SGA_RESERVE_IN(&m->memory, m->entry, room, (size_t)m->entries + 1);
            m->entry[m->entries++] = (struct export_entry){ r, term[k].symbol - 1, term[k].value };
        }
    }
    free(term);
}

bool export_model_read(struct export_model *m, const struct export_source *s, enum export_language l, struct sga_error *err)
{
    *m = (struct export_model){ .source = s, .language = l };
    expr_store_init(&m->store);
    m->store.max_nodes = EXPORT_NODES;
    m->store.seconds = EXPORT_SECONDS;
    m->store.deadline = sga_now() + EXPORT_SECONDS;
    m->symbol = sga_zeros(&m->memory, (size_t)(1 + s->variables + s->parameters + s->definitions), sizeof *m->symbol);
    if (!name_all(m, err) || !read_values(m, err) || !read_texts(m, err))
        return false;
    differentiate(m);
    return expr_store_ok(&m->store) || sga_fail(err, SGA_E_NO_CODE, "The derivatives of the constraints cannot be written: %.500s", m->store.error->detail);
}

void export_model_clear(struct export_model *m)
{
    expr_store_clear(&m->store);
    sga_arena_end(&m->memory);
}
