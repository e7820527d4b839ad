/* Matrices and lists of expressions, as several forms have them. */
#include <assert.h>
#include <stdlib.h>

#include "error.h"
#include "form.h"
#include "reader.h"

/* A constant has no symbols but parameters. */
static bool is_constant(const struct expr_store *st, expr_id e)
{
    return !(symbol_kinds(st, e) & ~(1u << EXPR_PARAMETER));
}

static bool add_entry(struct reader *rd, struct read_matrix *m, int row, int col, const json_t *v)
{
    assert(row >= 0 && col >= 0 && col < m->cols);
    expr_id e = read_listed(rd, v, NULL);
    if (!e)
        return false;
    if (m->constant && !is_constant(&rd->r->store, e))
        return at_fail(rd, SGA_E_SCHEMA, "an entry of %s is a constant: numbers and parameters only", m->name);
    if (expr_is_zero(&rd->r->store, e))
        return true;
    SGA_RESERVE_IN(&rd->mem, m->entry, m->cap, m->entries + 1);
    m->entry[m->entries++] = (struct form_entry){ .row = row, .col = col, .value = e };
    return true;
}

/* One flat list is one row where a row is what fits: [a, b] for two variables. */
static bool is_one_row(const json_t *v, int cols)
{
    if (!json_is_array(v) || cols == 1 || json_array_size(v) != (size_t)cols)
        return false;
    for (size_t i = 0; i < json_array_size(v); i++)
        if (json_is_array(json_array_get(v, i)))
            return false;
    return true;
}

static bool read_row(struct reader *rd, struct read_matrix *m, const json_t *v, int row)
{
    if (list_size(v) != (size_t)m->cols)
        return at_fail(rd, SGA_E_SHAPE, "this row has %zu entries, but there are %d of %s", list_size(v), m->cols,
                       m->per_col);
    for (int j = 0; j < m->cols; j++) {
        size_t here = at_item(rd, v, (size_t)j);
        if (!add_entry(rd, m, row, j, list_item(v, (size_t)j)))
            return false;
        at_back(rd, here);
    }
    return true;
}

static bool read_dense(struct reader *rd, struct read_matrix *m, const json_t *v)
{
    if (m->rows == 1 && is_one_row(v, m->cols))
        return read_row(rd, m, v, 0);
    if (list_size(v) != (size_t)m->rows)
        return at_fail(rd, SGA_E_SHAPE, "%s has %zu rows, but there are %d of %s%s", m->name, list_size(v), m->rows,
                       m->per_row, m->hint ? m->hint : "");
    for (int i = 0; i < m->rows; i++) {
        size_t here = at_item(rd, v, (size_t)i);
        if (!read_row(rd, m, list_item(v, (size_t)i), i) && !at_pass(rd, here))
            return false;
        at_back(rd, here);
    }
    return true;
}

static bool read_size(struct reader *rd, const struct read_matrix *m, const json_t *v, const char *member, int size, const char *per)
{
    const json_t *n = need_member(rd, v, member);
    long given;
    if (!n)
        return false;
    size_t mark = at_member(rd, member);
    if (!read_integer(rd, n, 0, 1L << 31, &given))
        return false;
    if (given != size)
        return at_fail(rd, SGA_E_SHAPE, "%s has %ld %s, but there are %d of %s", m->name, given, member, size, per);
    at_back(rd, mark);
    return true;
}

