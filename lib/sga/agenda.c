/* The agenda of an elimination: rows filed by length, columns by the rows that meet them, the next pivot. */
#include "agenda.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "echelon.h"
#include "facts.h"
#include "oracle.h"
#include "system.h"

/* What row i adds to the sums. */
static void count(struct agenda *a, int i, struct agenda_size now)
{
    struct agenda_size *was = a->size + i;
    a->left += (now.entries > 0) - (was->entries > 0);
    a->entries += now.entries - was->entries;
    a->functions += now.functions - was->functions;
    *was = now;
}

void agenda_file_row(struct agenda *a, int i)
{
    int len = a->row[i].entries;
    struct agenda_size now = { len, 0 };
    for (int k = 0; k < len; k++)
        now.functions += !expr_is_const(a->c->st, a->row[i].entry[k].value);
    count(a, i, now);
    assert(len <= a->cols && !a->done[i]);
    SGA_RESERVE_IN(&a->mem, a->bucket[len], a->bucket_cap[len], a->bucket_len[len] + 1);
    a->bucket[len][a->bucket_len[len]++] = i;
    if (len < a->lowest)
        a->lowest = len;
}

void agenda_file_column(struct agenda *a, int col, int i)
{
    assert(col < a->cols);
    SGA_RESERVE_IN(&a->mem, a->meet[col], a->meet_cap[col], a->meet_len[col] + 1);
    a->meet[col][a->meet_len[col]++] = i;
}

void agenda_done(struct agenda *a, int i)
{
    a->done[i] = 1;
    count(a, i, (struct agenda_size){ 0 });
}

void agenda_init(struct agenda *a, const struct ech_context *c, struct ech_row *row, int rows, int cols)
{
    size_t lens = (size_t)cols + 1;
    *a = (struct agenda){ .c = c, .row = row, .rows = rows, .cols = cols, .lowest = cols };
    a->done = sga_zeros(&a->mem, (size_t)rows, 1);
    a->size = sga_zeros(&a->mem, (size_t)rows + 1, sizeof *a->size);
    a->bucket = sga_zeros(&a->mem, lens, sizeof *a->bucket);
    a->bucket_len = sga_zeros(&a->mem, lens, sizeof *a->bucket_len);
    a->bucket_cap = sga_zeros(&a->mem, lens, sizeof *a->bucket_cap);
    a->meet = sga_zeros(&a->mem, lens, sizeof *a->meet);
    a->meet_len = sga_zeros(&a->mem, lens, sizeof *a->meet_len);
    a->meet_cap = sga_zeros(&a->mem, lens, sizeof *a->meet_cap);
    for (int i = rows - 1; i >= 0; i--)
        agenda_file_row(a, i);
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < row[i].entries; k++)
            agenda_file_column(a, row[i].entry[k].col, i);
    at_start_init(&a->start, c);
}

void agenda_clear(struct agenda *a)
{
    sga_arena_end(&a->mem);
    at_start_clear(&a->start);
}

/* Whether e, which is no zero in general, is one where a motion is to start. */
static bool is_idle(struct agenda *a, expr_id e)
{
    size_t had = a->idle_cap, need = (size_t)e + 1;
    if (!a->start.known)
        return false;
    SGA_RESERVE_IN(&a->mem, a->idle, a->idle_cap, need);
    if (a->idle_cap > had)
        memset(a->idle + had, 0, a->idle_cap - had);
    if (!a->idle[e])
        a->idle[e] = at_start_vanishes(&a->start, a->c, e) ? 2 : 1;
    return a->idle[e] == 2;
}

static bool is_mixed(const struct agenda *a, expr_id e)
{
    for (int i = 0; i < a->mixes; i++)
        if (a->mixed[i] == e)
            return true;
    return false;
}

/* The last kind of pivots; and an entry that is 0 where a motion is to start comes after those of the same rows that are not. */
enum { ANY = 6, IDLE = 1 };

/* Where pivots are to be large at a place: bits by which they may be smaller there at no cost, what each one more costs, and from how many on they
 * come after all others, of longer rows too. */
enum { FAINT_FREE = 3, FAINT_BIT = 2, FAINT = 9, LAST = 1000000 };

/* Of so few rows that what they fill does not matter: entries that may vanish come after all that do not, of longer rows too. What is divided by vanishes
 * somewhere, and there a row that has nothing to be divided by says what another, made by a division, does not. Those that vanish where a motion is to
 * start come after all of these. */
enum { FEW_ROWS = 24, MAY_VANISH = LAST / 10 };     /* more than these can fill */

