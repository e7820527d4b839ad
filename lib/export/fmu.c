/* The C of an FMU: formulas as the language c has them, data of the experiment, and the functions of FMI. */
#include "fmu.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "c_parts.h"
#include "error.h"
#include "fmu_parts.h"
#include "lines.h"
#include "skeleton.h"

static bool jumps(const struct export_model *m)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(&m->store, &cone, m->constraint, m->source->constraints);
    for (int i = 0; i < cone.count; i++)
        if (expr_op_of(&m->store, cone.list[i]) == EXPR_SIGN)
            return true;
    return false;
}

static void add_indicator(struct fmu *f, expr_id e, size_t *room)
{
    for (int i = 0; i < f->indicators; i++)
        if (f->indicator[i] == e)
            return;
    SGA_RESERVE_IN(&f->m.memory, f->indicator, *room, (size_t)f->indicators + 1);
    f->indicator[f->indicators++] = e;
}

/* What changes its sign where a formula takes another branch. */
static void find_indicators(struct fmu *f)
{
    struct expr_store *st = &f->m.store;
    const struct export_source *s = f->m.source;
    int n = s->constraints + s->variables + s->variables * s->gauges + s->outputs, roots = 0;
    size_t room = 0;
    SGA_ARENA(mem);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_id *root = sga_take(&mem, (size_t)n * sizeof *root);
    for (int i = 0; i < s->constraints; i++)
        root[roots++] = f->m.constraint[i];
    for (int i = 0; i < s->variables; i++)
        root[roots++] = f->m.component[i];
    for (int i = 0; i < s->variables * s->gauges; i++)
        root[roots++] = f->m.gauge[i];
    for (int i = 0; i < s->outputs; i++)
        root[roots++] = f->m.output[i];
    expr_cone_init(&cone);
    assert(roots == n);
    expr_cone_of(st, &cone, root, roots);
    for (int i = 0; i < cone.count; i++) {
        expr_id e = cone.list[i];
        enum expr_op op = expr_op_of(st, e);
        if (op == EXPR_ABS || op == EXPR_SIGN)
            add_indicator(f, expr_child(st, e, 0), &room);
        else if (op == EXPR_MIN || op == EXPR_MAX)
            add_indicator(f, expr_sub(st, expr_child(st, e, 0), expr_child(st, e, 1)), &room);
    }
}

static bool put_list(struct export_model *m, const char *head, const char *array, const expr_id *value, int n, struct sga_buf *out, struct sga_error *err)
{
    SGA_ARENA(mem);
    struct export_place *place = sga_take(&mem, (size_t)n * sizeof *place);
    for (int i = 0; i < n; i++)
        place[i] = (struct export_place){ array, i, -1, value[i] };
    sga_buf_printf(out, "%s\n{\n    (void)t; (void)x; (void)p; (void)%s;\n", head, array);
    bool ok = export_lines(m, place, n, out, err);
    sga_buf_puts(out, "}\n\n");
    return ok;
}

static void put_doubles(const char *name, const double *value, int n, struct sga_buf *out)
{
    sga_buf_printf(out, "static const double %s[%d] = {", name, n + 1);
    for (int i = 0; i < n; i++)
        if (value && isnan(value[i]))
            sga_buf_puts(out, " NAN,");
        else
            sga_buf_printf(out, " %.17g,", value ? value[i] : 0.0);
    sga_buf_puts(out, " 0.0 };\n");
}

static void put_head(const struct fmu *f, struct sga_buf *out)
{
    const struct export_source *s = f->m.source;
    sga_buf_printf(out, "/* Made by sgad %s from job %s: a source FMU of FMI 3.0. The headers of the standard are the importer's.\n *\n", s->version, s->job);
    sga_buf_puts(out, " * Where a formula has no value the result is NaN or infinite. Parameters that have values are constants, P_name: the answer was found for\n"
                      " * them, and numbers in the formulas may come from them.\n *\n");
    export_legend(&f->m, " *   ", out);
    sga_buf_puts(out, " */\n#ifndef FMI3_FUNCTION_PREFIX\n#define FMI3_FUNCTION_PREFIX " FMU_MODEL "_\n#endif\n#include \"fmi3Functions.h\"\n\n"
                      "#include <float.h>\n#include <math.h>\n#include <stdlib.h>\n#include <string.h>\n\n");
    sga_buf_printf(out, "#define SGA_VARIABLES %d\n#define SGA_CONSTRAINTS %d\n#define SGA_GAUGE %d\n#define SGA_ARGUMENTS %d\n#define SGA_OUTPUTS %d\n"
                   "#define SGA_INDICATORS %d\n", s->variables, s->constraints, s->gauges, f->m.free_parameters, s->outputs, f->indicators);
    sga_buf_puts(out, "#define SGA_WORK (SGA_CONSTRAINTS*SGA_VARIABLES + SGA_VARIABLES + 2*SGA_CONSTRAINTS)\nenum { N = SGA_VARIABLES };\n\n");
    sga_buf_printf(out, "#define SGA_TOKEN \"%s\"\n#define SGA_START_TIME %.17g\n", f->token, isnan(f->sim->begin) ? 0.0 : f->sim->begin);
    put_doubles("sga_start_x", f->sim->start, s->variables, out);
    put_doubles("sga_start_p", f->sim->argument, f->m.free_parameters, out);
}

