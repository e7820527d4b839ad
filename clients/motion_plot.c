/* Rows are walked once for each curve's points; what has no value is a gap. */
#include "motion_plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "json_string.h"
#include "plot.h"

struct choice {
    struct sga_arena mem;
    char **name;              /* all columns */
    int names;
    int x;                    /* places among them */
    int *y, ys;
};

static char *keep(struct sga_arena *mem, struct slice value)
{
    struct sga_buf b = { 0 };
    string_put(&b, value);
    char *text = sga_zeros(mem, b.len + 1, 1);
    if (b.len)
        memcpy(text, b.data, b.len);
    sga_buf_free(&b);
    return text;
}

static int count(struct slice array)
{
    const char *cursor = NULL;
    int n = 0;
    while (scan_next(array, &cursor).at)
        n++;
    return n;
}

static int find(const struct choice *c, const char *name, size_t length)
{
    for (int i = 0; i < c->names; i++)
        if (strlen(c->name[i]) == length && !memcmp(c->name[i], name, length))
            return i;
    fprintf(stderr, "sga: the trajectory has no column %.*s; it has", (int)length, name);
    for (int i = 0; i < c->names; i++)
        fprintf(stderr, " %s", c->name[i]);
    fprintf(stderr, "\n");
    return -1;
}

static bool choose(struct choice *c, const char *columns, const char *x)
{
    if (x && (c->x = find(c, x, strlen(x))) < 0)
        return false;
    for (int i = 0; i < c->names && !columns; i++)
        if (i != c->x && i != 0)
            c->y[c->ys++] = i;
    for (const char *name = columns; name && c->ys < c->names;) {
        size_t n = strcspn(name, ",");
        if ((c->y[c->ys++] = find(c, name, n)) < 0)
            return false;
        name = name[n] ? name + n + 1 : NULL;
    }
    return true;
}

static void read_names(struct choice *c, struct slice columns)
{
    const char *cursor = NULL;
    struct slice v;
    c->name = sga_zeros(&c->mem, (size_t)count(columns), sizeof *c->name);
    c->y = sga_zeros(&c->mem, (size_t)count(columns), sizeof *c->y);
    while ((v = scan_next(columns, &cursor)).at)
        c->name[c->names++] = keep(&c->mem, v);
}

/* The numbers of a row, NaN for what is none. */
static void read_row(struct slice row, double *value, int n)
{
    const char *cursor = NULL;
    for (int i = 0; i < n; i++)
        value[i] = scan_number(scan_next(row, &cursor), NAN);
}

/* The curves of one trajectory; set: its number in a sweep, or -1. */
static void put_curves(struct choice *c, struct slice trajectory, int set, struct plot_curve *curve)
{
    struct slice rows = scan_member(trajectory, "rows"), row;
    size_t n = (size_t)count(rows);
    double *value = sga_zeros(&c->mem, (size_t)c->names, sizeof *value);
    struct plot_point *point = sga_zeros(&c->mem, n * (size_t)c->ys, sizeof *point);
    const char *cursor = NULL;
    for (size_t i = 0; (row = scan_next(rows, &cursor)).at; i++) {
        read_row(row, value, c->names);
        for (int k = 0; k < c->ys; k++)
            point[(size_t)k * n + i] = (struct plot_point){ .x = value[c->x], .y = value[c->y[k]] };
    }
    for (int k = 0; k < c->ys; k++) {
        struct sga_buf name = { 0 };
        sga_buf_printf(&name, set < 0 ? "%s" : "%s, set %d", c->name[c->y[k]], set);
        char *kept = sga_zeros(&c->mem, name.len + 1, 1);
        memcpy(kept, name.data, name.len);
        sga_buf_free(&name);
        curve[k] = (struct plot_curve){ kept, point + (size_t)k * n, (int)n };
    }
}

static struct slice first_with_rows(struct slice sets)
{
    const char *cursor = NULL;
    struct slice t = scan_next(sets, &cursor);
    while (t.at && !scan_member(t, "columns").at)
        t = scan_next(sets, &cursor);
    return t;
}

static void draw(struct choice *c, struct slice one, struct slice sets, struct sga_buf *out)
{
    int curves = 0, trajectories = sets.at ? count(sets) : 1, set = 0;
    struct plot_curve *curve = sga_zeros(&c->mem, (size_t)(trajectories * c->ys), sizeof *curve);
    const char *cursor = NULL;
    struct slice t;
    if (!sets.at) {
        put_curves(c, one, -1, curve);
        curves = c->ys;
    }
    for (; sets.at && (t = scan_next(sets, &cursor)).at; set++)
        if (scan_member(t, "columns").at) {
            put_curves(c, t, set, curve + curves);
            curves += c->ys;
        }
    struct plot p = { .linear = true, .title = "Trajectory", .x_label = c->name[c->x], .y_label = c->ys == 1 ? c->name[c->y[0]] : "", .curve = curve, .curves = curves };
    plot_svg(&p, out);
}

bool motion_plot(struct slice result, const char *columns, const char *x, struct sga_buf *out)
{
    struct choice c = { .x = 0 };
    struct slice one = scan_member(result, "trajectory"), sets = scan_member(result, "trajectories");
    struct slice shape = one.at ? one : sets.at ? first_with_rows(sets) : one;
    bool ok = shape.at && scan_member(shape, "columns").at;
    if (ok) {
        read_names(&c, scan_member(shape, "columns"));
        ok = c.names > 0 && choose(&c, columns, x);
        if (ok)
            draw(&c, one, one.at ? (struct slice){ NULL, 0 } : sets, out);
    } else {
        fprintf(stderr, "sga: the result has no samples: add \"trajectory\" to the request\n");
    }
    sga_arena_end(&c.mem);
    return ok;
}
