/* LaTeX and MathML: groups of equations, a row each, as a book would set them. The projection is for programs and is left out. */
#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "buf.h"
#include "lines.h"
#include "skeleton.h"

/* Patterns: of the file and its groups, and of the left sides. */
struct marks {
    const char *before, *legend, *title, *group, *row_end, *after;
    const char *constraint, *slope, *rate, *gauge;
};

static const struct marks latex = {
    "", "%% %s: %s\n", "\n%s:\n\\begin{align*}\n", "\\end{align*}\n", " \\\\\n", "",
    "\\mathcal{C}_{%d}", "\\frac{\\partial \\mathcal{C}_{%d}}{\\partial %s}", "\\frac{\\mathrm{d} %s}{\\mathrm{d} %s}", "\\mathcal{G}_{%d, %s}",
};
static const struct marks mathml = {
    "<!--\n", "  %s: %s\n", "<mtr><mtd columnspan=\"3\"><mtext>%s</mtext></mtd></mtr>\n", "", "", "</mtable></math>\n",
    "<msub><mi mathvariant=\"script\">C</mi><mn>%d</mn></msub>",
    "<mfrac><mrow><mo>&#x2202;</mo><msub><mi mathvariant=\"script\">C</mi><mn>%d</mn></msub></mrow><mrow><mo>&#x2202;</mo>%s</mrow></mfrac>",
    "<mfrac><mrow><mi mathvariant=\"normal\">d</mi>%s</mrow><mrow><mi mathvariant=\"normal\">d</mi>%s</mrow></mfrac>",
    "<msub><mi mathvariant=\"script\">G</mi><mrow><mn>%d</mn><mo>,</mo>%s</mrow></msub>",
};

struct page {
    struct export_model *m;
    const struct marks *marks;
    struct sga_arena mem;
    struct sga_buf *out;
    struct sga_error *err;
};

static char *keep(struct page *p, struct sga_buf *b)
{
    char *text = memcpy(sga_take(&p->mem, b->len + 1), b->data, b->len + 1);
    sga_buf_free(b);
    return text;
}

/* Symbols by variable and by parameter (name_all of model.c puts time first). */
static const char *variable(const struct page *p, int i) { return p->m->symbol[1 + i]; }
static const char *parameter(const struct page *p, int i) { return p->m->symbol[1 + p->m->source->variables + i]; }

/* The left side of constraint (or gauge field) i by a variable. */
static const char *numbered(struct page *p, const char *pattern, int i, int by)
{
    struct sga_buf b = { 0 };
    sga_buf_printf(&b, pattern, i + 1, variable(p, by));
    return keep(p, &b);
}

static const char *rate(struct page *p, int i)
{
    struct sga_buf b = { 0 };
    sga_buf_printf(&b, p->marks->rate, variable(p, i), p->m->symbol[0]);
    return keep(p, &b);
}

static bool group(struct page *p, const char *title, const struct export_place *place, int places)
{
    if (!places)
        return true;
    size_t end = strlen(p->marks->row_end);
    sga_buf_printf(p->out, p->marks->title, title);
    bool ok = export_lines(p->m, place, places, p->out, p->err);
    if (ok && end) {                      /* the last row ends by itself */
        assert(p->out->len >= end && memcmp(p->out->data + p->out->len - end, p->marks->row_end, end) == 0);
        p->out->len -= end;
        sga_buf_puts(p->out, "\n");
    }
    sga_buf_puts(p->out, p->marks->group);
    return ok;
}

static bool put_parameters(struct page *p)
{
    const struct export_source *s = p->m->source;
    int places = 0;
    struct export_place *place = sga_take(&p->mem, (size_t)s->parameters * sizeof *place);
    for (int i = 0; i < s->parameters; i++)
        if (s->parameter[i].value)
            place[places++] = (struct export_place){ parameter(p, i), 0, -1, p->m->value[i] };
    return group(p, "Parameters, whose values may stand in the formulas", place, places);
}

