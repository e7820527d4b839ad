/* Long rows are cut to some of their entries. */
#include "sparse_work.h"

#include <assert.h>
#include <stdint.h>

/* The n-th smallest of the count keys, which are moved (Hoare's selection). */
static uint64_t nth_smallest(uint64_t *key, int count, int n)
{
    int low = 0, high = count - 1;
    while (low < high) {
        uint64_t middle = key[low + (high - low) / 2];
        int i = low, j = high;
        while (i <= j) {
            while (key[i] < middle)
                i++;
            while (key[j] > middle)
                j--;
            if (i <= j) {
                uint64_t k = key[i];
                key[i++] = key[j];
                key[j--] = k;
            }
        }
        if (n <= j)
            high = j;
        else if (n >= i)
            low = i;
        else
            break;
    }
    return key[n];
}

/* The order in which entries of a long row stay: those of columns of few rows, which become pivots first, and of these any, for each row others. */
static uint64_t order_of(const struct points_work *w, int i, int k)
{
    int c = w->lu->row[i].col[k];
    uint32_t mixed = ((uint32_t)c * 40503u + (uint32_t)i) * 2654435761u;
    return (uint64_t)w->first[c] << 56 | (uint64_t)mixed << 24 | (uint64_t)(k & 0xffffff);
}

static int kept_entries(const struct points_work *w, const struct points_row *r)
{
    int count = 0;
    for (int k = 0; k < r->len && w->kept; k++)
        count += w->kept[r->col[k]];
    return count;
}

void points_cut_row(struct points_work *w, int i)
{
    struct points_row *r = w->lu->row + i;
    int kept = kept_entries(w, r), left = kept + w->others;
    if (r->len <= left + w->others)
        return;
    SGA_ARENA(mem);
    uint64_t *key = sga_take(&mem, (size_t)r->len * sizeof *key);
    int others = 0, to = 0;
    for (int k = 0; k < r->len; k++)
        if (!w->kept || !w->kept[r->col[k]])
            key[others++] = order_of(w, i, k);
    uint64_t most = nth_smallest(key, others, w->others - 1);
    for (int k = 0; k < r->len; k++) {
        if ((w->kept && w->kept[r->col[k]]) || order_of(w, i, k) <= most) {
            r->col[to] = r->col[k];
            r->val[to++] = r->val[k];
        } else {
            w->count[r->col[k]]--;
        }
    }
    r->len = to;
    assert(to == left);
}
