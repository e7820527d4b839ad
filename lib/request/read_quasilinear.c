/* The form `quasilinear`: A dense or sparse, alpha, restrict, transpose. */
#include <stdlib.h>

#include "form.h"
#include "mem.h"
#include "reader.h"

struct matrix {
    struct form_entry *entry;
    size_t entries, cap;
};

static bool add_entry(struct reader *rd, struct matrix *m, int row, int col, const json_t *v)
{
    expr_id e = read_expression(rd, v, NULL);
    if (!e)
        return false;
    if (expr_is_zero(&rd->r->store, e))
        return true;
    SGA_RESERVE(m->entry, m->cap, m->entries + 1);
    m->entry[m->entries++] = (struct form_entry){ .row = row, .col = col, .value = e };
    return true;
}

/* One flat list is one row where a row is what fits: [a, b] for two variables. */
static bool is_one_row(const json_t *v, int rows, int cols)
{
    if (!json_is_array(v) || rows != 1 || cols == 1 || json_array_size(v) != (size_t)cols)
        return false;
    for (size_t i = 0; i < json_array_size(v); i++)
        if (json_is_array(json_array_get(v, i)))
            return false;
    return true;
}

static bool read_row(struct reader *rd, struct matrix *m, const json_t *v, int row, int cols, const char *per)
{
    if (list_size(v) != (size_t)cols)
        return at_fail(rd, SGA_E_SHAPE, "this row has %zu entries, but there are %d of %s", list_size(v), cols, per);
    for (int j = 0; j < cols; j++) {
        size_t here = at_item(rd, v, (size_t)j);
        if (!add_entry(rd, m, row, j, list_item(v, (size_t)j)))
            return false;
        at_back(rd, here);
    }
    return true;
}

static bool read_dense(struct reader *rd, struct matrix *m, const json_t *v, int rows, int cols, bool transpose)
{
    const char *per_row = transpose ? "variables" : "alpha", *per_col = transpose ? "alpha" : "variables";
    if (is_one_row(v, rows, cols))
        return read_row(rd, m, v, 0, cols, per_col);
    if (list_size(v) != (size_t)rows)
        return at_fail(rd, SGA_E_SHAPE, "A has %zu rows, but there are %d of %s%s", list_size(v), rows, per_row,
                       transpose ? " (with transpose, A has a row for each variable)" : "");
    for (int i = 0; i < rows; i++) {
        size_t here = at_item(rd, v, (size_t)i);
        if (!read_row(rd, m, list_item(v, (size_t)i), i, cols, per_col))
            return false;
        at_back(rd, here);
    }
    return true;
}

static bool read_size(struct reader *rd, const json_t *v, const char *member, int size, const char *per)
{
    const json_t *n = need_member(rd, v, member);
    long given;
    if (!n)
        return false;
    size_t mark = at_member(rd, member);
    if (!read_integer(rd, n, 0, 1L << 31, &given))
        return false;
    if (given != size)
        return at_fail(rd, SGA_E_SHAPE, "A has %ld %s, but there are %d of %s", given, member, size, per);
    at_back(rd, mark);
    return true;
}

static bool read_triple(struct reader *rd, struct matrix *m, const json_t *v, int rows, int cols)
{
    if (!json_is_array(v))
        return expected(rd, "an entry [row, column, expression]", v);
    if (json_array_size(v) != 3)
        return at_fail(rd, SGA_E_SHAPE, "an entry is [row, column, expression]: 3 values, not %zu", json_array_size(v));
    long place[2];
    for (size_t k = 0; k < 2; k++) {
        size_t here = at_index(rd, k);
        int size = k ? cols : rows;
        if (!read_integer(rd, json_array_get(v, k), -(1L << 31), 1L << 31, &place[k]))
            return false;
        if (place[k] < 0 || place[k] >= size)
            return at_fail(rd, SGA_E_SHAPE, "%s %ld lies outside A, which has %d (counted from 0)",
                           k ? "column" : "row", place[k], size);
        at_back(rd, here);
    }
    size_t here = at_index(rd, 2);
    if (!add_entry(rd, m, (int)place[0], (int)place[1], json_array_get(v, 2)))
        return false;
    at_back(rd, here);
    return true;
}

