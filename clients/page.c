/* A result as text to read. Expressions stand as they are in the result. */
#include "json_string.h"
#include "pretty.h"
#include "rest.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NAMES(...) (const char *const[]){ __VA_ARGS__, NULL }
enum { SHOWN_ROWS = 21, SHOWN_COLUMNS = 8 };

static void put_value(struct sga_buf *out, const char *before, struct slice value, const char *after)
{
    sga_buf_puts(out, before);
    string_put(out, value);
    sga_buf_puts(out, after);
}

/* "a, b, c" */
static int put_list(struct sga_buf *out, struct slice list)
{
    const char *cursor = NULL;
    struct slice s;
    int n = 0;
    while ((s = scan_next(list, &cursor)).at)
        put_value(out, n++ ? ", " : "", s, "");
    return n;
}

/* Where a name does not say it. */
static void put_role(struct sga_buf *out, struct slice role)
{
    static const char *const told[] = { "\"input\"", "\"multiplier\"" };
    for (size_t k = 0; role.at && k < sizeof told / sizeof *told; k++)
        if (role.len == strlen(told[k]) && memcmp(role.at, told[k], role.len) == 0)
            put_value(out, " (", role, ")");
}

static void put_summary(struct sga_buf *out, struct slice r)
{
    struct slice dims = scan_member(r, "dimensions"), index = scan_member(r, "index"), name = scan_member(r, "name");
    struct slice variables = scan_member(r, "variables"), s;
    if (name.at)
        put_value(out, "", name, "\n");
    put_value(out, "verdict: ", scan_member(r, "verdict"), "\n");
    if (scan_member(r, "equilibrium").at)
        put_value(out, "equilibrium: ", scan_member(r, "equilibrium"), "\n");
    if (variables.at) {
        const char *cursor = NULL;
        sga_buf_puts(out, "variables:");
        for (bool first = true; (s = scan_next(variables, &cursor)).at; first = false) {
            put_value(out, first ? " " : ", ", scan_member(s, "name"), "");
            put_role(out, scan_member(s, "role"));
        }
        sga_buf_puts(out, "\n");
    }
    if (dims.at) {
        put_value(out, "dimensions: ambient ", scan_member(dims, "ambient"), "");
        put_value(out, ", generations ", scan_member(dims, "generations"), "");
        put_value(out, ", final ", scan_member(dims, "final"), "\n");
    }
    if (index.at) {
        put_value(out, "index: generations ", scan_member(index, "generations"), "");
        put_value(out, ", differentiation ", scan_member(index, "differentiation"), "");
        put_value(out, ", seed ", scan_member(index, "seed"), "\n");
    }
}

static void put_constraints(struct sga_buf *out, struct slice r)
{
    struct slice dims = scan_member(scan_member(r, "dimensions"), "generations"), c;
    const char *cursor = NULL, *dim_cursor = NULL;
    int generation = 0;
    while ((c = scan_next(scan_member(r, "constraints"), &cursor)).at) {
        int g = (int)scan_number(scan_member(c, "generation"), 0);
        while (generation < g) {
            struct slice d = scan_next(dims, &dim_cursor);
            sga_buf_printf(out, "\nP%d", ++generation);
            if (d.at)
                put_value(out, ", dimension ", d, "");
            sga_buf_puts(out, "\n");
        }
        put_value(out, "    0 = ", scan_member(c, "expression"), "\n");
    }
}

static void put_definitions(struct sga_buf *out, struct slice r)
{
    struct slice d;
    const char *cursor = NULL;
    for (bool first = true; (d = scan_next(scan_member(r, "definitions"), &cursor)).at; first = false) {
        sga_buf_puts(out, first ? "\nwith\n" : "");
        put_value(out, "    ", scan_member(d, "name"), " = ");
        put_value(out, "", scan_member(d, "expression"), "\n");
    }
}

/* The members of an object of expressions, those that are 0 left out if so wished. */
static void put_field(struct sga_buf *out, struct slice field, const char *before, const char *between, bool zeros)
{
    if (field.len < 2)
        return;
    const char *s = field.at + 1, *end = field.at + field.len - 1;
    while (s < end) {
        struct slice key = scan_value(s, end);
        if (!key.at)
            return;
        struct slice value = scan_value(key.at + key.len + 1, end);
        if (!value.at)
            return;
        s = value.at + value.len + 1;
        if (!zeros && value.len == 3 && memcmp(value.at, "\"0\"", 3) == 0)
            continue;
        put_value(out, before, key, between);
        put_value(out, "", value, "\n");
    }
}

