/* Sparse elimination modulo a prime. */
#include "exact_rank.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include <flint/ulong_extras.h>

#include "arena.h"
#include "budget.h"
#include "mem.h"

void exact_echelon_init(struct exact_echelon *e, int cols, int which)
{
    mp_limb_t p = UWORD(1) << 61;
    *e = (struct exact_echelon){ .cols = cols };
    for (int k = 0; k <= which; k++)
        p = n_nextprime(p, 1);
    nmod_init(&e->mod, p);
    e->pivot_of = sga_take(&e->mem, ((size_t)cols + 1) * sizeof *e->pivot_of);
    for (int j = 0; j < cols; j++)
        e->pivot_of[j] = -1;
    exact_sum_init(&e->sum, cols);
    e->residue = sga_zeros(&e->mem, (size_t)cols + 1, sizeof *e->residue);
    e->small = sga_zeros(&e->mem, (size_t)cols + 1, sizeof *e->small);
    e->work = sga_zeros(&e->mem, (size_t)cols + 1, sizeof *e->work);
    e->mark = sga_zeros(&e->mem, (size_t)cols + 1, 1);
}

void exact_echelon_clear(struct exact_echelon *e)
{
    for (int q = 0; q < e->pivots; q++) {
        free(e->pivot[q].entry);
        free(e->pivot[q].op);
    }
    for (int j = 0; e->residue && j < e->cols; j++)
        fmpz_clear(e->residue + j);
    exact_sum_clear(&e->sum);
    sga_arena_end(&e->mem);
    *e = (struct exact_echelon){ 0 };
}

void exact_echelon_cut(struct exact_echelon *e, int givens)
{
    assert(givens >= 0 && givens <= e->givens);
    while (e->pivots && e->pivot[e->pivots - 1].row >= givens) {      /* later rows have later pivots */
        struct exact_pivot *p = e->pivot + --e->pivots;
        e->pivot_of[p->col] = -1;
        free(p->entry);
        free(p->op);
    }
    e->givens = givens;
}

/* A row on its way through the elimination. */
struct moving {
    struct exact_entry *entry; int entries; size_t cap;
    struct exact_op *op; int ops; size_t op_cap;
    bool done;
};

struct lists {
    struct sga_arena *mem;
    int **at; int *count; size_t *cap;
};

static void lists_init(struct lists *l, struct sga_arena *mem, int n)
{
    l->mem = mem;
    l->at = sga_zeros(mem, (size_t)n + 1, sizeof *l->at);
    l->count = sga_zeros(mem, (size_t)n + 1, sizeof *l->count);
    l->cap = sga_zeros(mem, (size_t)n + 1, sizeof *l->cap);
}

static void lists_push(struct lists *l, int k, int i)
{
    SGA_RESERVE_IN(l->mem, l->at[k], l->cap[k], l->count[k] + 1);
    l->at[k][l->count[k]++] = i;
}

struct agenda {
    struct exact_echelon *e;
    struct moving *row; int rows;
    struct lists length, meet;     /* rows by number of entries, and by column; members may be stale */
    int *count;                    /* by column: rows that have an entry there */
    int lowest;
};

static void load(struct exact_echelon *e, const struct exact_row *r, struct moving *m)
{
    slong top = 0, exponent;
    for (int k = 0; k < r->entries; k++)
        top = fmpz_bits(r->value + k) > (mp_bitcnt_t)top ? (slong)fmpz_bits(r->value + k) : top;
    SGA_RESERVE(m->entry, m->cap, r->entries + 1);
    for (int k = 0; k < r->entries; k++) {
        mp_limb_t v = fmpz_fdiv_ui(r->value + k, e->mod.n);
        double d = fmpz_get_d_2exp(&exponent, r->value + k);
        if (v)
            m->entry[m->entries++] = (struct exact_entry){ r->col[k], v, exponent < top - 1000 ? 0 : ldexp(d, (int)(exponent - top)) };
    }
}

static int find(const struct moving *m, int col)
{
    for (int k = 0; k < m->entries; k++)
        if (m->entry[k].col == col)
            return k;
    return -1;
}

