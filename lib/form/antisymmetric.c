/* A 2-form's matrix is antisymmetric: entries against those across the diagonal. */
#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "form.h"
#include "mem.h"
#include "probe.h"

struct place {
    int low, high;             /* row and column, in order */
    size_t entry;
};

static int by_place(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    if (x->low != y->low)
        return x->low < y->low ? -1 : 1;
    if (x->high != y->high)
        return x->high < y->high ? -1 : 1;
    return x->entry < y->entry ? -1 : x->entry > y->entry;
}

size_t form_not_antisymmetric(struct expr_store *st, const struct form_matrix *m)
{
    SGA_FREED struct place *p = sga_malloc((m->entries + 1) * sizeof *p);
    SGA_ENDS(form_probe_clear) struct form_probe probe;
    size_t bad = m->entries;
    for (size_t k = 0; k < m->entries; k++) {
        int i = m->entry[k].row, j = m->entry[k].col;
        assert(i < m->rows && j < m->cols);
        p[k] = (struct place){ i < j ? i : j, i < j ? j : i, k };
    }
    qsort(p, m->entries, sizeof *p, by_place);
    form_probe_init(&probe);
    for (size_t k = 0, next; k < m->entries && bad == m->entries; k = next) {
        expr_id sum = expr_int(st, 0);
        for (next = k; next < m->entries && p[next].low == p[k].low && p[next].high == p[k].high; next++)
            sum = expr_add(st, sum, m->entry[p[next].entry].value);
        if (!form_probe_zero(&probe, st, sum))
            bad = p[k].entry;
    }
    return bad;
}
