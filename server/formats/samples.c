/* Rows as the view has them, read as numbers. */
#include "samples.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "json_string.h"

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

bool samples_open(struct samples *s, struct slice trajectory)
{
    *s = (struct samples){ 0 };
    if (!trajectory.at || !view_open(&s->view, VIEW_CSV, trajectory))
        return false;
    s->sweep = s->view.sets.at != NULL;
    read_names(s, &s->view);
    while (view_row(&s->view).at)
        s->rows++;
    view_close(&s->view);
    return view_open(&s->view, VIEW_CSV, trajectory);
}

bool samples_next(struct samples *s, double *value)
{
    const char *cursor = NULL;
    struct slice row = view_row(&s->view);
    int i = 0;
    if (!row.at)
        return false;
    if (s->sweep)
        value[i++] = s->view.set;
    for (; i < s->columns; i++) {
        struct slice one = scan_next(row, &cursor);
        value[i] = one.at ? scan_number(one, NAN) : NAN;
    }
    return true;
}

bool samples_take(struct samples *s)
{
    size_t row = 0;
    if (s->rows && !(s->value = sga_take(&s->mem, s->rows * (size_t)s->columns * sizeof *s->value)))
        return false;
    while (row < s->rows && samples_next(s, s->value + row * (size_t)s->columns))
        row++;
    assert(row == s->rows);
    return true;
}

bool samples_read(struct samples *s, struct slice trajectory)
{
    return samples_open(s, trajectory) && samples_take(s);
}

void samples_end(struct samples *s)
{
    view_close(&s->view);
    sga_arena_end(&s->mem);
}