/* row -= factor * pivot row; columns new in it are its last entries, from *fresh on. count: by column, or NULL. */
static void subtract(struct exact_echelon *e, struct moving *m, int pivot, int at, int *fresh, int *count)
{
    const struct exact_pivot *p = e->pivot + pivot;
    assert(m->entry[at].col == p->col);
    mp_limb_t f = n_mulmod2_preinv(m->entry[at].value, p->inverse, e->mod.n, e->mod.ninv), minus = nmod_neg(f, e->mod);
    double size = m->entry[at].size / p->entry[p->entries].size;
    m->entry[at] = m->entry[--m->entries];
    for (int k = 0; k < m->entries; k++) {
        e->work[m->entry[k].col] = m->entry[k];
        e->mark[m->entry[k].col] = 1;
    }
    int old = m->entries, n = 0;
    SGA_RESERVE(m->entry, m->cap, old + p->entries);
    for (int k = 0; k < p->entries; k++) {
        const struct exact_entry *q = p->entry + k;
        mp_limb_t t = n_mulmod2_preinv(minus, q->value, e->mod.n, e->mod.ninv);
        if (!e->mark[q->col]) {
            m->entry[m->entries++] = (struct exact_entry){ q->col, t, -size * q->size };
            continue;
        }
        e->work[q->col].value = nmod_add(e->work[q->col].value, t, e->mod);
        e->work[q->col].size -= size * q->size;
    }
    for (int k = 0; k < m->entries; k++) {
        int col = m->entry[k].col;
        if (k == old)
            *fresh = n;
        if (k >= old)
            m->entry[n++] = m->entry[k];
        else if (e->work[col].value)
            m->entry[n++] = e->work[col];
        else if (count)
            count[col]--;
        e->mark[col] = 0;
    }
    if (old == m->entries)
        *fresh = n;
    m->entries = n;
    SGA_RESERVE(m->op, m->op_cap, m->ops + 1);
    m->op[m->ops++] = (struct exact_op){ pivot, f };
}

/* Rows of more entries are spread over the columns while they are reduced, and the pivots that wait are in a heap. */
enum { SPREAD = 64 };

/* The least pivot on top. */
struct heap { struct sga_arena *mem; int *pivot, count; size_t cap; };

static void heap_push(struct heap *h, int pivot)
{
    SGA_RESERVE_IN(h->mem, h->pivot, h->cap, h->count + 1);
    int k = h->count++;
    for (; k > 0 && h->pivot[(k - 1) / 2] > pivot; k = (k - 1) / 2)
        h->pivot[k] = h->pivot[(k - 1) / 2];
    h->pivot[k] = pivot;
}

static int heap_pop(struct heap *h)
{
    int top = h->pivot[0], last = h->pivot[--h->count], k = 0;
    for (int child; (child = 2 * k + 1) < h->count; k = child) {
        child += child + 1 < h->count && h->pivot[child + 1] < h->pivot[child];
        if (last <= h->pivot[child])
            break;
        h->pivot[k] = h->pivot[child];
    }
    h->pivot[k] = last;
    return top;
}

/* A column of the row that is spread: in e->work from now on, and its pivot in the heap. */
static void spread(struct exact_echelon *e, struct moving *m, struct heap *h, struct exact_entry entry)
{
    SGA_RESERVE(m->entry, m->cap, m->entries + 1);
    m->entry[m->entries++] = entry;
    e->work[entry.col] = entry;
    e->mark[entry.col] = 1;
    if (e->pivot_of[entry.col] >= 0)
        heap_push(h, e->pivot_of[entry.col]);
}

