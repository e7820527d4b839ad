/* The sparse system: plain growing arrays, entries of a row kept in order. */
#include "system.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"

/* The arrays of a system carry a count and no capacity: they grow when the count is
 * a power of two (or 0). */
static bool is_full(int count)
{
    return (count & (count - 1)) == 0;
}

#define GROW(array, count) \
    do { \
        if (is_full(count)) \
            (array) = sga_realloc((array), ((count) ? 2 * (size_t)(count) : 1) * sizeof *(array)); \
    } while (0)

void sys_init(struct sys_system *s, struct expr_store *st)
{
    *s = (struct sys_system){ .store = st, .time = -1 };
}

void sys_clear_rows(struct sys_system *s)
{
    for (int i = 0; i < s->rows; i++) {
        free(s->row[i].entry);
        free((char *)s->row[i].source);
    }
    free(s->row);
    s->row = NULL;
    s->rows = 0;
}

void sys_clear(struct sys_system *s)
{
    sys_clear_rows(s);
    free(s->variable);
    free(s->restriction);
    free(s->parameter);
    free(s->signal);
    *s = (struct sys_system){ .time = -1 };
}

void sys_add_variable(struct sys_system *s, int symbol, const char *role)
{
    assert(symbol >= 0 && symbol < s->store->symbols);
    GROW(s->variable, s->variables);
    s->variable[s->variables++] = (struct sys_variable){ .symbol = symbol, .role = role };
}

int sys_add_row(struct sys_system *s, expr_id alpha, const char *source)
{
    GROW(s->row, s->rows);
    s->row[s->rows] = (struct sys_row){ .alpha = alpha, .source = sga_strdup(source) };
    return s->rows++;
}

/* The place of the first entry whose column is not less than col. */
static int place(const struct sys_row *r, int col)
{
    int low = 0, high = r->entries;
    if (high && r->entry[high - 1].col < col)
        return high;                       /* the usual case: in order */
    while (low < high) {
        int mid = (low + high) / 2;
        if (r->entry[mid].col < col)
            low = mid + 1;
        else
            high = mid;
    }
    return low;
}

void sys_add_entry(struct sys_system *s, int row, int col, expr_id value)
{
    assert(row >= 0 && row < s->rows && col >= 0 && col < s->variables);
    struct sys_row *r = s->row + row;
    int k = place(r, col);
    bool there = k < r->entries && r->entry[k].col == col;
    if (there)
        value = r->entry[k].value = expr_add(s->store, r->entry[k].value, value);
    size_t tail = (size_t)(r->entries - k);
    if (there && expr_is_zero(s->store, value)) {
        memmove(r->entry + k, r->entry + k + 1, (tail - 1) * sizeof *r->entry);
        r->entries--;
    }
    if (there || expr_is_zero(s->store, value))
        return;
    GROW(r->entry, r->entries);
    memmove(r->entry + k + 1, r->entry + k, tail * sizeof *r->entry);
    r->entry[k] = (struct sys_entry){ .col = col, .value = value };
    r->entries++;
}

void sys_add_restriction(struct sys_system *s, expr_id e)
{
    GROW(s->restriction, s->restrictions);
    s->restriction[s->restrictions++] = e;
}

void sys_add_parameter(struct sys_system *s, int symbol)
{
    assert(symbol >= 0 && symbol < s->store->symbols);
    GROW(s->parameter, s->parameters);
    s->parameter[s->parameters++] = symbol;
}

void sys_add_signal(struct sys_system *s, int symbol)
{
    GROW(s->signal, s->signals);
    s->signal[s->signals++] = symbol;
}

int sys_expressions(const struct sys_system *s, expr_id **list)
{
    int total = s->rows, at = 0;
    for (int i = 0; i < s->rows; i++)
        total += s->row[i].entries;
    *list = sga_malloc(((size_t)total + 1) * sizeof **list);
    for (int i = 0; i < s->rows; i++) {
        for (int k = 0; k < s->row[i].entries; k++)
            (*list)[at++] = s->row[i].entry[k].value;
        (*list)[at++] = s->row[i].alpha;
    }
    return at;
}

static bool row_sane(const struct sys_system *s, const struct sys_row *r)
{
    bool sane = r->alpha > 0 && r->alpha < s->store->nodes;
    for (int k = 0; k < r->entries && sane; k++)
        sane = r->entry[k].col >= (k ? r->entry[k - 1].col + 1 : 0) && r->entry[k].col < s->variables
               && r->entry[k].value > 0 && r->entry[k].value < s->store->nodes && !expr_is_zero(s->store, r->entry[k].value);
    return sane;
}

bool sys_sane(const struct sys_system *s)
{
    bool sane = s->time >= 0 && s->time < s->store->symbols;
    SGA_FREED unsigned char *met = sga_calloc((size_t)s->store->symbols + 1, 1);
    for (int j = 0; j < s->variables && sane; j++) {
        int symbol = s->variable[j].symbol;
        sane = symbol >= 0 && symbol < s->store->symbols && !met[symbol]++;
    }
    for (int i = 0; i < s->parameters && sane; i++)
        sane = s->parameter[i] >= 0 && s->parameter[i] < s->store->symbols && !met[s->parameter[i]]++;
    for (int i = 0; i < s->rows && sane; i++)
        sane = row_sane(s, s->row + i);
    for (int i = 0; i < s->restrictions && sane; i++)
        sane = s->restriction[i] > 0 && s->restriction[i] < s->store->nodes;
    return sane;
}