static void put_motion(struct sga_buf *out, struct slice r)
{
    struct slice field = scan_member(r, "vector_field"), gauge = scan_member(r, "gauge"), free_names = scan_member(field, "free"), z;
    if (field.at) {
        sga_buf_puts(out, "\nreduced vector field on Pf");
        if (free_names.len > 2) {
            sga_buf_puts(out, " (arbitrary: ");
            put_list(out, free_names);
            sga_buf_puts(out, ")");
        }
        sga_buf_puts(out, "\n");
        put_field(out, scan_member(field, "components"), "    der(", ") = ", true);
    }
    if (!gauge.at)
        return;
    put_value(out, "\ngauge freedom: dimension ", scan_member(gauge, "dimension"), "\n");
    const char *cursor = NULL;
    for (int k = 1; (z = scan_next(scan_member(gauge, "fields"), &cursor)).at; k++) {
        sga_buf_printf(out, "  gauge field %d\n", k);
        put_field(out, z, "    d/d", ": ", false);
    }
}

/* The answer of a stratum, in a line. */
static void put_inside(struct sga_buf *out, struct slice r)
{
    if (!r.at)
        return;
    put_value(out, "    result: ", scan_member(r, "verdict"), "");
    put_value(out, ", final dimension ", scan_member(scan_member(r, "dimensions"), "final"), " (the rest of it: --json)\n\n");
}

static void put_strata(struct sga_buf *out, struct slice r)
{
    struct slice s;
    const char *cursor = NULL;
    for (bool first = true; (s = scan_next(scan_member(r, "strata"), &cursor)).at; first = false) {
        struct slice kind = scan_member(s, "kind");
        sga_buf_puts(out, first ? "\nstrata, where a rank may drop\n    0 = " : "    0 = ");
        put_list(out, scan_member(s, "where"));
        if (kind.at)
            put_value(out, "   (", kind, ")");
        sga_buf_puts(out, "\n");
        rest_put(out, s, "    ", (struct rest_names){ NAMES("where", "kind", "result"), NULL });
        put_inside(out, scan_member(s, "result"));
    }
}

static void put_row(struct sga_buf *out, struct slice row)
{
    const char *cursor = NULL;
    struct slice v;
    for (int k = 0; k < SHOWN_COLUMNS && (v = scan_next(row, &cursor)).at; k++) {
        double x = scan_number(v, NAN);
        if (isnan(x))
            sga_buf_printf(out, "%13s", "-");
        else
            sga_buf_printf(out, "%13.6g", x);
    }
    sga_buf_puts(out, "\n");
}

/* Evenly chosen samples, the last one among them. */
static void put_samples(struct sga_buf *out, struct slice rows)
{
    const char *cursor = NULL;
    int count = 0, next = 0, shown = 0;
    while (scan_next(rows, &cursor).at)
        count++;
    int show = count < SHOWN_ROWS ? count : SHOWN_ROWS;
    cursor = NULL;
    for (int i = 0; i < count; i++) {
        struct slice row = scan_next(rows, &cursor);
        if (i != next)
            continue;
        put_row(out, row);
        shown++;
        next = show > 1 ? (int)((long)shown * (count - 1) / (show - 1)) : count;
    }
    if (show < count)
        sga_buf_printf(out, "  (%d of %d samples)\n", show, count);
}

/* Samples as a table, how good they are, and why they end. */
static void put_table(struct sga_buf *out, struct slice t)
{
    struct slice columns = scan_member(t, "columns"), c, ended = scan_member(t, "ended");
    const char *cursor = NULL;
    int n = 0;
    put_value(out, "by ", scan_member(t, "method"), "");
    put_value(out, ", error estimate ", scan_member(t, "error_estimate"), "");
    put_value(out, ", constraint residual ", scan_member(t, "constraint_residual"), "\n");
    put_value(out, "the start was moved by ", scan_member(scan_member(t, "initial"), "moved"), " onto Pf\n");
    for (; (c = scan_next(columns, &cursor)).at; n++) {
        char *name = string_take(c);
        if (n < SHOWN_COLUMNS)
            sga_buf_printf(out, "%13.12s", name);
        free(name);
    }
    sga_buf_puts(out, "\n");
    put_samples(out, scan_member(t, "rows"));
    if (n > SHOWN_COLUMNS)
        sga_buf_printf(out, "  (%d of %d columns; --json shows all)\n", SHOWN_COLUMNS, n);
    if (ended.at && *ended.at == '{') {
        put_value(out, "ended at ", scan_member(ended, "t"), "");
        double error = scan_number(scan_member(ended, "error"), NAN);
        if (isfinite(error))
            sga_buf_printf(out, " (error %.2g)", error);
        put_value(out, ": ", scan_member(ended, "reason"), "");
        put_value(out, ". ", scan_member(ended, "detail"), "\n");
    }
}

