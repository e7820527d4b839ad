/* Python 3, the module math alone: lists of floats. */
#include "buf.h"
#include "skeleton.h"

static void put_names(const struct export_source *s, struct sga_buf *out)
{
    sga_buf_puts(out, "VARIABLES = [");
    for (int i = 0; i < s->variables; i++)
        sga_buf_printf(out, "%s\"%s\"", i ? ", " : "", s->variable[i]);
    sga_buf_puts(out, "]\nARGUMENTS = [");
    for (int i = 0, k = 0; i < s->parameters; i++)
        if (!s->parameter[i].value)
            sga_buf_printf(out, "%s\"%s\"", k++ ? ", " : "", s->parameter[i].name);
    sga_buf_puts(out, "]\nGENERATIONS = [");
    for (int i = 0; i < s->constraints; i++)
        sga_buf_printf(out, "%s%d", i ? ", " : "", s->constraint[i].generation);
    sga_buf_printf(out, "]\nGAUGE = %d\n", s->gauges);
}

static bool head(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    sga_buf_printf(out, "\"\"\"Made by sgad %s from job %s.\n\n", m->source->version, m->source->job);
    sga_buf_puts(out, "The constraints c(t, x) = 0, their Jacobian, the field dx/dt on them, the gauge fields, and a projection onto them.\n"
                      "Where a formula has no value the module math raises ValueError, ZeroDivisionError or OverflowError.\n"
                      "The answer was found for the values of parameters below; numbers in the formulas may come from them, so another value needs\n"
                      "another job, or the value null, which makes the parameter an argument, p.\n\n");
    export_legend(m, "  ", out);
    sga_buf_puts(out, "\"\"\"\nimport math\n\n");
    put_names(m->source, out);
    if (!export_constants(m, "P_%s = ", "\n", out, err))
        return false;
    sga_buf_puts(out, "\n\n"
                      "def _sign(a):\n    return math.copysign(1.0, a) if a else a\n\n\n"
                      "def _power(a, b):\n    if a < 0:\n        raise ValueError(\"a real power of a negative number\")\n    return math.pow(a, b)\n\n\n"
                      "def _cbrt(a):\n"
                      "    if a == 0 or not math.isfinite(a):\n        return a\n"
                      "    r = math.copysign(abs(a)**(1/3), a)\n    return r - (r - a/(r*r))/3\n\n\n");
    return true;
}

struct shape {
    const char *signature, *meaning, *array, *size;
    bool (*lines)(struct export_model *, struct sga_buf *, struct sga_error *);
    const char *result;
};

static const struct shape functions[] = {
    { "constraints(t, x, p=())", "The constraints, which vanish on the final set.", "c", "len(GENERATIONS)", export_constraint_lines, "c" },
    { "jacobian(t, x, p=())", "A row for each constraint, its derivatives by the variables.", "J", "len(GENERATIONS)*len(VARIABLES)",
      export_jacobian_lines, "[J[i:i + len(VARIABLES)] for i in range(0, len(J), len(VARIABLES))]" },
    { "gauge_fields(t, x, p=())", "A row for each gauge field.", "G", "GAUGE*len(VARIABLES)", export_gauge_lines,
      "[G[i:i + len(VARIABLES)] for i in range(0, len(G), len(VARIABLES))]" },
    { "field(t, x, f=(0.0,)*GAUGE, p=())", "dx/dt, with the values of the gauge functions.", "dx", "len(VARIABLES)", export_field_lines, "dx" },
};

static bool function(struct export_model *m, const struct shape *f, struct sga_buf *out, struct sga_error *err)
{
    sga_buf_printf(out, "def %s:\n    \"\"\"%s\"\"\"\n    %s = [0.0]*(%s)\n", f->signature, f->meaning, f->array, f->size);
    bool ok = f->lines(m, out, err);
    sga_buf_printf(out, "    return %s\n\n\n", f->result);
    return ok;
}

/* The same steps as in C (c.c). */
static const char projection[] =
    "def _dot(a, b):\n"
    "    return sum(u*v for u, v in zip(a, b))\n\n\n"
    "def project(t, x, p=(), tolerance=1e-13):\n"
    "    \"\"\"The point of the constraints that Gauss-Newton steps of least length lead to; ArithmeticError where they do not converge.\"\"\"\n"
    "    x = list(x)\n"
    "    for _ in range(50):\n"
    "        step, rows, z = [0.0]*len(x), [], []\n"
    "        for row, rest in zip(jacobian(t, x, p), constraints(t, x, p)):\n"
    "            before = _dot(row, row)\n"
    "            for _again in range(2):\n"
    "                for other, part in zip(rows, z):\n"
    "                    size = _dot(row, other)\n"
    "                    row = [u - size*v for u, v in zip(row, other)]\n"
    "                    rest -= size*part\n"
    "            norm = _dot(row, row)\n"
    "            if not norm > 1e-26*before:\n"
    "                raise ArithmeticError(\"the constraints depend on each other here\")\n"
    "            norm = math.sqrt(norm)\n"
    "            rows.append([u/norm for u in row])\n"
    "            z.append(rest/norm)\n"
    "            step = [u + z[-1]*v for u, v in zip(step, rows[-1])]\n"
    "        x = [u - v for u, v in zip(x, step)]\n"
    "        if math.sqrt(_dot(step, step)) <= tolerance*(1 + math.sqrt(_dot(x, x))):\n"
    "            return x\n"
    "    raise ArithmeticError(\"no point of the constraints was found from there\")\n";

bool export_python(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    if (!head(m, out, err))
        return false;
    for (size_t i = 0; i < sizeof functions / sizeof *functions; i++)
        if (!function(m, &functions[i], out, err))
            return false;
    sga_buf_puts(out, projection);
    return true;
}
