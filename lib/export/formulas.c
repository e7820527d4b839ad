/* The formulas of each function, in the order of the places that they fill. */
#include "lines.h"
#include "skeleton.h"

#include <stdio.h>

static struct export_place *places_of(struct sga_arena *mem, const char *array, const expr_id *value, int n)
{
    struct export_place *p = sga_take(mem, (size_t)n * sizeof *p);
    for (int i = 0; i < n; i++)
        p[i] = (struct export_place){ array, i, value[i] };
    return p;
}

bool export_constraint_lines(struct export_model *m, enum export_language l, struct sga_buf *out, struct sga_error *err)
{
    SGA_ARENA(mem);
    int n = m->source->constraints;
    return export_lines(m, l, places_of(&mem, "c", m->constraint, n), n, out, err);
}

bool export_jacobian_lines(struct export_model *m, enum export_language l, struct sga_buf *out, struct sga_error *err)
{
    SGA_ARENA(mem);
    struct export_place *p = sga_take(&mem, (size_t)m->entries * sizeof *p);
    for (int i = 0; i < m->entries; i++)
        p[i] = (struct export_place){ "J", m->entry[i].row * m->source->variables + m->entry[i].column, m->entry[i].value };
    return export_lines(m, l, p, m->entries, out, err);
}

bool export_gauge_lines(struct export_model *m, enum export_language l, struct sga_buf *out, struct sga_error *err)
{
    SGA_ARENA(mem);
    int n = m->source->gauges * m->source->variables, kept = 0;
    struct export_place *p = places_of(&mem, "G", m->gauge, n);
    for (int i = 0; i < n; i++)
        if (!expr_is_zero(&m->store, p[i].value))
            p[kept++] = p[i];
    return export_lines(m, l, p, kept, out, err);
}

/* The gauge functions are symbols of the store from here on. */
bool export_field_lines(struct export_model *m, enum export_language l, struct sga_buf *out, struct sga_error *err)
{
    SGA_ARENA(mem);
    struct expr_store *st = &m->store;
    int n = m->source->variables;
    struct export_place *p = places_of(&mem, "dx", m->component, n);
    const char **symbol = sga_zeros(&m->memory, (size_t)(st->symbols + m->source->gauges), sizeof *symbol);
    for (int i = 0; i < st->symbols; i++)
        symbol[i] = m->symbol[i];
    m->symbol = symbol;
    for (int k = 0; k < m->source->gauges; k++) {
        char *name = sga_take(&m->memory, 24);
        snprintf(name, 24, "f[%d]", k);           /* no name of the grammar, so nobody else's */
        int place = st->symbols;
        expr_id f = expr_symbol_add(st, name, EXPR_FREE);
        symbol[place] = name;
        for (int i = 0; i < n; i++)
            p[i].value = expr_add(st, p[i].value, expr_mul(st, f, m->gauge[k * n + i]));
    }
    if (!expr_store_ok(st))
        return sga_fail(err, SGA_E_NO_CODE, "The field cannot be written: %.500s", st->error.detail);
    return export_lines(m, l, p, n, out, err);
}

void export_legend(const struct export_model *m, const char *mark, struct sga_buf *out)
{
    const struct export_source *s = m->source;
    for (int i = 0; i < s->variables; i++)
        sga_buf_printf(out, "%sx[%d]: %s\n", mark, i, s->variable[i]);
    for (int i = 0; i < s->constraints; i++)
        sga_buf_printf(out, "%sc[%d]: a constraint of generation %d\n", mark, i, s->constraint[i].generation);
    for (int i = 0, k = 0; i < s->parameters; i++)
        if (!s->parameter[i].value)
            sga_buf_printf(out, "%sp[%d]: %s\n", mark, k++, s->parameter[i].name);
    for (int i = 0; i < s->gauges; i++)
        sga_buf_printf(out, "%sf[%d]: the function of time that multiplies gauge field %d\n", mark, i, i);
}
