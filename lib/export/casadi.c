/* CasADi from Python: the formulas as functions of anything that calculates, and casadi.Function made of them. */
#include "buf.h"
#include "skeleton.h"

static bool head(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    const struct export_source *s = m->source;
    sga_buf_puts(out, "# Its formulas were checked by Python; CasADi itself was not there to run them.\n#\n");
    export_about(m, "# ", "CasADi's result is NaN or infinite", out);
    export_legend(m, "#   ", out);
    sga_buf_puts(out, "import math\n\nimport casadi\n\nVARIABLES = [");
    for (int i = 0; i < s->variables; i++)
        sga_buf_printf(out, "%s\"%s\"", i ? ", " : "", s->variable[i]);
    sga_buf_puts(out, "]\nGENERATIONS = [");
    for (int i = 0; i < s->constraints; i++)
        sga_buf_printf(out, "%s%d", i ? ", " : "", s->constraint[i].generation);
    sga_buf_printf(out, "]\nGAUGE = %d\nARGUMENTS = %d\n", s->gauges, m->free_parameters);
    bool ok = export_constants(m, "P_%s = ", "\n", out, err);
    sga_buf_puts(out, "\n\ndef _power(a, b):\n    return casadi.if_else(a < 0, math.nan, casadi.power(casadi.fabs(a), b))\n\n\n"
                      "def _cbrt(a):\n    return casadi.sign(a)*casadi.power(casadi.fabs(a), 1/3)\n\n\n");
    return ok;
}

static const struct shape {
    const char *signature, *array, *size;
    bool (*lines)(struct export_model *, struct sga_buf *, struct sga_error *);
} functions[] = {
    { "_constraints(t, x, p)", "c", "len(GENERATIONS)", export_constraint_lines },
    { "_jacobian(t, x, p)", "J", "len(GENERATIONS)*len(VARIABLES)", export_jacobian_lines },
    { "_gauge_fields(t, x, p)", "G", "GAUGE*len(VARIABLES)", export_gauge_lines },
    { "_field(t, x, f, p)", "dx", "len(VARIABLES)", export_field_lines },
};

static bool function(struct export_model *m, const struct shape *f, struct sga_buf *out, struct sga_error *err)
{
    sga_buf_printf(out, "def %s:\n    %s = [0.0]*(%s)\n", f->signature, f->array, f->size);
    bool ok = f->lines(m, out, err);
    sga_buf_printf(out, "    return %s\n\n\n", f->array);
    return ok;
}

static const char rest[] =
    "def _grid(entries, rows):\n"
    "    return casadi.reshape(casadi.vertcat(*entries), len(VARIABLES), rows).T\n\n\n"
    "_t, _x, _f, _p = casadi.SX.sym(\"t\"), casadi.SX.sym(\"x\", len(VARIABLES)), casadi.SX.sym(\"f\", GAUGE), casadi.SX.sym(\"p\", ARGUMENTS)\n"
    "constraints = casadi.Function(\"constraints\", [_t, _x, _p], [casadi.vertcat(*_constraints(_t, _x, _p))], [\"t\", \"x\", \"p\"], [\"c\"])\n"
    "jacobian = casadi.Function(\"jacobian\", [_t, _x, _p], [_grid(_jacobian(_t, _x, _p), len(GENERATIONS))], [\"t\", \"x\", \"p\"], [\"J\"])\n"
    "gauge_fields = casadi.Function(\"gauge_fields\", [_t, _x, _p], [_grid(_gauge_fields(_t, _x, _p), GAUGE)], [\"t\", \"x\", \"p\"], [\"G\"])\n"
    "field = casadi.Function(\"field\", [_t, _x, _f, _p], [casadi.vertcat(*_field(_t, _x, _f, _p))], [\"t\", \"x\", \"f\", \"p\"], [\"dx\"])\n\n\n"
    "def project(t, x, p=(), tolerance=1e-13):\n"
    "    \"\"\"The point of the constraints that Gauss-Newton steps of least length lead to; ArithmeticError where they do not converge.\"\"\"\n"
    "    x, p = casadi.DM(x), casadi.DM(list(p))\n"
    "    for _ in range(50 if GENERATIONS else 0):\n"
    "        J = jacobian(t, x, p)\n"
    "        step = casadi.mtimes(J.T, casadi.solve(casadi.mtimes(J, J.T), constraints(t, x, p)))\n"
    "        x = x - step\n"
    "        if not float(casadi.norm_2(step)) < 1e300:\n"
    "            break\n"
    "        if float(casadi.norm_2(step)) <= tolerance*(1 + float(casadi.norm_2(x))):\n"
    "            return x\n"
    "    if GENERATIONS:\n"
    "        raise ArithmeticError(\"no point of the constraints was found from there\")\n"
    "    return x\n";

bool export_casadi(struct export_model *m, struct sga_buf *out, struct sga_error *err)
{
    if (!head(m, out, err))
        return false;
    for (size_t i = 0; i < sizeof functions / sizeof *functions; i++)
        if (!function(m, &functions[i], out, err))
            return false;
    sga_buf_puts(out, rest);
    return true;
}
