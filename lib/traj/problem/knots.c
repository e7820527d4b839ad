/* Exact knots, and on which side of them times are. */
#include "knots.h"

#include <arb.h>
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "ball.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "system.h"
#include "table_balls.h"

/* Bits at which a time that is no rational number is told from knots. */
enum { FEW_BITS = 128, MANY_BITS = 8192, UNSURE = 2 };

/* The sign of t - knot; UNSURE. */
static int against(const struct expr_store *st, struct instant t, const fmpq_t knot)
{
    if (t.exact && expr_is_const(st, t.exact))
        return fmpq_cmp(expr_const_value(st, t.exact), knot);
    SGA_ENDS(arb_end) arb_t a = { 0 }, b = { 0 };
    for (slong prec = FEW_BITS; prec <= MANY_BITS; prec *= 4) {
        num_ball_constant(st, t.exact, t.about, prec, a);
        arb_set_fmpq(b, knot, prec);
        if (arb_gt(a, b) || arb_lt(a, b))
            return arb_gt(a, b) ? 1 : -1;
    }
    if (!t.exact) {                  /* a double may be a knot */
        SGA_ENDS(fmpq_end) fmpq_t q;
        SGA_ENDS(arf_end) arf_t d = { 0 };
        fmpq_init(q);
        arf_set_d(d, t.about);
        arf_get_fmpq(q, d);
        return fmpq_cmp(q, knot);
    }
    return UNSURE;
}

/* The first symbol of a table: its name. */
static const char *name_of(const struct sys_system *sys, const struct expr_table *u)
{
    const char *name = "";
    for (int k = 0; k < sys->signals; k++) {
        const struct expr_symbol *s = sys->store->symbol + sys->signal[k];
        name = s->table == u && s->order == 0 ? s->name : name;
    }
    return name;
}

static bool inexact(const struct sys_system *sys, const struct expr_table *u, int k, struct sga_error *err)
{
    char pointer[200];
    snprintf(pointer, sizeof pointer, "/system/tables/%.150s/times/%d", name_of(sys, u), k);
    return sga_fail_at(err, SGA_E_NOT_SUPPORTED, pointer, "in double-double and ball arithmetic the times of a table must be rational numbers, which are told "
                       "from each other exactly; this one is not, or it is another number than the one before with the same double: give a rational number, or use \"double\"");
}

static bool undecided(struct sga_error *err, double t)
{
    return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory", "the time %.17g cannot be told from a knot of a table with %d bits; give it as a rational number, or use "
                       "\"double\"", t, MANY_BITS);
}

static int ascending(const void *a, const void *b) { return fmpq_cmp(a, b); }

