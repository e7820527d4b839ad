/* A package of Modelica: functions of the formulas, the projection, and a model of the reduced motion. */
#include "buf.h"
#include "skeleton.h"

static bool head(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    const struct export_source *s = m->source;
    sga_buf_puts(out, "// Its formulas were checked as text; this file was not run by a Modelica tool.\n//\n");
    export_about(m, "// ", "the tool stops, or the result is NaN or infinite", out);
    export_legend(m, "//   ", out);
    sga_buf_printf(out, "package SgaModel\n  constant Integer variables = %d;\n  constant Integer constraintCount = %d;\n  constant Integer gauge = %d;\n"
                        "  constant Integer arguments = %d;\n", s->variables, s->constraints, s->gauges, m->free_parameters);
    bool ok = export_constants(m, "  constant Real P_%s = ", ";\n", out, err);
    sga_buf_puts(out, "\n"
                      "  function power\n    input Real a;\n    input Real b;\n    output Real y;\n  algorithm\n"
                      "    assert(a >= 0, \"a real power of a negative number\");\n    y := a^b;\n  end power;\n\n"
                      "  function areaSine\n    input Real a;\n    output Real y;\n  algorithm\n"
                      "    y := sign(a)*(if abs(a) > 1e8 then log(abs(a)) + log(2) else log(abs(a) + sqrt(a*a + 1)));\n  end areaSine;\n\n"
                      "  function areaCosine\n    input Real a;\n    output Real y;\n  algorithm\n"
                      "    y := if a > 1e8 then log(a) + log(2) else log(a + sqrt((a - 1)*(a + 1)));\n  end areaCosine;\n\n"
                      "  function areaTangent\n    input Real a;\n    output Real y;\n  algorithm\n    y := 0.5*log((1 + a)/(1 - a));\n  end areaTangent;\n\n"
                      "  function cubeRoot\n    input Real a;\n    output Real y;\n  algorithm\n    y := sign(a)*abs(a)^(1/3);\n  end cubeRoot;\n\n");
    return ok;
}

static const struct shape {
    const char *name, *inputs, *output, *array;
    const char *zeros;        /* rows of a matrix whose zeros no line fills */
    bool (*lines)(struct export_model *, struct sga_buf *, struct sga_error *);
} functions[] = {
    { "constraints", "", "c[constraintCount]", "c", NULL, export_constraint_lines },
    { "jacobian", "", "J[constraintCount, variables]", "J", "constraintCount", export_jacobian_lines },
    { "gaugeFields", "", "G[gauge, variables]", "G", "gauge", export_gauge_lines },
    { "field", "    input Real f[gauge];\n", "dx[variables]", "dx", NULL, export_field_lines },
};

/* The shared parts are declared before the statements, so the statements are written first. */
static bool function(struct export_model *m, const struct shape *f, struct sga_buf *out, struct sga_error *err)
{
    struct sga_buf statements = { 0 };
    bool ok = f->lines(m, &statements, err);
    sga_buf_printf(out, "  function %s\n    input Real t;\n    input Real x[variables];\n%s    input Real p[arguments];\n    output Real %s;\n",
                   f->name, f->inputs, f->output);
    if (m->parts)
        sga_buf_printf(out, "  protected\n    Real w[%d];\n", m->parts);
    sga_buf_puts(out, "  algorithm\n");
    if (f->zeros)
        sga_buf_printf(out, "    %s := zeros(%s, variables);\n", f->array, f->zeros);
    if (ok && statements.len)
        sga_buf_put(out, statements.data, statements.len);
    sga_buf_printf(out, "  end %s;\n\n", f->name);
    sga_buf_free(&statements);
    return ok;
}

/* The same steps as in C (c.c). */
static const char projection[] =
    "  function project \"The point of the constraints that Gauss-Newton steps of least length lead to\"\n"
    "    input Real t;\n    input Real start[variables];\n    input Real p[arguments];\n    input Real tolerance = 1e-13;\n    output Real x[variables];\n"
    "  protected\n    Real q[constraintCount, variables];\n    Real c[constraintCount];\n    Real z[constraintCount];\n    Real step[variables];\n"
    "    Real l;\n    Boolean done;\n"
    "  algorithm\n"
    "    x := start;\n    done := constraintCount == 0;\n"
    "    for count in 1:50 loop\n"
    "      if not done then\n"
    "        c := constraints(t, x, p);\n        q := jacobian(t, x, p);\n        step := zeros(variables);\n"
    "        for i in 1:constraintCount loop\n"
    "          z[i] := c[i];\n"
    "          for again in 1:2 loop\n"
    "            for j in 1:i - 1 loop\n"
    "              l := q[i, :]*q[j, :];\n              q[i, :] := q[i, :] - l*q[j, :];\n              z[i] := z[i] - l*z[j];\n"
    "            end for;\n"
    "          end for;\n"
    "          l := sqrt(q[i, :]*q[i, :]);\n"
    "          assert(l > 0, \"the constraints depend on each other here\");\n"
    "          z[i] := z[i]/l;\n          q[i, :] := q[i, :]/l;\n          step := step + z[i]*q[i, :];\n"
    "        end for;\n"
    "        x := x - step;\n"
    "        done := sqrt(step*step) <= tolerance*(1 + sqrt(x*x));\n"
    "      end if;\n"
    "    end for;\n"
    "    assert(done, \"no point of the constraints was found from there\");\n"
    "  end project;\n\n";

static const char model[] =
    "  model Motion \"The reduced motion from a start that is brought onto the constraints\"\n"
    "    parameter Real start[variables] = zeros(variables);\n    parameter Real p[arguments] = zeros(arguments);\n    Real x[variables];\n    Real f[gauge] = zeros(gauge) \"gauge functions\";\n"
    "  initial equation\n    x = project(time, start, p);\n"
    "  equation\n    der(x) = field(time, x, f, p);\n  end Motion;\nend SgaModel;\n";

bool export_modelica(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    if (!head(m, out, err))
        return false;
    for (size_t i = 0; i < sizeof functions / sizeof *functions; i++)
        if (!function(m, &functions[i], out, err))
            return false;
    sga_buf_puts(out, projection);
    sga_buf_puts(out, model);
    return true;
}
