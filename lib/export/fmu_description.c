/* modelDescription.xml, buildDescription.xml and a page about them. Elements stand in the order of the schema; value references as
 * fmu_instance.c.in counts them. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "fmu_parts.h"

static const char xml[] = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

static void escape(const char *text, struct sga_buf *out)
{
    for (; *text; text++)
        switch (*text) {
        case '&': sga_buf_puts(out, "&amp;"); break;
        case '<': sga_buf_puts(out, "&lt;"); break;
        case '>': sga_buf_puts(out, "&gt;"); break;
        case '"': sga_buf_puts(out, "&quot;"); break;
        default: sga_buf_put(out, (unsigned char)*text < 0x20 ? " " : text, 1);
        }
}

static void number(const char *attribute, double v, struct sga_buf *out)
{
    char text[32];
    if (isnan(v))
        strcpy(text, "NaN");
    else
        sga_format_double(text, v);
    sga_buf_printf(out, " %s=\"%s\"", attribute, text);
}

/* One variable, left open for more attributes. */
static void variable(int reference, const char *before, const char *name, const char *after, const char *more, struct sga_buf *out)
{
    sga_buf_printf(out, "    <Float64 name=\"%s", before);
    escape(name, out);
    sga_buf_printf(out, "%s\" valueReference=\"%d\" %s", after, reference, more);
}

static void end(struct sga_buf *out)
{
    sga_buf_puts(out, "/>\n");
}

