/* Families found: entries by shape, runs in each shape, rows of runs. Each is printed, expanded again and compared before it counts. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "family.h"
#include "mem.h"

bool families_letters(bool taken[26], struct families_letters *out)
{
    static const char order[] = "ijkmnpqrlabcdghuvwxyz";
    int found = 0;
    for (const char *c = order; *c && found < 2; c++)
        if (!taken[*c - 'a'])
            (found++ ? out->inner : out->outer)[0] = *c;
    out->inner[1] = out->outer[1] = 0;
    return found == 2;
}

/* What an entry of the new list is made of. */
struct made { long place; size_t at, length; };

struct fold {
    const struct families_how *how;
    struct sga_arena *mem;
    bool object;
    const struct entry **at; int entries;      /* by shape, then in their order */
    bool *said;                                /* by place: a family stands for it */
    struct sga_buf text;                       /* of families */
    struct made *made; size_t families, room;
};

static int by_shape(const void *a, const void *b)
{
    const struct entry *x = *(const struct entry *const *)a, *y = *(const struct entry *const *)b;
    if (x->shape != y->shape)
        return x->shape < y->shape ? -1 : 1;
    if (x->slots != y->slots)
        return x->slots - y->slots;
    return x->text < y->text ? -1 : x->text > y->text;
}

static bool same_group(const struct entry *a, const struct entry *b)
{
    return a->shape == b->shape && a->slots == b->slots;
}

/* Is d - c what b - a is? In an object places do not count. */
static bool same_step(const struct fold *f, const struct entry *a, const struct entry *b, const struct entry *c, const struct entry *d)
{
    if (!f->object && b->place - a->place != d->place - c->place)
        return false;
    for (int k = 0; k < a->slots; k++)
        if (b->value[k] - a->value[k] != d->value[k] - c->value[k])
            return false;
    return true;
}

/* How many entries from e[0] on grow by constant steps, of the n of a group. */
static int run_length(const struct fold *f, const struct entry *const *e, int n)
{
    int k = 2;
    if (n < 2)
        return n;
    while (k < n && same_step(f, e[0], e[1], e[k - 1], e[k]))
        k++;
    return k;
}

/* A run of a group: entries from its first on. */
struct run { const struct entry *const *at; int count; bool used; };

/* Between rows of a grid there may be so many runs of others: those of its borders. */
enum { BETWEEN = 8 };

/* The run that goes on from the last of `rows` by a constant jump; -1: none. */
static int next_row(const struct fold *f, const struct run *run, int runs, const int *row, int rows)
{
    const struct run *first = run + row[0], *last = run + row[rows - 1];
    for (int k = row[rows - 1] + 1; k < runs && k <= row[rows - 1] + BETWEEN; k++) {
        const struct run *r = run + k;
        if (r->used || r->count != first->count || !same_step(f, first->at[0], first->at[1], r->at[0], r->at[1]))
            continue;
        return rows == 1 || same_step(f, first->at[0], run[row[1]].at[0], last->at[0], r->at[0]) ? k : -1;
    }
    return -1;
}

struct check { const struct fold *f; const struct family *family; int k; };

static bool says(const struct entry *e, const struct sga_buf *text)
{
    return text->len == e->length && memcmp(text->data, e->text, text->len) == 0;
}

/* An entry that was expanded from what was printed, against what it was. */
static bool is_same(void *ctx, long place, const struct sga_buf *text)
{
    struct check *c = ctx;
    const struct family *f = c->family;
    if (c->k >= f->count * f->rows)
        return false;
    const struct entry *e = f->at[c->k], *across = f->at[c->k % f->rows * f->count + c->k / f->rows];
    c->k++;
    /* passes of a name's indices run by their order in it, which may not be that of the rows */
    return c->f->object ? says(e, text) || says(across, text) : place == e->place && says(e, text);
}

/* Printed, and read back. */
static bool add_family(struct fold *f, const struct family *family, const struct entry *list)
{
    SGA_ARENA(mem);
    size_t start = f->text.len;
    struct folded folded;
    struct check check = { f, family, 0 };
    bool ok = family_print(family, &f->how->letters, &f->text);
    const char *text = f->text.data + start;
    size_t length = f->text.len - start;
    if (ok && f->object)
        ok = folded_member_each(text, length, is_same, &check, &mem);
    else if (ok)
        ok = folded_read(text, length, &folded, &mem) && folded.count == (long)family->count * family->rows && folded_each(&folded, is_same, &check);
    if (!ok || check.k != family->count * family->rows) {
        f->text.len = start;
        return false;
    }
    SGA_RESERVE_IN(f->mem, f->made, f->room, f->families + 1);
    f->made[f->families++] = (struct made){ family->at[0] - list, start, length };
    for (int k = 0; k < family->count * family->rows; k++)
        f->said[family->at[k] - list] = true;
    return true;
}

/* The run with those that are rows of a grid with it, or alone. */
static void fold_rows(struct fold *f, struct run *run, int runs, int k, const struct entry *list)
{
    SGA_ARENA(mem);
    int *row = sga_take(&mem, (size_t)(runs - k) * sizeof *row), rows = 1;
    row[0] = k;
    for (int next; (next = next_row(f, run, runs, row, rows)) >= 0;)
        row[rows++] = next;
    struct family family = { .count = run[k].count, .rows = rows, .object = f->object };
    const struct entry **at = sga_take(&mem, (size_t)rows * (size_t)family.count * sizeof *at);
    for (int r = 0; r < rows; r++)
        memcpy(at + r * family.count, run[row[r]].at, (size_t)family.count * sizeof *at);
    family.at = at;
    bool made = rows >= f->how->least && add_family(f, &family, list);
    if (!made) {
        family.rows = rows = 1;
        add_family(f, &family, list);
    }
    for (int r = 0; r < rows; r++)
        run[row[r]].used = true;
}