static bool put_formulas(struct fmu *f, struct sga_buf *out, struct sga_error *err)
{
    struct export_model *m = &f->m;
    if (!export_constants(m, "#define P_%s (", ")\n", out, err))
        return false;
    sga_buf_puts(out, "\n");
    sga_buf_puts(out, export_c_helpers);
    bool ok = export_c_function(m, "static void sga_constraints(double t, const double *x, const double *p, double *c)", NULL, "c", export_constraint_lines, out, err) &&
              export_c_function(m, "static void sga_jacobian(double t, const double *x, const double *p, double *J)", "SGA_CONSTRAINTS*SGA_VARIABLES", "J",
                                export_jacobian_lines, out, err) &&
              put_list(m, "static void sga_outputs(double t, const double *x, const double *p, double *y)", "y", m->output, m->source->outputs, out, err) &&
              put_list(m, "static void sga_indicators(double t, const double *x, const double *p, double *z)", "z", f->indicator, f->indicators, out, err) &&
              export_c_function(m, "static void sga_field(double t, const double *x, const double *f, const double *p, double *dx)", NULL, "f",
                                export_field_lines, out, err);
    sga_buf_puts(out, "static ");
    sga_buf_puts(out, export_c_projection);
    sga_buf_puts(out, "\n");
    return ok;
}

/* FNV-1a of the texts: another answer is another token. */
static void make_token(struct fmu *f)
{
    struct sga_buf text = { 0 };
    const struct export_source *s = f->m.source;
    uint64_t a = 0xcbf29ce484222325u, b = a ^ 0x5bd1e995u;
    sga_buf_printf(&text, "%s\n%s\n", s->version, s->job);
    for (int i = 0; i < s->variables; i++)
        sga_buf_printf(&text, "%s' = %s\n", s->variable[i], s->component[i]);
    for (int i = 0; i < s->variables * s->gauges; i++)
        sga_buf_printf(&text, "%s\n", s->gauge[i]);
    for (int i = 0; i < s->constraints; i++)
        sga_buf_printf(&text, "%s\n", s->constraint[i].text);
    for (int i = 0; i < s->definitions; i++)
        sga_buf_printf(&text, "%s = %s\n", s->definition[i].name, s->definition[i].text);
    for (int i = 0; i < s->parameters; i++)
        sga_buf_printf(&text, "%s = %s\n", s->parameter[i].name, s->parameter[i].value ? s->parameter[i].value : "");
    for (int i = 0; i < s->outputs; i++)
        sga_buf_printf(&text, "%s\n", s->output[i]);
    for (size_t i = 0; i < text.len; i++) {
        a = (a ^ (unsigned char)text.data[i]) * 0x100000001b3u;
        b = (b ^ (unsigned char)text.data[text.len - 1 - i]) * 0x100000001b3u;
    }
    snprintf(f->token, sizeof f->token, "%016llx%016llx", (unsigned long long)a, (unsigned long long)b);
    sga_buf_free(&text);
}

bool export_fmu(const struct export_source *s, const struct fmu_simulation *sim, struct fmu_file file[FMU_FILES], struct sga_error *err)
{
    static const char *const name[FMU_FILES] = { "modelDescription.xml", "documentation/index.html", "sources/buildDescription.xml", "sources/" FMU_MODEL ".c" };
    struct fmu f = { .sim = sim };
    for (int i = 0; i < FMU_FILES; i++)
        file[i] = (struct fmu_file){ .name = name[i] };
    bool ok = export_model_read(&f.m, s, EXPORT_C, err);
    if (ok && jumps(&f.m))
        ok = sga_fail(err, SGA_E_NO_CODE, "A constraint jumps where a sign changes: how the states go on there is not in the answer, so there is no FMU of it.");
    if (ok) {
        find_indicators(&f);
        make_token(&f);
        put_head(&f, &file[3].text);
        ok = put_formulas(&f, &file[3].text, err);
        sga_buf_puts(&file[3].text, fmu_runtime);
        fmu_description(&f, &file[0].text);
        fmu_page(&f, &file[1].text);
        fmu_build_description(&file[2].text);
    }
    export_model_clear(&f.m);
    return ok;
}
