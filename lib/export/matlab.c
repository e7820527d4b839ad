/* One file for MATLAB and Octave: its function gives handles of the others, so that it can be saved under any name. */
#include "buf.h"
#include "skeleton.h"

static void put_names(const char *member, struct sga_buf *out, const struct export_source *s, bool arguments)
{
    sga_buf_printf(out, "  m.%s = {", member);
    for (int i = 0, k = 0; i < (arguments ? s->parameters : s->variables); i++)
        if (!arguments || !s->parameter[i].value) {
            const char *name = arguments ? s->parameter[i].name : s->variable[i];
            sga_buf_puts(out, k++ ? ", '" : "'");
            for (; *name; name++)
                sga_buf_printf(out, *name == '\'' ? "''" : "%c", *name);
            sga_buf_puts(out, "'");
        }
    sga_buf_puts(out, "};\n");
}

static bool head(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    const struct export_source *s = m->source;
    sga_buf_puts(out, "function m = sga_model()\n");
    export_about(m, "% ", "the result is NaN or infinite", out);
    export_legend(m, "%   ", out);
    sga_buf_puts(out, "%\n% m.constraints(t, x, p), m.jacobian(t, x, p), m.gauge_fields(t, x, p), m.field(t, x, f, p), m.project(t, x, p); columns, p and f\n"
                      "% may be left out where there are none. m.variables and m.arguments are the names, m.generations those of the constraints.\n");
    put_names("variables", out, s, false);
    put_names("arguments", out, s, true);
    sga_buf_puts(out, "  m.generations = [");
    for (int i = 0; i < s->constraints; i++)
        sga_buf_printf(out, "%s%d", i ? ", " : "", s->constraint[i].generation);
    sga_buf_printf(out, "];\n  m.gauge = %d;\n", s->gauges);
    sga_buf_puts(out, "  m.constraints = @constraints;\n  m.jacobian = @jacobian;\n  m.gauge_fields = @gauge_fields;\n  m.field = @field;\n"
                      "  m.project = @project;\nend\n\nfunction P = parameters()\n  P = [\n");
    bool ok = export_constants(m, "    ", "\n", out, err);
    sga_buf_puts(out, "  ];\nend\n\n");
    return ok;
}

static const struct shape {
    const char *signature, *array, *size;
    bool (*lines)(struct export_model *, struct sga_buf *, struct sga_error *);
} functions[] = {
    { "c = constraints(t, x, p)", "c", "zeros(%d, 1)", export_constraint_lines },
    { "J = jacobian(t, x, p)", "J", "zeros(%d, %d)", export_jacobian_lines },
    { "G = gauge_fields(t, x, p)", "G", "zeros(%d, %d)", export_gauge_lines },
    { "dx = field(t, x, f, p)", "dx", "zeros(%d, 1)", export_field_lines },
};

static bool function(struct export_model *m, int k, struct sga_buf *out, struct sga_error *err)
{
    const struct export_source *s = m->source;
    const struct shape *f = &functions[k];
    const int rows[] = { s->constraints, s->constraints, s->gauges, s->variables };
    sga_buf_printf(out, "function %s\n  P = parameters();\n  %s = ", f->signature, f->array);
    sga_buf_printf(out, f->size, rows[k], s->variables);
    sga_buf_puts(out, ";\n");
    bool ok = f->lines(m, out, err);
    sga_buf_puts(out, "end\n\n");
    return ok;
}

/* Where MATLAB goes on in the complex plane, or passes over NaN, the helpers do not. */
static const char rest[] =
    "function x = project(t, x, p, tolerance)\n"
    "% The point of the constraints that Gauss-Newton steps of least length lead to; an error where they do not converge.\n"
    "  if nargin < 3, p = []; end\n"
    "  if nargin < 4, tolerance = 1e-13; end\n"
    "  x = x(:);\n"
    "  for count = 1:50\n"
    "    c = constraints(t, x, p);\n"
    "    if isempty(c), return; end\n"
    "    J = jacobian(t, x, p);\n"
    "    if ~all(isfinite(c)) || ~all(isfinite(J(:))), error('sga:project', 'the constraints have no value here'); end\n"
    "    if size(J, 1) > size(J, 2), error('sga:project', 'the constraints depend on each other here'); end\n"
    "    size_of = sqrt(sum(J.^2, 2));\n"
    "    if any(size_of == 0), error('sga:project', 'the constraints depend on each other here'); end\n"
    "    J = J./repmat(size_of, 1, size(J, 2));\n"
    "    [Q, R] = qr(J', 0);\n"
    "    if min(abs(diag(R))) <= 1e-13, error('sga:project', 'the constraints depend on each other here'); end\n"
    "    step = Q*(R'\\(c./size_of));\n"
    "    x = x - step;\n"
    "    if norm(step) <= tolerance*(1 + norm(x)), return; end\n"
    "  end\n"
    "  error('sga:project', 'no point of the constraints was found from there');\n"
    "end\n\n"
    "function y = real_(y)\n  if ~isreal(y), y = NaN; end\nend\n\n"
    "function y = asin_(a)\n  y = real_(asin(a));\nend\n\n"
    "function y = acos_(a)\n  y = real_(acos(a));\nend\n\n"
    "function y = acosh_(a)\n  y = real_(acosh(a));\nend\n\n"
    "function y = atanh_(a)\n  y = real_(atanh(a));\nend\n\n"
    "function y = log_(a)\n  y = real_(log(a));\nend\n\n"
    "function y = sqrt_(a)\n  y = real_(sqrt(a));\nend\n\n"
    "function y = cbrt_(a)\n"
    "  y = sign(a)*abs(a)^(1/3);\n"
    "  if y ~= 0 && isfinite(y), y = y - (y - a/(y*y))/3; end\n"
    "end\n\n"
    "function y = power_(a, b)\n  if a < 0, y = NaN; else, y = a^b; end\nend\n\n"
    "function y = least_(a, b)\n  if a < b, y = a; elseif b <= a, y = b; else, y = a + b; end\nend\n\n"
    "function y = greatest_(a, b)\n  if a > b, y = a; elseif b >= a, y = b; else, y = a + b; end\nend\n";

bool export_matlab(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    if (!head(m, out, err))
        return false;
    for (int k = 0; k < (int)(sizeof functions / sizeof *functions); k++)
        if (!function(m, k, out, err))
            return false;
    sga_buf_puts(out, rest);
    return true;
}