/* Cost: the entries of the pivots' rows, and a logarithm for each pivot. */
static void reduce_spread(struct exact_echelon *e, struct moving *m)
{
    SGA_ARENA(mem);
    struct heap h = { .mem = &mem };
    int given = m->entries, n = 0;
    m->entries = 0;
    for (int k = 0; k < given; k++)
        spread(e, m, &h, m->entry[k]);
    while (h.count) {
        int pivot = heap_pop(&h);
        const struct exact_pivot *p = e->pivot + pivot;
        struct exact_entry *at = e->work + p->col;
        assert(!h.count || h.pivot[0] > pivot);
        if (!at->value)
            continue;
        mp_limb_t f = n_mulmod2_preinv(at->value, p->inverse, e->mod.n, e->mod.ninv), minus = nmod_neg(f, e->mod);
        double size = at->size / p->entry[p->entries].size;
        at->value = 0;
        for (int k = 0; k < p->entries; k++) {
            const struct exact_entry *q = p->entry + k;
            mp_limb_t t = n_mulmod2_preinv(minus, q->value, e->mod.n, e->mod.ninv);
            if (!e->mark[q->col])
                spread(e, m, &h, (struct exact_entry){ q->col, 0, 0 });
            e->work[q->col].value = nmod_add(e->work[q->col].value, t, e->mod);
            e->work[q->col].size -= size * q->size;
        }
        SGA_RESERVE(m->op, m->op_cap, m->ops + 1);
        m->op[m->ops++] = (struct exact_op){ pivot, f };
    }
    for (int k = 0; k < m->entries; k++) {
        struct exact_entry entry = e->work[m->entry[k].col];
        e->mark[entry.col] = 0;
        if (entry.value)
            m->entry[n++] = entry;
    }
    m->entries = n;
}

/* The pivots so far are used up, in their order. */
static void reduce(struct exact_echelon *e, struct moving *m)
{
    if (m->entries > SPREAD) {
        reduce_spread(e, m);
        return;
    }
    for (;;) {
        int first = -1, at = -1, fresh;
        for (int k = 0; k < m->entries; k++) {
            int q = e->pivot_of[m->entry[k].col];
            if (q >= 0 && (first < 0 || q < first)) {
                first = q;
                at = k;
            }
        }
        if (first < 0)
            return;
        subtract(e, m, first, at, &fresh, NULL);
    }
}

static void file_row(struct agenda *a, int i)
{
    int n = a->row[i].entries;
    lists_push(&a->length, n, i);
    a->lowest = n < a->lowest ? n : a->lowest;
}

/* Numbers much smaller than others of a long row are no pivots: marching through a discrete Laplacian by its
 * neighbours multiplies errors in each row of the grid (as for functions: sga/echelon.c). */
enum { LONG_ROW = 4, ROWS_ASKED = 6 };
static const double MUCH_SMALLER = 0.35;

static double score(const struct agenda *a, const struct moving *m, const struct exact_entry *q, double most)
{
    mp_limb_t v = q->value;
    if (m->entries >= LONG_ROW && fabs(q->size) < MUCH_SMALLER * most)
        return INFINITY;
    double unit = v == 1 || v == a->e->mod.n - 1 ? 0 : 0.2, size = fabs(q->size) > 0 ? log2(fabs(q->size) / most) : -200;
    return 4.0 * (m->entries - 1) * (a->count[q->col] - 1) + unit - fmin(3, fmax(-3, size));
}

/* The last rows of n entries, the newest first; stale members on the way are dropped, and no others are looked at: each costs once. */
static int newest(struct agenda *a, int n, int row[ROWS_ASKED])
{
    int *list = a->length.at[n], left = a->length.count[n], found = 0;
    while (left && found < ROWS_ASKED) {
        int i = list[--left];
        if (!a->row[i].done && a->row[i].entries == n)
            row[found++] = i;
    }
    a->length.count[n] = left + found;
    for (int k = 0; k < found; k++)
        list[left + found - 1 - k] = row[k];
    return found;
}

/* The best pivot among a few of the shortest rows. False: none is left. */
static bool choose(struct agenda *a, int *row, int *at)
{
    double best = INFINITY;
    int asked[ROWS_ASKED], count = 0;
    a->lowest += a->lowest == 0;         /* what is empty has no pivot */
    while (a->lowest <= a->e->cols && !(count = newest(a, a->lowest, asked)))
        a->lowest++;
    for (int q = 0; q < count; q++) {
        const struct moving *m = a->row + asked[q];
        double most = 0;
        for (int k = 0; k < m->entries; k++)
            most = fmax(most, fabs(m->entry[k].size));
        for (int k = 0; k < m->entries; k++) {
            double s = score(a, m, m->entry + k, most);
            if (s < best || best == INFINITY) {
                best = fmin(s, 1e300);
                *row = asked[q];
                *at = k;
            }
        }
    }
    assert(!count || best < INFINITY);
    return count > 0;
}

