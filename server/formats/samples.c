/* Rows as the view has them, read as numbers. */
#include "samples.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "json_string.h"
#include "view.h"

static const char *keep(struct sga_arena *mem, struct slice value)
{
    struct sga_buf b = { 0 };
    string_put(&b, value);
    char *text = sga_zeros(mem, b.len + 1, 1);
    if (b.len)
        memcpy(text, b.data, b.len);
    sga_buf_free(&b);
    return text;
}

static int by_name(const void *a, const void *b)
{
    const char *const *x = *(const char *const *const *)a, *const *y = *(const char *const *const *)b;
    int order = strcmp(*x, *y);
    return order ? order : (x > y) - (x < y);
}

/* No expression has a #, so the new names are nobody's. */
static void tell_apart(struct samples *s)
{
    SGA_ARENA(mem);
    if (s->columns < 2)
        return;
    const char ***sorted = sga_take(&mem, (size_t)s->columns * sizeof *sorted);
    assert(sorted);
    for (int i = 0; i < s->columns; i++)
        sorted[i] = &s->column[i];
    qsort(sorted, (size_t)s->columns, sizeof *sorted, by_name);
    for (int i = 0, to; i < s->columns; i = to) {
        const char *name = *sorted[i];
        for (to = i + 1; to < s->columns && strcmp(*sorted[to], name) == 0; to++) {
            size_t n = strlen(name) + 16;
            char *text = sga_take(&s->mem, n);
            snprintf(text, n, "%s#%d", name, to - i + 1);
            *sorted[to] = text;
        }
    }
}

static void read_names(struct samples *s, const struct view *v)
{
    s->column = sga_zeros(&s->mem, (size_t)v->names + 1, sizeof *s->column);
    if (s->sweep) {
        size_t n = strlen(v->set_name) + 1;
        s->column[s->columns++] = memcpy(sga_take(&s->mem, n), v->set_name, n);
    }
    for (int i = 0; i < v->names; i++)
        s->column[s->columns++] = keep(&s->mem, v->name[i]);
    tell_apart(s);
}

static void read_row(const struct samples *s, const struct view *v, struct slice row, double *value)
{
    const char *cursor = NULL;
    int i = 0;
    if (s->sweep)
        value[i++] = v->set;
    for (; i < s->columns; i++) {
        struct slice one = scan_next(row, &cursor);
        value[i] = one.at ? scan_number(one, NAN) : NAN;
    }
}

bool samples_read(struct samples *s, struct slice trajectory)
{
    struct view v;
    *s = (struct samples){ 0 };
    if (!trajectory.at || !view_open(&v, VIEW_CSV, trajectory))
        return false;
    struct slice row;
    size_t room = 0;
    s->sweep = v.sets.at != NULL;
    read_names(s, &v);
    while ((row = view_row(&v)).at) {
        SGA_RESERVE_IN(&s->mem, s->value, room, (s->rows + 1) * (size_t)s->columns);
        read_row(s, &v, row, s->value + s->rows++ * (size_t)s->columns);
    }
    view_close(&v);
    return true;
}

void samples_end(struct samples *s)
{
    sga_arena_end(&s->mem);
}
