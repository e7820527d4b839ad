/* C99: macros for sizes and parameters, functions without memory of their own, so that it can go into a controller. */
#include "buf.h"
#include "c_parts.h"
#include "skeleton.h"

static void head(const struct export_model *m, struct sga_buf *out)
{
    const struct export_source *s = m->source;
    sga_buf_printf(out, "/* Made by sgad %s from job %s.\n *\n", s->version, s->job);
    sga_buf_puts(out, " * The constraints c(t, x) = 0, their Jacobian, the field dx/dt on them, the gauge fields, and a projection onto them.\n"
                      " * Where a formula has no value (outside of the domain of a function, a division by 0) the result is NaN or infinite.\n"
                      " * The answer was found for the values of parameters below; numbers in the formulas may come from them, so another value needs\n"
                      " * another job, or the value null, which makes the parameter an argument, p.\n *\n");
    export_legend(m, " *   ", out);
    sga_buf_printf(out, " */\n#include <math.h>\n\n#define SGA_VARIABLES %d\n#define SGA_CONSTRAINTS %d\n#define SGA_GAUGE %d\n#define SGA_ARGUMENTS %d\n",
                   s->variables, s->constraints, s->gauges, m->free_parameters);
    sga_buf_puts(out, "/* Doubles of work space for sga_project. */\n#define SGA_WORK (SGA_CONSTRAINTS*SGA_VARIABLES + SGA_VARIABLES + 2*SGA_CONSTRAINTS + 1)\n\n");
}

static const char prototypes[] =
    "\n/* Arrays: x[SGA_VARIABLES], p[SGA_ARGUMENTS], f[SGA_GAUGE] (NULL where there are none). */\n"
    "/* c[SGA_CONSTRAINTS] */\n"
    "void sga_constraints(double t, const double *x, const double *p, double *c);\n"
    "/* J[SGA_CONSTRAINTS*SGA_VARIABLES], by rows */\n"
    "void sga_jacobian(double t, const double *x, const double *p, double *J);\n"
    "/* dx[SGA_VARIABLES] */\n"
    "void sga_field(double t, const double *x, const double *f, const double *p, double *dx);\n"
    "/* G[SGA_GAUGE*SGA_VARIABLES], by rows */\n"
    "void sga_gauge_fields(double t, const double *x, const double *p, double *G);\n"
    "/* Moves x onto the constraints by Gauss-Newton steps of least length until a step is shorter than tolerance*(1 + |x|); work[SGA_WORK].\n"
    " * The number of steps, or -1: it did not converge, and x is wherever it came to. */\n"
    "int sga_project(double t, double *x, const double *p, double tolerance, double *work);\n\n";

const char export_c_helpers[] =
    "static inline double sga_sign(double a) { return a > 0 ? 1.0 : a < 0 ? -1.0 : a; }\n"
    "static inline double sga_power(double a, double b) { return a < 0 ? sqrt(-1.0) : pow(a, b); }\n"
    "/* Unlike fmin and fmax: where an argument is no number, neither is the result. */\n"
    "static inline double sga_least(double a, double b) { return a < b ? a : b <= a ? b : a + b; }\n"
    "static inline double sga_greatest(double a, double b) { return a > b ? a : b >= a ? b : a + b; }\n\n";

bool export_c_function(struct export_model *m, const char *head, const char *size, const char *array,
                       bool (*lines)(struct export_model *, struct sga_buf *, struct sga_error *), struct sga_buf *out, struct sga_error *err)
{
    sga_buf_printf(out, "%s\n{\n    (void)t; (void)x; (void)p; (void)%s;\n", head, array);
    if (size)
        sga_buf_printf(out, "    for (int i = 0; i < %s; i++)\n        %s[i] = 0.0;\n", size, array);
    bool ok = lines(m, out, err);
    sga_buf_puts(out, "}\n\n");
    return ok;
}

/* Rows of J are made orthonormal one after the other (modified Gram-Schmidt, twice, as Parlett and Kahan ask); with J = L Q the step of
 * least length is -Q^T L^-1 c, and needs of L one row at a time. */
const char export_c_projection[] =
    "int sga_project(double t, double *x, const double *p, double tolerance, double *work)\n"
    "{\n"
    "    const int n = SGA_VARIABLES, m = SGA_CONSTRAINTS;\n"
    "    double *q = work, *step = q + m*n, *c = step + n, *z = c + m;\n"
    "    for (int count = 0; count < 50; count++) {\n"
    "        double length = 0.0, size = 0.0;\n"
    "        sga_constraints(t, x, p, c);\n"
    "        sga_jacobian(t, x, p, q);\n"
    "        for (int k = 0; k < n; k++)\n"
    "            step[k] = 0.0;\n"
    "        for (int i = 0; i < m; i++) {\n"
    "            double *row = q + i*n, before = 0.0, norm = 0.0;\n"
    "            for (int k = 0; k < n; k++)\n"
    "                before += row[k]*row[k];\n"
    "            z[i] = c[i];\n"
    "            for (int again = 0; again < 2; again++)\n"
    "                for (int j = 0; j < i; j++) {\n"
    "                    double l = 0.0;\n"
    "                    for (int k = 0; k < n; k++)\n"
    "                        l += row[k]*q[j*n + k];\n"
    "                    for (int k = 0; k < n; k++)\n"
    "                        row[k] -= l*q[j*n + k];\n"
    "                    z[i] -= l*z[j];\n"
    "                }\n"
    "            for (int k = 0; k < n; k++)\n"
    "                norm += row[k]*row[k];\n"
    "            if (!(norm > 1e-26*before))\n"
    "                return -1;          /* the rows depend on each other here */\n"
    "            norm = sqrt(norm);\n"
    "            z[i] /= norm;\n"
    "            for (int k = 0; k < n; k++) {\n"
    "                row[k] /= norm;\n"
    "                step[k] += z[i]*row[k];\n"
    "            }\n"
    "        }\n"
    "        for (int k = 0; k < n; k++) {\n"
    "            x[k] -= step[k];\n"
    "            length += step[k]*step[k];\n"
    "            size += x[k]*x[k];\n"
    "        }\n"
    "        if (!(length <= 1e300))\n"
    "            return -1;\n"
    "        if (sqrt(length) <= tolerance*(1.0 + sqrt(size)))\n"
    "            return count + 1;\n"
    "    }\n"
    "    return -1;\n"
    "}\n";

bool export_c(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    head(m, out);
    if (!export_constants(m, "#define P_%s (", ")\n", out, err))
        return false;
    sga_buf_puts(out, prototypes);
    sga_buf_puts(out, export_c_helpers);
    bool ok = export_c_function(m, "void sga_constraints(double t, const double *x, const double *p, double *c)", NULL, "c", export_constraint_lines, out, err) &&
              export_c_function(m, "void sga_jacobian(double t, const double *x, const double *p, double *J)",
                       "SGA_CONSTRAINTS*SGA_VARIABLES", "J", export_jacobian_lines, out, err) &&
              export_c_function(m, "void sga_gauge_fields(double t, const double *x, const double *p, double *G)", "SGA_GAUGE*SGA_VARIABLES", "G", export_gauge_lines, out, err) &&
              export_c_function(m, "void sga_field(double t, const double *x, const double *f, const double *p, double *dx)", NULL, "f", export_field_lines, out, err);
    sga_buf_puts(out, export_c_projection);
    return ok;
}