/* One motion, or why there is none, after its heading. */
static void put_trajectory(struct sga_buf *out, struct slice t, const char *before)
{
    static const char *const seldom[] = { "initial", "errors", "column_errors", "units", "radii", NULL };
    if (scan_member(t, "columns").at)
        put_table(out, t);
    rest_put(out, t, before, (struct rest_names){ NAMES("columns", "rows", "method", "error_estimate", "constraint_residual", "ended"), seldom });
}

static void put_trajectories(struct sga_buf *out, struct slice r)
{
    struct slice one = scan_member(r, "trajectory"), t;
    const char *cursor = NULL;
    if (one.at) {
        sga_buf_puts(out, "\ntrajectory ");
        put_trajectory(out, one, "trajectory.");
    }
    for (int k = 0; (t = scan_next(scan_member(r, "trajectories"), &cursor)).at; k++) {
        char before[40];
        snprintf(before, sizeof before, "trajectories[%d].", k);
        sga_buf_printf(out, "\ntrajectory of set %d ", k);
        put_trajectory(out, t, before);
    }
}

/* A value of a table's column, right-justified. */
static void put_cell(struct sga_buf *out, struct slice row, const char *key, const char *format)
{
    double x = scan_number(scan_member(row, key), NAN);
    if (isnan(x))
        sga_buf_printf(out, "%12s", "-");
    else
        sga_buf_printf(out, format, x);
}

static void put_tradeoff(struct sga_buf *out, struct slice r)
{
    struct slice t = scan_member(r, "tradeoff"), row;
    const char *cursor = NULL;
    if (!t.at)
        return;
    sga_buf_printf(out, "\ntradeoff\n%-12s%-15s%9s%12s%12s%12s%12s%8s\n", "method", "arithmetic", "rtol", "seconds", "evaluations",
                   "error", "at most", "digits");
    while ((row = scan_next(scan_member(t, "rows"), &cursor)).at) {
        char *method = string_take(scan_member(row, "method")), *arithmetic = string_take(scan_member(row, "arithmetic"));
        sga_buf_printf(out, "%-12s%-15s", method, arithmetic);
        free(method);
        free(arithmetic);
        put_cell(out, row, "rtol", "%9.0e");
        put_cell(out, row, "seconds", "%12.3g");
        put_cell(out, row, "evaluations", "%12.0f");
        put_cell(out, row, "error", "%12.2e");
        put_cell(out, row, "error_at_most", "%12.2e");
        put_cell(out, row, "digits", "%8.1f");
        put_value(out, "  ", scan_member(row, "note"), "");
        sga_buf_puts(out, "\n");
    }
    put_value(out, "", scan_member(t, "advice"), "\n");
}

static void put_warnings(struct sga_buf *out, struct slice r)
{
    struct slice w;
    const char *cursor = NULL;
    for (bool first = true; (w = scan_next(scan_member(r, "warnings"), &cursor)).at; first = false) {
        put_value(out, first ? "\nwarnings\n    " : "    ", scan_member(w, "code"), ": ");
        put_value(out, "", scan_member(w, "detail"), "");
        put_value(out, " (", scan_member(w, "pointer"), ")\n");
    }
}

/* What the parts above do not show, as it stands in the result; the names of what is long and seldom read come last. */
static void put_rest(struct sga_buf *out, struct slice r)
{
    static const char *const seldom[] = { "evidence", "work", NULL };
    rest_put(out, scan_member(r, "dimensions"), "dimensions.", (struct rest_names){ NAMES("ambient", "generations", "final"), NULL });
    rest_put(out, scan_member(r, "index"), "index.", (struct rest_names){ NAMES("generations", "differentiation", "seed"), NULL });
    rest_put(out, scan_member(r, "vector_field"), "vector_field.", (struct rest_names){ NAMES("components", "free"), NULL });
    rest_put(out, scan_member(r, "gauge"), "gauge.", (struct rest_names){ NAMES("dimension", "fields"), NULL });
    rest_put(out, scan_member(r, "tradeoff"), "tradeoff.", (struct rest_names){ NAMES("rows", "advice"), NULL });
    rest_put(out, r, "", (struct rest_names){ NAMES("name", "verdict", "equilibrium", "variables", "dimensions", "index", "constraints", "definitions", "vector_field", "gauge", "strata",
         "warnings", "trajectory", "trajectories", "tradeoff"), seldom });
}

void pretty_text(struct slice r, struct sga_buf *out)
{
    put_summary(out, r);
    put_constraints(out, r);
    put_definitions(out, r);
    put_motion(out, r);
    put_strata(out, r);
    put_warnings(out, r);
    put_trajectories(out, r);
    put_tradeoff(out, r);
    put_rest(out, r);
}