/* Constants first, then what never vanishes, then parameters, then the rest. */
static int kind_of(const struct ech_context *c, expr_id e)
{
    unsigned f = expr_facts_of(c->facts, c->st, e);
    if (expr_is_const(c->st, e))
        return expr_is_one(c->st, e) || expr_is_int(c->st, e, -1) ? 0 : 1;
    if (!(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
        return 2;
    return f & EXPR_NONZERO ? 3 : ANY;
}

/* Numbers much smaller than others of a long row are no pivots: marching through a discrete Laplacian by its
 * neighbours (1 beside -4) multiplies errors by 5.8 in each row of the grid. Below which magnitude. */
enum { LONG_ROW = 4 };
#define MUCH_SMALLER 1.5       /* bits */

static double least_pivot(const struct ech_context *c, const struct ech_row *r)
{
    double most = -INFINITY;
    for (int k = 0; k < r->entries && r->entries >= LONG_ROW; k++)
        if (expr_is_const(c->st, r->entry[k].value))
            most = fmax(most, points_oracle_magnitude(c->oracle, r->entry[k].value));
    return most - MUCH_SMALLER;
}

/* What an entry that is no constant costs where a motion is to start, or is. */
static double faint_cost(struct agenda *a, expr_id e)
{
    if (!a->c->near_pivots)
        return is_idle(a, e) ? IDLE : 0;
    double bits = at_start_faintness(&a->start, a->c, e);
    return bits >= FAINT ? LAST + bits : FAINT_BIT * fmax(0, bits - FAINT_FREE);
}

/* The rows of a length, latest first, while stale members are dropped from their end: never more is looked at than is asked for. */
struct shortest {
    int left, place, end;         /* of the bucket: [0, left) not looked at, [place, end) looked at, and they stay */
};

static int next_row(struct agenda *a, int len, struct shortest *s)
{
    while (s->left > 0) {
        int i = a->bucket[len][--s->left];
        if (a->done[i] || a->row[i].entries != len)
            continue;
        a->bucket[len][--s->place] = i;
        return i;
    }
    return -1;
}

static void keep_rows(struct agenda *a, int len, const struct shortest *s)
{
    assert(s->left <= s->place && s->place <= s->end);
    if (s->left < s->place)
        memmove(a->bucket[len] + s->left, a->bucket[len] + s->place, (size_t)(s->end - s->place) * sizeof *a->bucket[len]);
    a->bucket_len[len] = s->left + s->end - s->place;
}

/* What is best so far: smaller scores are better. */
struct choice { double score; int row, at; };

static void look_at_row(struct agenda *a, int i, struct choice *best)
{
    const struct ech_context *c = a->c;
    const struct ech_row *r = a->row + i;
    double least = least_pivot(c, r);
    for (int k = 0; k < r->entries; k++) {
        const struct sys_entry entry = r->entry[k];
        if (!a->sided && is_mixed(a, entry.value))
            continue;
        double fill = 4.0 * (r->entries - 1) * (a->meet_len[entry.col] - 1);
        double size = points_oracle_magnitude(c->oracle, entry.value);
        int kind = kind_of(c, entry.value);
        double score = fill + 2 * kind - 1e-3 * fmin(200, fmax(-200, size));
        if (kind == ANY)
            score += faint_cost(a, entry.value) + (a->rows <= FEW_ROWS ? MAY_VANISH * (is_idle(a, entry.value) ? 2 : 1) : 0);
        if (score < best->score && !(size < least && expr_is_const(c->st, entry.value)))
            *best = (struct choice){ score, i, k };
    }
}

bool agenda_choose(struct agenda *a, int *out_row, int *out_at)
{
    enum { ROWS = 6 };
    const bool near = a->c->near_pivots, all = near || a->rows <= FEW_ROWS;      /* longer rows are looked at, too */
    const double late = a->rows <= FEW_ROWS ? MAY_VANISH : near ? LAST : INFINITY;      /* from here on entries are taken where there are no others */
    int seen = 0, shortest = -1;
    struct choice best = { INFINITY, -1, -1 };
    for (int len = a->lowest; len <= a->cols && best.score >= late; len++) {
        struct shortest s = { a->bucket_len[len], a->bucket_len[len], a->bucket_len[len] };
        a->lowest = all && shortest >= 0 ? shortest : len + 1;
        while (best.score >= late || seen < ROWS) {
            int i = next_row(a, len, &s);
            if (i < 0)
                break;
            shortest = shortest < 0 ? len : shortest;
            a->lowest = all ? shortest : len;
            seen++;
            if (len == 0) {
                best = (struct choice){ -INFINITY, i, -1 };
                break;
            }
            look_at_row(a, i, &best);
        }
        keep_rows(a, len, &s);
    }
    *out_row = best.row;
    *out_at = best.at;
    return best.row >= 0 && !(near && a->c->wait && best.score >= LAST);
}

/* Where every row that is left is long, the rest is a dense block. Blocks of numbers are
 * better eliminated: their entries stay numbers. */
enum { BLOCK_LENGTH = 8, BLOCK_ROWS = 8 };

/* A number beside functions that are so many times (in bits) larger: quotients of such rows by each other swell, and lose all digits, as
 * soon as rows have so many entries. Of more rows the sparse ones are eliminated first: a dense block costs their cube. */
enum { FAINT_BITS = 10, FAINT_LENGTH = 3, FAINT_ROWS = 64 };

static bool is_faint(const struct ech_context *c, const struct ech_row *r, int at)
{
    expr_id pivot = r->entry[at].value;
    if (!expr_is_const(c->st, pivot))
        return false;
    double least = points_oracle_magnitude(c->oracle, pivot) + FAINT_BITS;
    bool faint = false;
    for (int k = 0; k < r->entries && !faint; k++)
        faint = !expr_is_const(c->st, r->entry[k].value) && points_oracle_magnitude(c->oracle, r->entry[k].value) > least;
    return faint;
}

bool agenda_is_block(const struct agenda *a, int i, int at)
{
    int length = a->row[i].entries;
    if (length < FAINT_LENGTH || a->left < BLOCK_ROWS || a->entries < a->left * FAINT_LENGTH || 4 * a->functions < a->entries)
        return false;
    return (length >= BLOCK_LENGTH && a->entries >= a->left * BLOCK_LENGTH) || (a->left <= FAINT_ROWS && is_faint(a->c, a->row + i, at));
}
