/* The forms that a function can be shown in, and the choice among them. */
#include "display.h"

#include <assert.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "ball.h"
#include "budget.h"
#include "buf.h"
#include "collect.h"
#include "error.h"
#include "facts.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "poly.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"

/* Texts of this length are not weighed; polynomials for display, and for the zeros of one constraint, stay within these. */
enum { TEXT_BYTES = 6000, MOST_ZEROS = 60, MOST_SETS = 40 };
static const double FORM_SECONDS = 2;
/* A constraint's zeros may be a little heavier than how it arose: whole coefficients without denominators read better. */
static const double ZEROS_SLACK = 1.25;

void display_open(struct display *d, struct job *j)
{
    const struct expr_store *from = &j->request->store;
    *d = (struct display){ .j = j };
    expr_store_init(&d->st);
    expr_copy_symbols(&d->st, from);
    d->st.max_nodes = from->max_nodes;
    d->st.max_bits = from->max_bits;
    d->st.deadline = from->deadline;
    d->st.seconds = from->seconds;
    d->value = sga_calloc((size_t)d->st.symbols + 1, sizeof *d->value);
    SGA_ARENA(mem);
    expr_id *none = sga_zeros(&mem, (size_t)from->symbols + 1, sizeof *none);
    for (int k = 0; k < j->request->knowns; k++) {
        expr_id v = j->request->known[k].value;
        expr_copy(&d->st, from, &v, 1, none);
        d->value[j->request->known[k].symbol] = v;
    }
}

void display_close(struct display *d)
{
    free(d->value);
    expr_store_clear(&d->st);
}

bool display_sheet(struct display *d, struct sheet *s, const struct expr_store *from, const expr_id *map, const expr_id *root, int roots,
                   const struct sga_constraint *constraint, int constraints)
{
    *s = (struct sheet){ .roots = roots, .constraints = constraints, .on_set = roots, .constraint = constraint };
    s->root = sga_malloc(((size_t)roots + 1) * sizeof *s->root);
    s->shown = sga_malloc(((size_t)roots + 1) * sizeof *s->shown);
    s->scale = sga_calloc((size_t)constraints + 1, sizeof *s->scale);
    s->reduced = sga_calloc((size_t)constraints + 1, sizeof *s->reduced);
    memcpy(s->root, root, (size_t)roots * sizeof *root);
    expr_copy(&d->st, from, s->root, roots, map);
    bool ok = expr_store_ok(&d->st);
    for (int i = 0; i < roots && ok; i++)
        ok = s->root[i] != EXPR_UNDEF;
    return ok;
}

void display_sheet_clear(struct sheet *s)
{
    free(s->root);
    free(s->shown);
    free(s->scale);
    free(s->reduced);
    *s = (struct sheet){ 0 };
}

void display_values(struct display *d, expr_id *e, int count)
{
    struct sga_error before = *d->st.error;
    expr_substitute(&d->st, e, count, d->value);
    *d->st.error = before;
}

static bool in_name(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '\'' || (c >= '0' && c <= '9');
}

/* A name of the text's: two signs, one where it stands for a number that the request gives. */
static long weight_of_name(const struct display *d, const char *name, size_t length)
{
    int s = expr_symbol_find(&d->st, name, length);
    return s >= 0 && d->value[s] ? 1 : 2;
}

/* What there is to read: each sign and digit once, each name as one or two signs, however long. */
static long weight_of(const struct display *d, expr_id e)
{
    struct sga_buf b = { 0 };
    long n = 0;
    if (!e || !expr_print(&d->st, e, TEXT_BYTES, &b)) {
        sga_buf_free(&b);
        return 1L << 40;
    }
    for (size_t i = 0; i < b.len; i++) {
        size_t from = i;
        bool digit = b.data[i] >= '0' && b.data[i] <= '9';
        if (b.data[i] == ' ')
            continue;
        if (digit || !in_name(b.data[i])) {
            n++;
            continue;
        }
        while (i + 1 < b.len && in_name(b.data[i + 1]))
            i++;
        n += weight_of_name(d, b.data + from, i + 1 - from);
    }
    sga_buf_free(&b);
    return n;
}

struct choice {
    expr_id e;
    long weight;
};

/* Takes another form where it is lighter; where it is as light, too, if it may win ties. */
static bool offer(const struct display *d, struct choice *c, expr_id e, bool ties)
{
    if (e == c->e)
        return false;
    long w = weight_of(d, e);
    if (w > c->weight || (w == c->weight && !ties))
        return false;
    *c = (struct choice){ e, w };
    return true;
}