static void put_variables(const struct fmu *f, struct sga_buf *out)
{
    const struct export_source *s = f->m.source;
    int n = s->variables, r = 0;
    variable(r++, "", s->time, "", "causality=\"independent\" variability=\"continuous\"", out), end(out);
    for (int i = 0; i < n; i++) {
        variable(r++, "", s->variable[i], "", s->constraints ? "causality=\"output\" variability=\"continuous\" initial=\"approx\""
                 : "causality=\"output\" variability=\"continuous\" initial=\"exact\"", out);
        number("start", f->sim->start ? f->sim->start[i] : 0.0, out);
        end(out);
    }
    for (int i = 0; i < n; i++) {
        variable(r++, "der(", s->variable[i], ")", "causality=\"local\" variability=\"continuous\" initial=\"calculated\"", out);
        sga_buf_printf(out, " derivative=\"%d\"/>\n", 1 + i);
    }
    for (int i = 0; i < s->gauges; i++)
        variable(r++, "", f->sim->input[i], "", "causality=\"input\" variability=\"continuous\" start=\"0\"", out), end(out);
    for (int i = 0, k = 0; i < s->parameters; i++) {
        if (s->parameter[i].value)
            continue;
        variable(r++, "", s->parameter[i].name, "", "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"", out);
        number("start", f->sim->argument[k++], out);
        end(out);
    }
    for (int i = 0; i < s->outputs; i++)
        variable(r++, "", s->output[i], "", "causality=\"output\" variability=\"continuous\" initial=\"calculated\"", out), end(out);
    for (int i = 0; i < f->indicators; i++)
        sga_buf_printf(out, "    <Float64 name=\"indicator(%d)\" valueReference=\"%d\" causality=\"local\" variability=\"continuous\" initial=\"calculated\"/>\n", i + 1, r++);
    assert(r == 1 + 2 * n + s->gauges + f->m.free_parameters + s->outputs + f->indicators);     /* as put_structure counts them */
}

static void put_unknowns(const char *element, int first, int count, struct sga_buf *out)
{
    for (int i = 0; i < count; i++)
        sga_buf_printf(out, "    <%s valueReference=\"%d\"/>\n", element, first + i);
}

static void put_structure(const struct fmu *f, struct sga_buf *out)
{
    const struct export_source *s = f->m.source;
    int n = s->variables, output = 1 + 2 * n + s->gauges + f->m.free_parameters;
    put_unknowns("Output", 1, n, out);
    put_unknowns("Output", output, s->outputs, out);
    put_unknowns("ContinuousStateDerivative", 1 + n, n, out);
    put_unknowns("InitialUnknown", 1, s->constraints ? n : 0, out);
    put_unknowns("InitialUnknown", 1 + n, n, out);
    put_unknowns("InitialUnknown", output, s->outputs, out);
    put_unknowns("EventIndicator", output + s->outputs, f->indicators, out);
}

void fmu_description(const struct fmu *f, struct sga_buf *out)
{
    const struct export_source *s = f->m.source;
    const struct fmu_simulation *sim = f->sim;
    sga_buf_puts(out, xml);
    sga_buf_printf(out, "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"" FMU_MODEL "\" instantiationToken=\"%s\" generationTool=\"sgad %s\"\n"
                   "    description=\"The reduced field of the job %s on its constraints\" variableNamingConvention=\"flat\">\n", f->token, s->version, s->job);
    sga_buf_puts(out, "  <ModelExchange modelIdentifier=\"" FMU_MODEL "\" canGetAndSetFMUState=\"true\" needsCompletedIntegratorStep=\"true\"/>\n"
                      "  <CoSimulation modelIdentifier=\"" FMU_MODEL "\" canGetAndSetFMUState=\"true\" canHandleVariableCommunicationStepSize=\"true\"/>\n"
                      "  <LogCategories>\n    <Category name=\"logStatusError\" description=\"Why a call was refused or failed\"/>\n  </LogCategories>\n"
                      "  <DefaultExperiment");
    number("startTime", isnan(sim->begin) ? 0.0 : sim->begin, out);
    if (!isnan(sim->stop))
        number("stopTime", sim->stop, out);
    if (!isnan(sim->tolerance))
        number("tolerance", sim->tolerance, out);
    sga_buf_puts(out, "/>\n  <ModelVariables>\n");
    put_variables(f, out);
    sga_buf_puts(out, "  </ModelVariables>\n  <ModelStructure>\n");
    put_structure(f, out);
    sga_buf_puts(out, "  </ModelStructure>\n</fmiModelDescription>\n");
}

void fmu_build_description(struct sga_buf *out)
{
    sga_buf_puts(out, xml);
    sga_buf_puts(out, "<fmiBuildDescription fmiVersion=\"3.0\">\n  <BuildConfiguration modelIdentifier=\"" FMU_MODEL "\">\n    <SourceFileSet language=\"C99\">\n"
                      "      <SourceFile name=\"" FMU_MODEL ".c\"/>\n    </SourceFileSet>\n    <Library name=\"m\"/>\n  </BuildConfiguration>\n</fmiBuildDescription>\n");
}

/* name: NULL, or what the text is the value of. */
static void put_item(const char *name, const char *text, struct sga_buf *out)
{
    sga_buf_puts(out, "<li>");
    if (name) {
        escape(name, out);
        sga_buf_puts(out, " = ");
    }
    escape(text, out);
    sga_buf_puts(out, "</li>\n");
}

void fmu_page(const struct fmu *f, struct sga_buf *out)
{
    const struct export_source *s = f->m.source;
    sga_buf_puts(out, "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>" FMU_MODEL "</title></head>\n<body>\n<h1>" FMU_MODEL "</h1>\n");
    sga_buf_printf(out, "<p>Made by sgad %s from job %s.</p>\n", s->version, s->job);
    sga_buf_puts(out, "<p>All variables are continuous states; the constraints hold between them. Their start is projected onto the constraints when the "
                      "initialization ends. In Model Exchange, steps that drift off the constraints by more than the tolerance are answered by a request for "
                      "Event Mode, where the states are projected. In Co-Simulation an explicit integrator of order 5 projects after each step; stiff systems "
                      "are for Model Exchange. Inputs are the functions that the equations leave free; they are 0 unless set. Parameters without a start value "
                      "must be set.</p>\n<h2>Constraints, each of them 0</h2>\n<ul>\n");
    for (int i = 0; i < s->constraints; i++)
        put_item(NULL, s->constraint[i].text, out);
    sga_buf_puts(out, "</ul>\n<h2>Field</h2>\n<ul>\n");
    for (int i = 0; i < s->variables; i++) {
        sga_buf_puts(out, "<li>d ");
        escape(s->variable[i], out);
        sga_buf_puts(out, " = ");
        escape(s->component[i], out);
        for (int k = 0; k < s->gauges; k++) {
            if (strcmp(s->gauge[k * s->variables + i], "0") == 0)
                continue;
            sga_buf_puts(out, " + ");
            escape(f->sim->input[k], out);
            sga_buf_puts(out, " * (");
            escape(s->gauge[k * s->variables + i], out);
            sga_buf_puts(out, ")");
        }
        sga_buf_puts(out, "</li>\n");
    }
    sga_buf_puts(out, "</ul>\n<h2>Names that stand for expressions, and parameters with values</h2>\n<ul>\n");
    for (int i = 0; i < s->definitions; i++)
        put_item(s->definition[i].name, s->definition[i].text, out);
    for (int i = 0; i < s->parameters; i++)
        if (s->parameter[i].value)
            put_item(s->parameter[i].name, s->parameter[i].value, out);
    sga_buf_puts(out, "</ul>\n</body>\n</html>\n");
}