static void take(struct agenda *a, int i, int at, int given)
{
    struct exact_echelon *e = a->e;
    struct moving *m = a->row + i;
    struct exact_entry t = m->entry[at];
    int index = e->pivots;
    assert(t.value && e->pivot_of[t.col] < 0 && e->pivot_of_row[given] < 0);
    for (int k = 0; k < m->entries; k++)
        a->count[m->entry[k].col]--;
    m->entry[at] = m->entry[m->entries - 1];
    m->entry[m->entries - 1] = t;        /* the pivot stands behind its row's entries */
    if (!(fabs(t.size) > 0 && isfinite(t.size)))
        m->entry[m->entries - 1].size = 1;
    SGA_RESERVE_IN(&e->mem, e->pivot, e->pivot_cap, index + 1);
    e->pivot[e->pivots++] = (struct exact_pivot){ .col = t.col, .row = given, .inverse = n_invmod(t.value, e->mod.n),
                                                  .entry = m->entry, .entries = m->entries - 1, .op = m->op, .ops = m->ops };
    e->pivot_of[t.col] = index;
    e->pivot_of_row[given] = index;
    *m = (struct moving){ .done = true };
    for (int q = 0; q < a->meet.count[t.col]; q++) {
        int r = a->meet.at[t.col][q], where = a->row[r].done ? -1 : find(a->row + r, t.col), fresh;
        if (where < 0)
            continue;
        subtract(e, a->row + r, index, where, &fresh, a->count);
        for (int k = fresh; k < a->row[r].entries; k++) {
            lists_push(&a->meet, a->row[r].entry[k].col, r);
            a->count[a->row[r].entry[k].col]++;
        }
        file_row(a, r);
    }
}

static void number_on(struct exact_echelon *e, const struct exact_row *const *row, int rows)
{
    SGA_RESERVE_IN(&e->mem, e->given, e->given_cap, e->givens + rows);
    SGA_RESERVE_IN(&e->mem, e->pivot_of_row, e->pivot_of_row_cap, e->givens + rows);
    SGA_RESERVE_IN(&e->mem, e->is_short, e->is_short_cap, e->givens + rows);
    for (int i = 0; i < rows; i++) {
        e->is_short[e->givens + i] = true;
        for (int k = 0; k < row[i]->entries; k++)
            e->is_short[e->givens + i] &= fmpz_bits(row[i]->value + k) <= EXACT_SHORT;
        e->given[e->givens + i] = row[i];
        e->pivot_of_row[e->givens + i] = -1;
    }
    e->givens += rows;
}

/* Each pivot has its column and its row to itself. Linear. */
static bool echelon_sane(const struct exact_echelon *e)
{
    bool sane = e->pivots <= e->cols && e->pivots <= e->givens;
    for (int q = 0; q < e->pivots && sane; q++)
        sane = e->pivot_of[e->pivot[q].col] == q && e->pivot_of_row[e->pivot[q].row] == q;
    return sane;
}

bool exact_echelon_add(struct exact_echelon *e, const struct exact_row *const *row, int rows,
                       const struct sga_budget *budget, struct sga_error *err)
{
    SGA_ARENA(mem);
    struct agenda a = { .e = e, .rows = rows, .lowest = e->cols };
    int first = e->givens, i, at = 0;
    bool ok = true;
    number_on(e, row, rows);
    a.row = sga_zeros(&mem, (size_t)rows + 1, sizeof *a.row);
    lists_init(&a.length, &mem, e->cols);
    lists_init(&a.meet, &mem, e->cols);
    a.count = sga_zeros(&mem, (size_t)e->cols + 1, sizeof *a.count);
    for (i = 0; i < rows && ok; i++) {
        load(e, row[i], a.row + i);
        reduce(e, a.row + i);
        for (int k = 0; k < a.row[i].entries; k++) {
            lists_push(&a.meet, a.row[i].entry[k].col, i);
            a.count[a.row[i].entry[k].col]++;
        }
        ok = sga_budget_ok(budget, err);
    }
    for (i = rows - 1; i >= 0; i--)
        file_row(&a, i);
    while (ok && choose(&a, &i, &at)) {
        take(&a, i, at, first + i);
        ok = sga_budget_ok(budget, err);
    }
    for (i = 0; i < rows; i++) {
        free(a.row[i].entry);
        free(a.row[i].op);
    }
    assert(echelon_sane(e));
    return ok;
}