static bool read_sparse(struct reader *rd, struct matrix *m, const json_t *v, int rows, int cols, bool transpose)
{
    static const char *const members[] = { "rows", "cols", "entries", NULL };
    const char *per_row = transpose ? "variables" : "alpha", *per_col = transpose ? "alpha" : "variables";
    if (!only_members(rd, v, members) || !read_size(rd, v, "rows", rows, per_row)
        || !read_size(rd, v, "cols", cols, per_col))
        return false;
    const json_t *entries = need_member(rd, v, "entries");
    if (!entries)
        return false;
    size_t mark = at_member(rd, "entries");
    if (!json_is_array(entries))
        return expected(rd, "an array of entries [row, column, expression]", entries);
    for (size_t i = 0; i < json_array_size(entries); i++) {
        size_t here = at_index(rd, i);
        if (!read_triple(rd, m, json_array_get(entries, i), rows, cols))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

/* A list of expressions under a member; caller frees. count -1: the member is absent. */
static bool read_list(struct reader *rd, const json_t *system, const char *member, expr_id **list, int *count)
{
    const json_t *v = json_object_get(system, member);
    *list = NULL;
    *count = -1;
    if (!v)
        return true;
    size_t mark = at_member(rd, member), n = list_size(v);
    if (n > 16u * REQUEST_MAX_VARIABLES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu entries; the limit is %d", n, 16 * REQUEST_MAX_VARIABLES);
    *list = sga_calloc(n + 1, sizeof **list);
    for (size_t i = 0; i < n; i++) {
        size_t here = at_item(rd, v, i);
        if (!((*list)[i] = read_expression(rd, list_item(v, i), NULL)))
            return false;
        at_back(rd, here);
    }
    *count = (int)n;
    at_back(rd, mark);
    return true;
}

static bool read_matrix(struct reader *rd, const json_t *system, struct matrix *m, struct form_quasilinear *q, int equations)
{
    const json_t *v = need_member(rd, system, "A");
    if (!v)
        return false;
    q->rows = q->transpose ? q->variables : equations;
    q->cols = q->transpose ? equations : q->variables;
    size_t mark = at_member(rd, "A");
    if (!(json_is_object(v) ? read_sparse : read_dense)(rd, m, v, q->rows, q->cols, q->transpose))
        return false;
    at_back(rd, mark);
    return true;
}

bool read_quasilinear(struct reader *rd, const json_t *system)
{
    struct form_quasilinear q = { 0 };
    struct matrix m = { 0 };
    expr_id *alpha = NULL, *restriction = NULL;
    int equations = 0, restrictions = 0;
    const json_t *transpose = json_object_get(system, "transpose");
    if (transpose) {
        size_t mark = at_member(rd, "transpose");
        if (!read_boolean(rd, transpose, &q.transpose))
            return false;
        at_back(rd, mark);
    }
    int *variable = read_variables(rd, system, "variables", &q.variables);
    bool ok = variable && need_member(rd, system, "alpha") && read_list(rd, system, "alpha", &alpha, &equations)
        && read_list(rd, system, "restrict", &restriction, &restrictions)
        && read_matrix(rd, system, &m, &q, equations);
    if (ok && equations == 0 && restrictions <= 0)
        ok = at_fail(rd, SGA_E_EMPTY_SYSTEM, "the system has no equation: A and alpha are empty");
    if (ok) {
        q.variable = variable;
        q.entry = m.entry;
        q.entries = m.entries;
        q.alpha = alpha;
        q.restriction = restriction;
        q.restrictions = restrictions > 0 ? restrictions : 0;
        form_quasilinear(&rd->r->system, &q);
    }
    free(variable);
    free(alpha);
    free(restriction);
    free(m.entry);
    return ok;
}