/* One irreducible factor, once, beside factors in parameters only (which are not 0 where there is a constraint at all):
 * these are taken from *zeros into *scale. */
static bool one_factor(struct display *d, const struct poly_limits *limits, expr_id *zeros, expr_id *scale)
{
    struct poly_factors f;
    if (!poly_numerator_factors(&d->st, *zeros, limits, &f))
        return false;
    int one = -1, others = 0;
    for (int i = 0; i < f.factors; i++) {
        if (!(f.factor[i].depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
            continue;
        others += one >= 0 || f.factor[i].multiplicity > 1;
        one = i;
    }
    bool ok = one >= 0 && !others;
    if (ok && f.factors > 1) {
        expr_id rest = f.factor[one].expr, times, q;
        bool reduced;
        struct poly_bridge *b = poly_bridge_new(&d->st, &rest, 1, limits);
        ok = b && poly_bridge_zeros(b, rest, NULL, 0, LONG_MAX / 8, &rest, &times, &reduced);
        poly_bridge_free(b);
        q = ok ? expr_mul(&d->st, *scale, expr_div(&d->st, *zeros, rest)) : EXPR_UNDEF;
        ok = q && poly_normal(&d->st, q, limits, scale);
        *zeros = ok ? rest : *zeros;
    }
    poly_factors_clear(&f);
    return ok;
}

/* As it arose, but for a number in front. */
static void by_number(struct display *d, struct sheet *s, expr_id scale, int i, struct choice *c)
{
    struct sga_error before = *d->st.error;
    expr_id e = EXPR_UNDEF;
    if (expr_is_const(&d->st, scale)) {
        fmpq_t number;
        fmpq_init(number);
        fmpq_inv(number, expr_const_value(&d->st, scale));
        e = expr_collect_times(&d->st, number, s->root[i]);
        fmpq_clear(number);
    }
    long w = e ? weight_of(d, e) : 0;
    if (e && (double)w <= ZEROS_SLACK * (double)c->weight) {
        *c = (struct choice){ e, w };
        s->scale[i] = scale;
    }
    *d->st.error = before;
}

/* By constraint: its tangency is a part of another one. What is the same on others' zeros only has another tangency. */
static unsigned char *differentiated(const struct sheet *s)
{
    unsigned char *is = sga_calloc((size_t)s->constraints + 1, 1);
    for (int i = 0; i < s->constraints; i++)
        for (int q = 0; q < s->constraint[i].parts; q++)
            if (s->constraint[i].part[q].row < 0 && s->constraint[i].part[q].tangency < s->constraints)
                is[s->constraint[i].part[q].tangency] = 1;
    return is;
}

/* A constraint as its zeros, on those of older generations where it may be. */
static void as_zeros(struct display *d, struct sheet *s, struct poly_bridge *b, const struct poly_limits *limits, int i, bool on_set, struct choice *c)
{
    expr_id by[MOST_SETS];
    int older = 0;
    for (int k = 0; k < s->constraints && older < MOST_SETS && on_set; k++)
        if (s->constraint[k].generation < s->constraint[i].generation)
            by[older++] = s->root[k];
    for (int round = 0; round < 2; round++) {
        expr_id zeros, scale;
        bool reduced;
        if (!poly_bridge_zeros(b, s->root[i], by, round ? 0 : older, c->weight, &zeros, &scale, &reduced) || (!round && !reduced))
            continue;
        expr_id number = scale;
        bool one = one_factor(d, limits, &zeros, &scale);
        long w = weight_of(d, zeros);
        if ((double)w > ZEROS_SLACK * (double)c->weight || !one) {
            if (round)
                by_number(d, s, number, i, c);
            continue;
        }
        *c = (struct choice){ zeros, w };
        s->scale[i] = scale;
        s->reduced[i] = reduced;
        return;
    }
}

static void choose_constraints(struct display *d, struct sheet *s, const struct poly_limits *limits)
{
    SGA_FREED unsigned char *used = differentiated(s);
    struct poly_bridge *b = s->constraints && s->constraints <= MOST_ZEROS ? poly_bridge_new(&d->st, s->root, s->constraints, limits) : NULL;
    for (int i = 0; i < s->constraints; i++) {
        struct choice c = { s->root[i], weight_of(d, s->root[i]) };
        offer(d, &c, s->shown[i], true);
        struct poly_bridge *own = b || s->constraints > MOST_ZEROS ? NULL : poly_bridge_new(&d->st, s->root + i, 1, limits);
        if (b || own)
            as_zeros(d, s, b ? b : own, limits, i, !used[i], &c);
        poly_bridge_free(own);
        s->shown[i] = c.e;
        s->weight += c.weight;
    }
    poly_bridge_free(b);
}

/* Whether the two have the same value at the points of the set that the reduction knows; with no point they do not. */
static bool same_at_points(struct display *d, expr_id x, expr_id y)
{
    const struct points_oracle *oracle = d->j->oracle;
    expr_id pair[2] = { x, y };
    display_values(d, pair, 2);
    if (!pair[0] || !pair[1])
        return false;
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(&d->st, &cone, pair, 2);
    bool same = oracle->reals > 0;
    for (int k = 0; k < oracle->reals && same; k++) {
        const struct num_ball *from = &oracle->real[k].ball;
        struct num_ball b;
        num_ball_init(&b, &d->st, from->prec);
        for (int i = 0; i < d->st.symbols && (size_t)i < from->symbol_cap; i++)
            num_ball_set(&b, i, from->symbol + i);
        num_ball_list(&b, cone.list, cone.count);
        arb_srcptr p = num_ball_value(&b, pair[0]), q = num_ball_value(&b, pair[1]);
        same = arb_is_finite(p) && arb_is_finite(q) && arb_overlaps(p, q);
        num_ball_clear(&b);
    }
    expr_cone_clear(&cone);
    return same;
}

/* Components of fields: the constraints as they are shown vanish where these count. */
static void choose_values(struct display *d, struct sheet *s, const struct poly_limits *limits)
{
    int c = s->constraints, values = s->roots - c;
    SGA_ARENA(mem);
    expr_id *both = sga_take(&mem, (size_t)(s->roots + 1) * sizeof *both), *normal = sga_take(&mem, (size_t)(values + 1) * sizeof *normal);
    memcpy(both, s->shown, (size_t)c * sizeof *both);
    memcpy(both + c, s->root + c, (size_t)values * sizeof *both);
    struct poly_bridge *b = values ? poly_bridge_new(&d->st, both, s->roots, limits) : NULL;
    if (!b)
        poly_normal_all(&d->st, s->root + c, values, limits, normal);
    for (int i = c; i < s->roots; i++) {
        struct choice best = { s->root[i], weight_of(d, s->root[i]) };
        expr_id form = b ? EXPR_UNDEF : normal[i - c];
        offer(d, &best, s->shown[i], true);
        if (form || poly_bridge_normal_within(b, s->root[i], best.weight, &form))
            offer(d, &best, form, true);
        struct choice before = best;
        if (b && i < s->on_set && c <= MOST_SETS && poly_bridge_on_set(b, s->root[i], both, c, best.weight, &form) && offer(d, &best, form, false)
            && !same_at_points(d, best.e, s->root[i]))
            best = before;
        s->shown[i] = best.e;
        s->weight += best.weight;
    }
    poly_bridge_free(b);
}

/* Constraints come first, then what holds on their set, then the rest. */
static bool sheet_sane(const struct sheet *s)
{
    for (int i = 1; i < s->constraints; i++)
        if (s->constraint[i].generation < s->constraint[i - 1].generation)
            return false;
    return s->constraints <= s->on_set && s->on_set <= s->roots;
}

void display_choose(struct display *d, struct sheet *s)
{
    assert(sheet_sane(s));
    struct sga_budget budget = *d->j->budget;
    double limit = sga_now() + FORM_SECONDS;
    if (!budget.deadline || budget.deadline > limit)
        budget.deadline = limit;
    struct poly_limits limits = poly_limits_of(POLY_SHOWN, NULL);
    limits.budget = &budget;
    s->weight = 0;
    memcpy(s->shown, s->root, (size_t)s->roots * sizeof *s->root);
    expr_collect(&d->st, s->shown, s->roots);
    for (int i = 0; i < s->roots && d->j->solution->written_out; i++)
        s->weight += weight_of(d, s->shown[i]);
    if (d->j->solution->written_out)          /* no form is lighter */
        return;
    choose_constraints(d, s, &limits);
    choose_values(d, s, &limits);
}
