/* The formulas of each function, in the order of the places that they fill. */
#include "buf.h"
#include "dialect.h"
#include "lines.h"
#include "skeleton.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "error.h"

static struct export_place *places_of(struct sga_arena *mem, const char *array, const expr_id *value, int n)
{
    struct export_place *p = sga_take(mem, (size_t)n * sizeof *p);
    for (int i = 0; i < n; i++)
        p[i] = (struct export_place){ array, i, -1, value[i] };
    return p;
}

bool export_constraint_lines(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    SGA_ARENA(mem);
    int n = m->source->constraints;
    return export_lines(m, places_of(&mem, "c", m->constraint, n), n, out, err);
}

bool export_jacobian_lines(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    SGA_ARENA(mem);
    struct export_place *p = sga_take(&mem, (size_t)m->entries * sizeof *p);
    for (int i = 0; i < m->entries; i++)
        p[i] = (struct export_place){ "J", m->entry[i].row, m->entry[i].column, m->entry[i].value };
    return export_lines(m, p, m->entries, out, err);
}

bool export_gauge_lines(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    SGA_ARENA(mem);
    int n = m->source->gauges * m->source->variables, kept = 0;
    struct export_place *p = places_of(&mem, "G", m->gauge, n);
    for (int i = 0; i < n; i++)
        if (!expr_is_zero(&m->store, p[i].value))
            p[kept++] = (struct export_place){ "G", i / m->source->variables, i % m->source->variables, p[i].value };
    return export_lines(m, p, kept, out, err);
}

static const char *gauge_function(struct export_model *m, int k)
{
    const struct export_dialect *d = export_dialect(m->language);
    char *text = sga_take(&m->memory, 80);
    snprintf(text, 80, d->gauge, k + d->first);
    return text;
}

bool export_field_values(struct export_model *m, expr_id *value, struct sga_error *err)
{
    struct expr_store *st = &m->store;
    int n = m->source->variables;
    const char **symbol = sga_zeros(&m->memory, (size_t)(st->symbols + m->source->gauges), sizeof *symbol);
    memcpy(symbol, m->symbol, (size_t)st->symbols * sizeof *symbol);
    memcpy(value, m->component, (size_t)n * sizeof *value);
    m->symbol = symbol;
    for (int k = 0; k < m->source->gauges; k++) {
        char name[24];
        snprintf(name, sizeof name, "f[%d]", k);  /* no name of the grammar, so nobody else's */
        symbol[st->symbols] = gauge_function(m, k);
        expr_id f = expr_symbol_add(st, name, EXPR_FREE);
        for (int i = 0; i < n; i++)
            value[i] = expr_add(st, value[i], expr_mul(st, f, m->gauge[k * n + i]));
    }
    return expr_store_ok(st) || sga_fail(err, SGA_E_NO_CODE, "The field cannot be written: %.500s", st->error->detail);
}

bool export_field_lines(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    SGA_ARENA(mem);
    int n = m->source->variables;
    expr_id *value = sga_take(&mem, (size_t)n * sizeof *value);
    return export_field_values(m, value, err) && export_lines(m, places_of(&mem, "dx", value, n), n, out, err);
}

bool export_constants(struct export_model *m, const char *pattern, const char *after, struct sga_buf *out, struct sga_error *err)
{
    const struct export_source *s = m->source;
    for (int i = 0; i < s->parameters; i++) {
        if (!s->parameter[i].value)
            continue;
        sga_buf_printf(out, pattern, m->symbol[1 + s->variables + i] + strlen("P_"));     /* the name, as an identifier */
        if (!export_value(m, m->value[i], out, err))
            return false;
        sga_buf_puts(out, after);
    }
    return true;
}

static void put_legend(const struct export_model *m, const char *mark, const char *pattern, const char *array, int k, const char *meaning, struct sga_buf *out)
{
    char place[40];
    snprintf(place, sizeof place, pattern, array, k + export_dialect(m->language)->first);
    sga_buf_printf(out, "%s%s: %s\n", mark, place, meaning);
}

void export_legend(const struct export_model *m, const char *mark, struct sga_buf *out)
{
    const struct export_source *s = m->source;
    const char *list = export_dialect(m->language)->list;
    char text[80];
    for (int i = 0; i < s->variables; i++)
        put_legend(m, mark, list, "x", i, s->variable[i], out);
    for (int i = 0; i < s->constraints; i++) {
        snprintf(text, sizeof text, "a constraint of generation %d", s->constraint[i].generation);
        put_legend(m, mark, list, "c", i, text, out);
    }
    for (int i = 0, k = 0; i < s->parameters; i++)
        if (!s->parameter[i].value)
            put_legend(m, mark, list, "p", k++, s->parameter[i].name, out);
    for (int i = 0; i < s->gauges; i++) {
        snprintf(text, sizeof text, "the function of time that multiplies gauge field %d", i + export_dialect(m->language)->first);
        put_legend(m, mark, list, "f", i, text, out);
    }
}

void export_about(const struct export_model *m, const char *mark, const char *failing, struct sga_buf *out)
{
    int bare = (int)strcspn(mark, " ");            /* no spaces at the ends of lines */
    sga_buf_printf(out, "%sMade by sgad %s from job %s.\n%.*s\n", mark, m->source->version, m->source->job, bare, mark);
    sga_buf_printf(out, "%sThe constraints c(t, x) = 0, their Jacobian, the field dx/dt on them, the gauge fields, and a projection onto them.\n", mark);
    sga_buf_printf(out, "%sWhere a formula has no value %s.\n", mark, failing);
    sga_buf_printf(out, "%sThe answer was found for the values of parameters below; numbers in the formulas may come from them, so another value needs\n"
                        "%sanother job, or the value null, which makes the parameter an argument, p.\n%.*s\n", mark, mark, bare, mark);
}