/* How many of the sorted knots do not come after t, in the order of numbers: those at t too where `with`. -1: unsure. */
static int up_to(const struct expr_store *st, const fmpq *knot, int count, struct instant t, bool with)
{
    int low = 0, high = count;
    while (low < high) {
        int middle = low + (high - low) / 2, side = against(st, t, knot + middle);
        if (side == UNSURE)
            return -1;
        if (side > 0 || (side == 0 && with))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static void reverse(fmpq *q, int count)
{
    for (int i = 0, j = count - 1; i < j; i++, j--)
        fmpq_swap(q + i, q + j);
}

/* A rational number near t. */
static void near(fmpq_t q, const struct expr_store *st, struct instant t)
{
    SGA_ENDS(arb_end) arb_t a = { 0 };
    num_ball_constant(st, t.exact, t.about, MANY_BITS, a);
    arf_get_fmpq(q, arb_midref(a));
}

/* A time within each piece: the middle, but for the ends. */
static void look_inside(struct knots *q, const struct traj_request *rq)
{
    const struct expr_store *st = q->sys->store;
    SGA_ENDS(fmpq_end) fmpq_t from, to;
    fmpq_init(from);
    fmpq_init(to);
    near(from, st, instant_start(rq));
    q->inside = _fmpq_vec_init(q->count + 1);
    for (int k = 0; k <= q->count; k++) {
        if (k < q->count)
            fmpq_set(to, q->knot + k);
        else
            near(to, st, instant_sample(rq, rq->samples - 1));
        fmpq_add(q->inside + k, from, to);
        fmpq_div_2exp(q->inside + k, q->inside + k, 1);
        fmpq_set(from, to);
    }
}

/* All knots, sorted, each once. */
static void collect(struct knots *q)
{
    int n = 0;
    for (int i = 0; i < q->tables; i++)
        q->room += q->table[i]->knots;
    q->knot = _fmpq_vec_init(q->room);
    for (int i = 0; i < q->tables; i++)
        for (int k = 0; k < q->table[i]->knots; k++)
            fmpq_set(q->knot + n++, q->table[i]->knot + k);
    qsort(q->knot, (size_t)n, sizeof *q->knot, ascending);
    for (int k = 0; k < n; k++)
        if (!q->count || fmpq_cmp(q->knot + k, q->knot + q->count - 1) > 0)
            fmpq_swap(q->knot + q->count++, q->knot + k);
}

/* Those strictly inside, in the order of the motion. False: unsure. */
static bool keep_inside(struct knots *q, const struct traj_request *rq)
{
    const struct expr_store *st = q->sys->store;
    double last = rq->times[rq->samples - 1];
    bool back = last < rq->start;
    struct instant low = instant_start(rq), high = instant_sample(rq, rq->samples - 1);
    if (back) {
        struct instant other = low;
        low = high;
        high = other;
    }
    int from = up_to(st, q->knot, q->count, low, true), to = up_to(st, q->knot, q->count, high, false);
    if (from < 0 || to < 0)
        return false;
    q->count = to > from ? to - from : 0;
    for (int k = 0; k < q->count; k++)
        fmpq_swap(q->knot + k, q->knot + from + k);
    if (back)
        reverse(q->knot, q->count);
    return true;
}

static void find_tables(struct knots *q)
{
    q->table = sga_calloc((size_t)q->sys->signals + 1, sizeof *q->table);
    for (int i = 0; i < q->sys->signals; i++) {
        struct expr_table *u = q->sys->store->symbol[q->sys->signal[i]].table;
        bool known = false;
        for (int k = 0; k < q->tables; k++)
            known |= q->table[k] == u;
        if (!known)
            q->table[q->tables++] = u;
    }
}

bool knots_init(struct knots *q, const struct sys_system *sys, const struct traj_request *rq, struct sga_error *err)
{
    assert(rq->samples > 0);
    *q = (struct knots){ .sys = sys };
    find_tables(q);
    for (int i = 0; i < q->tables; i++) {
        int bad = num_table_exact(q->table[i]);
        if (bad >= 0)
            return inexact(sys, q->table[i], bad, err);
    }
    collect(q);
    if (!keep_inside(q, rq))
        return undecided(err, rq->start);
    look_inside(q, rq);
    return true;
}

void knots_clear(struct knots *q)
{
    if (!q->table)
        return;
    knots_leave(q);
    if (q->knot)
        _fmpq_vec_clear(q->knot, q->room);
    if (q->inside)
        _fmpq_vec_clear(q->inside, q->count + 1);
    free(q->table);
    *q = (struct knots){ 0 };
}

void knots_enter(const struct knots *q, int piece)
{
    assert(piece >= 0 && piece <= q->count);
    for (int i = 0; i < q->tables; i++)
        q->table[i]->at = expr_table_interval_exact(q->table[i], q->inside + piece);
}

void knots_leave(const struct knots *q)
{
    for (int i = 0; i < q->tables; i++)
        q->table[i]->at = -1;
}

bool knots_around(const struct knots *q, struct instant t)
{
    bool sure = true;
    for (int i = 0; i < q->tables; i++) {
        struct expr_table *u = q->table[i];
        int k = up_to(q->sys->store, u->knot, u->knots, t, true) - 1;
        sure &= k >= -1;
        u->at = k < 0 ? 0 : k < u->knots - 1 ? k : u->knots - 2;
    }
    return sure;
}

bool knots_before(const struct knots *q, const struct traj_request *rq, int *before, struct sga_error *err)
{
    const struct expr_store *st = q->sys->store;
    bool back = rq->times[rq->samples - 1] < rq->start;
    int passed = 0;
    for (int k = 0; k < rq->samples; k++) {
        struct instant t = instant_sample(rq, k);
        for (; passed < q->count; passed++) {
            int side = against(st, t, q->knot + passed);
            if (side == UNSURE)
                return undecided(err, t.about);
            if ((back ? -side : side) <= 0)
                break;
        }
        before[k] = passed;
    }
    return true;
}