/* The families of one shape; what is in none goes to the front of e. Their number. */
static int fold_group(struct fold *f, const struct entry *list, const struct entry **e, int n)
{
    SGA_ARENA(mem);
    struct run *run = sga_take(&mem, (size_t)(n / f->how->least + 1) * sizeof *run);
    const struct entry **rest = sga_take(&mem, (size_t)n * sizeof *rest);
    int runs = 0, left = 0;
    for (int k = 0, count; k < n; k += count) {
        count = run_length(f, e + k, n - k);
        struct family family = { .at = e + k, .count = count, .rows = 1, .object = f->object };
        if (count >= f->how->least && family_sayable(&family))
            run[runs++] = (struct run){ e + k, count, false };
        else
            count = 1, rest[left++] = e[k];
    }
    for (int k = 0; k < runs; k++)
        if (!run[k].used)
            fold_rows(f, run, runs, k, list);
    memcpy(e, rest, (size_t)left * sizeof *e);
    return left;
}

/* Borders of a grid are runs once its rows are taken out; those of two sides take turns. */
enum { TURNS = 4 };

static void fold_shape(struct fold *f, const struct entry *list, const struct entry **e, int n)
{
    SGA_ARENA(mem);
    int least = f->how->least;
    for (int left; n >= least && (left = fold_group(f, list, e, n)) < n;)
        n = left;
    for (int turns = 2; turns <= TURNS && n >= turns * least; turns++) {
        struct sga_mark mark = sga_arena_mark(&mem);
        const struct entry **part = sga_take(&mem, (size_t)n * sizeof *part), **rest = sga_take(&mem, (size_t)n * sizeof *rest);
        int left = 0;
        for (int first = 0; first < turns; first++) {
            int count = 0;
            for (int k = first; k < n; k += turns)
                part[count++] = e[k];
            count = fold_group(f, list, part, count);
            memcpy(rest + left, part, (size_t)count * sizeof *part);
            left += count;
        }
        qsort(rest, (size_t)left, sizeof *rest, by_shape);       /* in their order again */
        memcpy(e, rest, (size_t)left * sizeof *e);
        n = left;
        sga_arena_release(&mem, &mark);
    }
}

static int by_place(const void *a, const void *b)
{
    const struct made *x = a, *y = b;
    return x->place < y->place ? -1 : x->place > y->place;
}

/* The list anew: families where their first entry was, the others as they were. */
static void write_list(struct fold *f, const struct entry *list, struct sga_buf *out, char open)
{
    const char *comma = "";
    size_t next = 0;
    qsort(f->made, f->families, sizeof *f->made, by_place);
    sga_buf_put(out, &open, 1);
    for (int i = 0; i < f->entries; i++) {
        bool first = next < f->families && f->made[next].place == i;
        if (f->said[i] && !first)
            continue;
        sga_buf_puts(out, comma);
        comma = ",";
        if (first)
            sga_buf_put(out, f->text.data + f->made[next].at, f->made[next].length), next++;
        else
            sga_buf_put(out, list[i].text, list[i].length);
    }
    assert(next == f->families);
    sga_buf_puts(out, open == '[' ? "]" : "}");
}

static void read_entries(struct fold *f, struct entry *list)
{
    SGA_FREED long *value = NULL;
    size_t room = 0;
    f->at = sga_zeros(f->mem, (size_t)f->entries, sizeof *f->at);
    f->said = sga_zeros(f->mem, (size_t)f->entries, sizeof *f->said);
    for (int i = 0; i < f->entries; i++) {
        struct entry *e = list + i;
        SGA_RESERVE(value, room, e->length);         /* a number has a byte or more */
        e->slots = family_slots(e->text, e->length, NULL, value, &e->shape);
        e->value = sga_take(f->mem, (size_t)e->slots * sizeof *value);
        memcpy(e->value, value, (size_t)e->slots * sizeof *value);
        f->at[i] = e;
    }
    qsort(f->at, (size_t)f->entries, sizeof *f->at, by_shape);
}

bool families_fold(struct sga_buf *out, size_t start, const struct families_how *how)
{
    assert(how->least >= 2 && start < out->len);
    SGA_ARENA(mem);
    SGA_ENDS(sga_buf_free) struct sga_buf whole = { 0 };
    char open = out->data[start];
    struct fold f = { .how = how, .mem = &mem, .object = open == '{' };
    struct entry *list = family_entries(out->data + start, out->data + out->len, &f.entries, &mem);
    if (f.entries <= how->longest)
        return false;
    read_entries(&f, list);
    for (int i = 0, end; i < f.entries; i = end) {
        for (end = i + 1; end < f.entries && same_group(f.at[i], f.at[end]); end++)
            ;
        fold_shape(&f, list, f.at + i, end - i);
    }
    if (f.families) {
        write_list(&f, list, &whole, open);
        assert(whole.len <= out->len - start + 64 * f.families);
        out->len = start;
        sga_buf_put(out, whole.data, whole.len);
    }
    sga_buf_free(&f.text);
    return f.families > 0;
}
