/* Curves of the samples' table; what has no value is a gap. */
#include "motion_svg.h"

#include <string.h>

#include "arena.h"
#include "buf.h"
#include "plot.h"
#include "samples.h"

struct choice {
    const struct samples *s;
    struct sga_arena mem;
    int x, *y, ys;            /* places among the columns */
};

/* Columns without that of a sweep. */
static int first(const struct samples *s)
{
    return s->sweep ? 1 : 0;
}

static int find(const struct samples *s, const char *name, size_t length, struct sga_buf *why)
{
    for (int i = first(s); i < s->columns; i++)
        if (strlen(s->column[i]) == length && !memcmp(s->column[i], name, length))
            return i;
    sga_buf_printf(why, "the trajectory has no column %.*s; it has", length > 200 ? 200 : (int)length, name);
    for (int i = first(s); i < s->columns && why->len < 1000; i++)
        sga_buf_printf(why, " %s", s->column[i]);
    return -1;
}

/* Up to the next comma that separates names: those inside of brackets belong to an output, atan2(x, y). */
static size_t name_length(const char *name)
{
    int depth = 0;
    size_t n = 0;
    for (; name[n] && (name[n] != ',' || depth > 0); n++)
        depth += (name[n] == '(' || name[n] == '[') - (name[n] == ')' || name[n] == ']');
    return n;
}

static bool choose(struct choice *c, const char *columns, const char *x, struct sga_buf *why)
{
    const struct samples *s = c->s;
    c->y = sga_zeros(&c->mem, (size_t)s->columns, sizeof *c->y);
    c->x = x ? find(s, x, strlen(x), why) : first(s);
    if (c->x < 0)
        return false;
    for (int i = first(s) + 1; i < s->columns && !columns; i++)
        if (i != c->x)
            c->y[c->ys++] = i;
    for (const char *name = columns; name && c->ys < s->columns;) {
        size_t n = name_length(name);
        if ((c->y[c->ys++] = find(s, name, n, why)) < 0)
            return false;
        name = name[n] ? name + n + 1 : NULL;
    }
    return true;
}

/* The curves of the rows from..to. */
static void put_curves(struct choice *c, size_t from, size_t to, struct plot_curve *curve)
{
    const struct samples *s = c->s;
    size_t n = to - from;
    struct plot_point *point = sga_zeros(&c->mem, n * (size_t)c->ys, sizeof *point);
    for (size_t i = 0; i < n; i++) {
        const double *row = s->value + (from + i) * (size_t)s->columns;
        for (int k = 0; k < c->ys; k++)
            point[(size_t)k * n + i] = (struct plot_point){ .x = row[c->x], .y = row[c->y[k]] };
    }
    for (int k = 0; k < c->ys; k++) {
        struct sga_buf name = { 0 };
        sga_buf_puts(&name, s->column[c->y[k]]);
        if (s->sweep)
            sga_buf_printf(&name, ", set %.0f", s->value[from * (size_t)s->columns]);
        char *kept = memcpy(sga_take(&c->mem, name.len + 1), name.data ? name.data : "", name.len + 1);
        sga_buf_free(&name);
        curve[k] = (struct plot_curve){ kept, point + (size_t)k * n, (int)n };
    }
}

static size_t end_of_set(const struct samples *s, size_t from)
{
    size_t to = from + 1, wide = (size_t)s->columns;
    while (to < s->rows && (!s->sweep || s->value[to * wide] == s->value[from * wide]))
        to++;
    return to;
}

static void draw(struct choice *c, struct sga_buf *out)
{
    const struct samples *s = c->s;
    size_t sets = 0, done = 0;
    for (size_t i = 0; i < s->rows; i = end_of_set(s, i))
        sets++;
    struct plot_curve *curve = sga_zeros(&c->mem, sets * (size_t)c->ys, sizeof *curve);
    for (size_t i = 0; i < s->rows; i = end_of_set(s, i), done += (size_t)c->ys)
        put_curves(c, i, end_of_set(s, i), curve + done);
    struct plot p = { .linear = true, .title = "Trajectory", .x_label = s->column[c->x], .y_label = c->ys == 1 ? s->column[c->y[0]] : "",
                      .curve = curve, .curves = (int)done };
    plot_svg(&p, out);
}

bool motion_svg(const struct samples *s, const char *columns, const char *x, struct sga_buf *out, struct sga_buf *why)
{
    struct choice c = { .s = s };
    bool ok = choose(&c, columns, x, why);
    if (ok)
        draw(&c, out);
    sga_arena_end(&c.mem);
    return ok;
}