static bool put_constraints(struct page *p)
{
    const struct export_source *s = p->m->source;
    struct export_place *place = sga_take(&p->mem, (size_t)s->constraints * sizeof *place);
    bool ok = true;
    for (int i = 0; i < s->constraints; i++)
        place[i] = (struct export_place){ numbered(p, p->marks->constraint, i, 0), 0, -1, p->m->constraint[i] };
    for (int from = 0, to; from < s->constraints && ok; from = to) {
        char title[64];
        for (to = from; to < s->constraints && s->constraint[to].generation == s->constraint[from].generation; to++)
            ;
        snprintf(title, sizeof title, "Constraints of generation %d, each of them 0", s->constraint[from].generation);
        ok = group(p, title, place + from, to - from);
    }
    return ok;
}

static bool put_jacobian(struct page *p)
{
    struct export_place *place = sga_take(&p->mem, (size_t)p->m->entries * sizeof *place);
    for (int i = 0; i < p->m->entries; i++) {
        const struct export_entry *e = &p->m->entry[i];
        place[i] = (struct export_place){ numbered(p, p->marks->slope, e->row, e->column), 0, -1, e->value };
    }
    return group(p, "Derivatives of the constraints, where they are not 0", place, p->m->entries);
}

static bool put_gauge(struct page *p)
{
    int n = p->m->source->variables, places = 0;
    struct export_place *place = sga_take(&p->mem, (size_t)(n * p->m->source->gauges) * sizeof *place);
    for (int i = 0; i < n * p->m->source->gauges; i++)
        if (!expr_is_zero(&p->m->store, p->m->gauge[i]))
            place[places++] = (struct export_place){ numbered(p, p->marks->gauge, i / n, i % n), 0, -1, p->m->gauge[i] };
    return group(p, "Gauge fields, where they are not 0", place, places);
}

static bool put_field(struct page *p)
{
    int n = p->m->source->variables;
    expr_id *value = sga_take(&p->mem, (size_t)n * sizeof *value);
    struct export_place *place = sga_take(&p->mem, (size_t)n * sizeof *place);
    bool ok = export_field_values(p->m, value, p->err);
    for (int i = 0; i < n && ok; i++)
        place[i] = (struct export_place){ rate(p, i), 0, -1, value[i] };
    return ok && group(p, p->m->source->gauges ? "Vector field, with functions of time that are free" : "Vector field", place, n);
}

static void put_head(struct page *p)
{
    const struct export_source *s = p->m->source;
    const char *mark = *p->marks->before ? "" : "% ";
    sga_buf_printf(p->out, "%s%sMade by sgad %s from job %s.\n%sThe names and what they stand for:\n", p->marks->before, mark, s->version, s->job, mark);
    sga_buf_printf(p->out, p->marks->legend, p->m->symbol[0], s->time);
    for (int i = 0; i < s->variables; i++)
        sga_buf_printf(p->out, p->marks->legend, variable(p, i), s->variable[i]);
    for (int i = 0; i < s->parameters; i++)
        sga_buf_printf(p->out, p->marks->legend, parameter(p, i), s->parameter[i].name);
    if (p->marks == &mathml)
        sga_buf_puts(p->out, "-->\n<math xmlns=\"http://www.w3.org/1998/Math/MathML\" display=\"block\"><mtable columnalign=\"right center left\">\n");
    else
        sga_buf_puts(p->out, "% To be set with the package amsmath.\n");
}

static bool print(struct export_model *m, const struct marks *marks, struct sga_buf *out, struct sga_error *err)
{
    struct page p = { .m = m, .marks = marks, .out = out, .err = err };
    put_head(&p);
    bool ok = put_parameters(&p) && put_constraints(&p) && put_field(&p) && put_gauge(&p) && put_jacobian(&p);
    sga_buf_puts(out, marks->after);
    sga_arena_end(&p.mem);
    return ok;
}

bool export_latex(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    return print(m, &latex, out, err);
}

bool export_mathml(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    return print(m, &mathml, out, err);
}
