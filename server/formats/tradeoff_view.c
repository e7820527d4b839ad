/* A tradeoff as a table or as an image. Numbers of the table are copied as they stand. */
#include "tradeoff_view.h"

#include <math.h>
#include <stdlib.h>

#include "buf.h"
#include "plot.h"
#include "view.h"

static const char *const names[] = { "method", "arithmetic", "rtol", "atol", "seconds", "evaluations", "error", "residual",
                                     "error_at_most", "digits", "within", "note" };
enum { NAMES = sizeof names / sizeof *names, CURVES = 64 };

void tradeoff_csv(struct slice tradeoff, struct sga_buf *out)
{
    const char *cursor = NULL;
    struct slice rows = scan_member(tradeoff, "rows"), row;
    for (int k = 0; k < NAMES; k++)
        sga_buf_printf(out, "%s%s", k ? "," : "", names[k]);
    sga_buf_puts(out, "\r\n");
    while ((row = scan_next(rows, &cursor)).at) {
        for (int k = 0; k < NAMES; k++) {
            struct slice value = scan_member(row, names[k]);
            sga_buf_puts(out, k ? "," : "");
            if (value.at)
                view_field(out, value);
        }
        sga_buf_puts(out, "\r\n");
    }
}

/* "radau", or "taylor, double-double". Names of methods and arithmetics need no unescaping. */
static char *curve_name(struct slice method, struct slice arithmetic)
{
    struct sga_buf b = { 0 };
    if (method.len > 2)
        sga_buf_put(&b, method.at + 1, method.len - 2);
    sga_buf_puts(&b, ", ");
    if (arithmetic.len > 2)
        sga_buf_put(&b, arithmetic.at + 1, arithmetic.len - 2);
    return sga_buf_take(&b);
}

static bool same(struct slice a, struct slice b)
{
    if (a.len != b.len)
        return false;
    for (size_t i = 0; i < a.len; i++)
        if (a.at[i] != b.at[i])
            return false;
    return true;
}

/* The true error, or what it is at most. */
static struct plot_point point_of(struct slice row, bool *bounds)
{
    double error = scan_number(scan_member(row, "error"), NAN);
    struct plot_point q = { .x = error, .y = scan_number(scan_member(row, "seconds"), NAN), .bound = isnan(error) };
    if (q.bound)
        q.x = scan_number(scan_member(row, "error_at_most"), NAN);
    *bounds |= q.bound && q.x > 0;
    return q;
}

void tradeoff_svg(struct slice tradeoff, struct sga_buf *out)
{
    struct plot_curve curve[CURVES];
    struct slice rows = scan_member(tradeoff, "rows"), row, method = { NULL, 0 }, arithmetic = { NULL, 0 };
    const char *cursor = NULL;
    size_t count = 0, i = 0;
    int curves = 0;
    bool bounds = false;
    while (scan_next(rows, &cursor).at)
        count++;
    struct plot_point *point = malloc((count + 1) * sizeof *point);
    cursor = NULL;
    while (point && i < count && (row = scan_next(rows, &cursor)).at) {
        struct slice m = scan_member(row, "method"), a = scan_member(row, "arithmetic");
        if (curves == 0 || !same(m, method) || !same(a, arithmetic)) {
            if (curves == CURVES)
                break;
            curve[curves++] = (struct plot_curve){ .name = curve_name(m, a), .point = point + i };
            method = m;
            arithmetic = a;
        }
        point[i++] = point_of(row, &bounds);
        curve[curves - 1].points++;
    }
    plot_svg(&(struct plot){ .title = "Time against error", .x_label = "largest error over samples and columns",
                             .y_label = "CPU seconds of one solution", .bound_label = bounds ? "error at most" : NULL,
                             .curve = curve, .curves = curves }, out);
    for (int k = 0; k < curves; k++)
        free((char *)curve[k].name);
    free(point);
}
