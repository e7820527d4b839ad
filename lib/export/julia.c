/* A module of Julia; element types follow the arguments, so that derivatives can be taken through it. */
#include "buf.h"
#include "skeleton.h"

static bool head(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    const struct export_source *s = m->source;
    sga_buf_puts(out, "# Its formulas were checked as text; this file was not run by Julia.\n#\n");
    export_about(m, "# ", "Julia throws DomainError, or the result is NaN or infinite", out);
    export_legend(m, "#   ", out);
    sga_buf_puts(out, "module SgaModel\n\nusing LinearAlgebra\n\nexport constraints, jacobian, gauge_fields, field, project\n\nconst VARIABLES = String[");
    for (int i = 0; i < s->variables; i++)
        sga_buf_printf(out, "%s\"%s\"", i ? ", " : "", s->variable[i]);
    sga_buf_puts(out, "]\nconst GENERATIONS = Int[");
    for (int i = 0; i < s->constraints; i++)
        sga_buf_printf(out, "%s%d", i ? ", " : "", s->constraint[i].generation);
    sga_buf_printf(out, "]\nconst GAUGE = %d\n", s->gauges);
    bool ok = export_constants(m, "const P_%s = ", "\n", out, err);
    sga_buf_puts(out, "\n_power(a, b) = a < 0 ? throw(DomainError(a, \"a real power of a negative number\")) : a^b\n"
                      "_type(t, lists...) = promote_type(Float64, typeof(t), map(eltype, lists)...)\n\n");
    return ok;
}

static const struct shape {
    const char *meaning, *signature, *array, *lists;
    bool grid;
    bool (*lines)(struct export_model *, struct sga_buf *, struct sga_error *);
} functions[] = {
    { "The constraints, which vanish on the final set.", "constraints(t, x, p=Float64[])", "c", "x, p", false, export_constraint_lines },
    { "A row for each constraint, its derivatives by the variables.", "jacobian(t, x, p=Float64[])", "J", "x, p", true, export_jacobian_lines },
    { "A row for each gauge field.", "gauge_fields(t, x, p=Float64[])", "G", "x, p", true, export_gauge_lines },
    { "dx/dt, with the values of the gauge functions.", "field(t, x, f=zeros(GAUGE), p=Float64[])", "dx", "x, f, p", false, export_field_lines },
};

static bool function(struct export_model *m, int k, struct sga_buf *out, struct sga_error *err)
{
    const struct export_source *s = m->source;
    const struct shape *f = &functions[k];
    const int rows[] = { s->constraints, s->constraints, s->gauges, s->variables };
    _Static_assert(sizeof rows / sizeof *rows == sizeof functions / sizeof *functions, "rows of each function");
    sga_buf_printf(out, "\"%s\"\nfunction %s\n    %s = zeros(_type(t, %s), %d", f->meaning, f->signature, f->array, f->lists, rows[k]);
    if (f->grid)
        sga_buf_printf(out, ", %d", s->variables);
    sga_buf_puts(out, ")\n");
    bool ok = f->lines(m, out, err);
    sga_buf_printf(out, "    return %s\nend\n\n", f->array);
    return ok;
}

static const char projection[] =
    "\"The point of the constraints that Gauss-Newton steps of least length lead to; an error where they do not converge.\"\n"
    "function project(t, x, p=Float64[]; tolerance=1e-13)\n"
    "    y = collect(float.(x))\n"
    "    for _ in 1:50\n"
    "        c = constraints(t, y, p)\n"
    "        isempty(c) && return y\n"
    "        J = jacobian(t, y, p)\n"
    "        scale = [norm(J[i, :]) for i in 1:size(J, 1)]\n"
    "        F = qr(Matrix((J ./ scale)'))\n"
    "        (size(J, 1) <= size(J, 2) && minimum(abs.(diag(F.R))) > 1e-13) || error(\"the constraints depend on each other here\")\n"
    "        step = Matrix(F.Q) * (F.R' \\ (c ./ scale))\n"
    "        y -= step\n"
    "        norm(step) <= tolerance*(1 + norm(y)) && return y\n"
    "    end\n"
    "    error(\"no point of the constraints was found from there\")\n"
    "end\n\nend\n";

bool export_julia(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    if (!head(m, out, err))
        return false;
    for (int k = 0; k < (int)(sizeof functions / sizeof *functions); k++)
        if (!function(m, k, out, err))
            return false;
    sga_buf_puts(out, projection);
    return true;
}