static bool read_triple(struct reader *rd, struct read_matrix *m, const json_t *v)
{
    if (!json_is_array(v))
        return expected(rd, "an entry [row, column, expression]", v);
    if (json_array_size(v) != 3)
        return at_fail(rd, SGA_E_SHAPE, "an entry is [row, column, expression]: 3 values, not %zu", json_array_size(v));
    long place[2];
    for (size_t k = 0; k < 2; k++) {
        size_t here = at_index(rd, k);
        int size = k ? m->cols : m->rows;
        if (!read_integer(rd, json_array_get(v, k), -(1L << 31), 1L << 31, &place[k]))
            return false;
        if (place[k] < 0 || place[k] >= size)
            return at_fail(rd, SGA_E_SHAPE, "%s %ld lies outside %s, which has %d (counted from 0)",
                           k ? "column" : "row", place[k], m->name, size);
        at_back(rd, here);
    }
    size_t here = at_index(rd, 2);
    if (!add_entry(rd, m, (int)place[0], (int)place[1], json_array_get(v, 2)))
        return false;
    at_back(rd, here);
    return true;
}

static bool read_sparse(struct reader *rd, struct read_matrix *m, const json_t *v)
{
    static const char *const members[] = { "rows", "cols", "entries", NULL };
    if (!only_members(rd, v, members) || !read_size(rd, m, v, "rows", m->rows, m->per_row)
        || !read_size(rd, m, v, "cols", m->cols, m->per_col))
        return false;
    const json_t *entries = need_member(rd, v, "entries");
    if (!entries)
        return false;
    size_t mark = at_member(rd, "entries");
    if (!json_is_array(entries))
        return expected(rd, "an array of entries [row, column, expression]", entries);
    for (size_t i = 0; i < json_array_size(entries); i++) {
        size_t here = at_index(rd, i);
        if (!read_triple(rd, m, json_array_get(entries, i)) && !at_pass(rd, here))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

bool read_matrix_value(struct reader *rd, const json_t *v, struct read_matrix *m)
{
    return (json_is_object(v) ? read_sparse : read_dense)(rd, m, v);
}

bool read_matrix(struct reader *rd, const json_t *system, struct read_matrix *m)
{
    const json_t *v = need_member(rd, system, m->name);
    if (!v)
        return false;
    size_t mark = at_member(rd, m->name);
    if (!read_matrix_value(rd, v, m))
        return false;
    at_back(rd, mark);
    return true;
}

bool read_matrix_rows(struct reader *rd, const json_t *system, const char *member, int cols, int *rows)
{
    const json_t *v = need_member(rd, system, member);
    long given;
    if (!v)
        return false;
    size_t mark = at_member(rd, member);
    if (json_is_object(v)) {
        const json_t *n = need_member(rd, v, "rows");
        if (!n)
            return false;
        at_member(rd, "rows");
        if (!read_integer(rd, n, 0, 16L * REQUEST_MAX_VARIABLES, &given))
            return false;
    } else {
        given = is_one_row(v, cols) ? 1 : (long)list_size(v);
    }
    if (given > 16L * REQUEST_MAX_VARIABLES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %ld rows; the limit is %d", given, 16 * REQUEST_MAX_VARIABLES);
    *rows = (int)given;
    at_back(rd, mark);
    return true;
}

struct form_entry *read_matrix_kept(struct sga_arena *mem, const struct form_entry *entry, size_t entries)
{
    struct form_entry *kept = sga_take(mem, (entries + 1) * sizeof *kept);
    for (size_t k = 0; k < entries; k++)
        kept[k] = entry[k];
    return kept;
}

bool read_expression_list(struct reader *rd, const json_t *system, const char *member, expr_id **list, int *count)
{
    const json_t *v = json_object_get(system, member);
    *list = NULL;
    *count = -1;
    if (!v)
        return true;
    size_t mark = at_member(rd, member), n = list_size(v);
    if (n > 16u * REQUEST_MAX_VARIABLES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu entries; the limit is %d", n, 16 * REQUEST_MAX_VARIABLES);
    *list = sga_zeros(&rd->r->mem, n + 1, sizeof **list);
    for (size_t i = 0; i < n; i++) {
        size_t here = at_item(rd, v, i);
        if (!((*list)[i] = read_listed(rd, list_item(v, i), NULL)))
            return false;
        at_back(rd, here);
    }
    *count = (int)n;
    at_back(rd, mark);
    return true;
}
