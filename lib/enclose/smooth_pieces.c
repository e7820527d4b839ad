/* Division of a time span by how a function of time varies. */
#include "smooth_pieces.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "error.h"
#include "mem.h"
#include "series.h"
#include "watch.h"

enum { ORDER = 6, BITS = 53 };
#define LEAST 1e-9         /* of the span */
#define BESIDE 0.01        /* of the distance to a singular place: shorter pieces are so for reasons of their own */
#define UNIFORM 8          /* pieces this many times shorter than the longest are no narrower than the rest: steps see what is everywhere */
#define OUTSIDE 1e-3       /* of the span: shorter pieces whose middle is outside of the domain are left alone */

struct piece { double from, to, excess; };

struct search {
    struct enc_program program;
    struct enc_series series;
    struct piece *heap;        /* the largest excess first; those that are done have excess 0 */
    int count;
    double span, small, largest;
    double *singular; size_t singular_cap;
    int singulars;
};

static void swap(struct piece *a, struct piece *b)
{
    struct piece c = *a;
    *a = *b;
    *b = c;
}

static void push(struct search *s, struct piece p)
{
    int i = s->count++;
    s->heap[i] = p;
    for (; i > 0 && s->heap[(i - 1) / 2].excess < s->heap[i].excess; i = (i - 1) / 2)
        swap(s->heap + i, s->heap + (i - 1) / 2);
}

static struct piece pop(struct search *s)
{
    struct piece top = s->heap[0];
    s->heap[0] = s->heap[--s->count];
    for (int i = 0, k = 1; k < s->count; i = k, k = 2 * i + 1) {
        k += k + 1 < s->count && s->heap[k + 1].excess > s->heap[k].excess;
        if (!(s->heap[k].excess > s->heap[i].excess))
            break;
        swap(s->heap + i, s->heap + k);
    }
    return top;
}

/* |coefficient k|, at the most (upper) or about. Too large for a double: INFINITY. */
static double size(const struct search *s, int k, bool upper)
{
    arb_srcptr c = enc_series_of(&s->series, s->program.root[0]) + k;
    SGA_ENDS(mag_end) mag_t m = { 0 };
    if (upper)
        arb_get_mag(m, c);
    return upper ? mag_get_d(m) : fabs(arf_get_d(arb_midref(c), ARF_RND_NEAR));
}

static double measure(struct search *s, double from, double to)
{
    double radius = 0.5 * (to - from), middle = from + radius, seen = 0, power = 1, hidden;
    SGA_ENDS(arb_end) arb_t t = { 0 };
    arb_set_d(t, middle);
    bool here = enc_series_run(&s->series, NULL, t, ORDER - 1, BITS);
    for (int k = 0; k < ORDER && here; k++, power *= radius) {
        double c = size(s, k, false) * power;
        s->largest = k == 0 ? fmax(s->largest, c) : s->largest;
        seen += k > 0 ? c : 0;
    }
    mag_set_d(arb_radref(t), radius);
    bool all = enc_series_run(&s->series, NULL, t, ORDER, BITS);
    hidden = all ? size(s, ORDER, true) * pow(radius, ORDER) : INFINITY;
    if (!here && to - from < OUTSIDE * s->span)
        return 0;
    if (!isfinite(hidden) || !here)
        return INFINITY;
    seen = fmax(seen, s->small * s->largest);
    return hidden <= seen || hidden < 1e-300 ? 0 : hidden / fmax(seen, 1e-300);
}

static int ascending(const void *a, const void *b)
{
    const struct piece *p = a, *q = b;
    return (p->from > q->from) - (p->from < q->from);
}

static double step_of(const struct search *s, const struct piece *p, double longest)
{
    double width = p->to - p->from, middle = p->from + 0.5 * width;
    if (UNIFORM * width >= longest)
        return INFINITY;
    for (int i = 0; i < s->singulars; i++)
        if (width >= BESIDE * fabs(s->singular[i] - middle))
            return INFINITY;
    return width;
}

bool enc_pieces_find(struct enc_pieces *q, const struct expr_store *st, expr_id u, int time, double from, double to, double small,
                     int most)
{
    assert(from <= to && most > 0);
    struct sga_error ignored = { 0 };
    struct search s = { .span = to - from, .small = small };
    *q = (struct enc_pieces){ 0 };
    if (!enc_program_init(&s.program, &(struct enc_of){ .st = st, .time = time }, &u, 1, &ignored)) {
        enc_program_clear(&s.program);
        return false;
    }
    enc_series_init(&s.series, &s.program);
    double longest = 0;
    s.heap = sga_malloc(((size_t)most + 2) * sizeof *s.heap);
    push(&s, (struct piece){ from, to, measure(&s, from, to) });
    while (s.count < most && s.heap[0].excess > 0 && sga_watch_ok()) {
        struct piece p = pop(&s);
        double middle = p.from + 0.5 * (p.to - p.from);
        if (p.to - p.from < LEAST * s.span) {
            if (isinf(p.excess)) {
                SGA_RESERVE(s.singular, s.singular_cap, s.singulars + 1);
                s.singular[s.singulars++] = middle;
            }
            p.excess = 0;
            push(&s, p);
            continue;
        }
        push(&s, (struct piece){ p.from, middle, measure(&s, p.from, middle) });
        push(&s, (struct piece){ middle, p.to, measure(&s, middle, p.to) });
    }
    q->complete = s.heap[0].excess == 0;
    q->count = s.count;
    q->end = sga_malloc((size_t)s.count * sizeof *q->end);
    qsort(s.heap, (size_t)s.count, sizeof *s.heap, ascending);
    q->step = sga_malloc((size_t)s.count * sizeof *q->step);
    for (int i = 0; i < s.count; i++)
        longest = fmax(longest, s.heap[i].to - s.heap[i].from);
    for (int i = 0; i < s.count; i++) {
        q->end[i] = s.heap[i].to;
        q->step[i] = step_of(&s, s.heap + i, longest);
    }
    free(s.heap);
    free(s.singular);
    enc_series_clear(&s.series);
    enc_program_clear(&s.program);
    return true;
}

void enc_pieces_clear(struct enc_pieces *q)
{
    free(q->end);
    free(q->step);
    *q = (struct enc_pieces){ 0 };
}
