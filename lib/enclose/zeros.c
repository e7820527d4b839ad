/* See zeros.h. Ends of intervals are parts of the span, dyadic numbers in double. */
#include "zeros.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "enclose.h"
#include "mem.h"
#include "watch.h"

enum {
    HALVINGS = 44,       /* of a span: a zero is that near to another, or to one of the rate, where it is not decided */
    PARTS = 4000,        /* of a span that are cut: what is left then is not decided */
    NEWTON = 64          /* steps at most: each at least halves the ball */
};
/* Where an interval is cut: at the first of these parts at which the sign is shown. */
static const double CUT[] = { 0.5, 0.4375, 0.5625, 0.375, 0.625 };
enum { CUTS = sizeof CUT / sizeof *CUT };

/* The part of the first span within which a zero is not told from the start. */
static const double AT_START = 1e-9;

/* What is looked at: one function on one span. */
struct look {
    struct enc_zeros *z;
    const struct enc_span *span;
    int which;
    arb_ptr box;
    arb_struct s, time;
    int found;           /* place in out of the first of this span */
};

static void look_init(struct look *l, struct enc_zeros *z, const struct enc_span *span)
{
    *l = (struct look){ .z = z, .span = span, .box = _arb_vec_init(z->q->n), .found = z->out->count };
    arb_init(&l->s);
    arb_init(&l->time);
}

static void look_clear(struct look *l)
{
    _arb_vec_clear(l->box, l->z->q->n);
    arb_clear(&l->s);
    arb_clear(&l->time);
}

/* Around s = m + r the solution is at phi_m + f r, f the field on what is known already: nearer than the polynomials' terms one by one. */
static void nearer(struct look *l)
{
    const struct enc_zeros *z = l->z;
    int n = z->q->n;
    SGA_ARENA(mem);
    arb_ptr middle = arbs_take(&mem, n);
    SGA_ENDS(arb_end) arb_t m = { 0 }, r = { 0 }, v = { 0 };
    arb_get_mid_arb(m, &l->s);
    arb_sub(r, &l->s, m, z->prec + 64);
    enc_step_at(l->span->step, l->span->set, m, middle);
    for (int j = 0; j < n; j++) {
        arb_srcptr field = enc_series_of(&z->at, z->p.root[j]);
        arb_mul(v, field, r, z->prec + 10);
        arb_add(v, v, middle + j, z->prec + 10);
        if (arb_is_finite(v) && !arb_intersection(l->box + j, l->box + j, v, z->prec + 10))
            arb_set(l->box + j, v);      /* never: both hold it */
    }
}

/* Whether function k (or its rate: watches + k) may jump on what values() were of. */
static bool may_jump(const struct enc_zeros *z, int k)
{
    bool may = false;
    for (int i = z->jumps[k]; i < z->jumps[k + 1] && !may; i++) {
        const struct enc_jump *j = z->jump + i;
        may = arb_contains_zero(enc_series_of(&z->at, z->p.root[j->a])) && (j->b < 0 || arb_contains_nonpositive(enc_series_of(&z->at, z->p.root[j->b])));
    }
    return may;
}

/* Function and rate for all s in the ball l->s; not finite where they have no value, the rate where the function may jump. */
static void values(struct look *l, arb_t g, arb_t d)
{
    struct enc_zeros *z = l->z;
    enc_step_at(l->span->step, l->span->set, &l->s, l->box);
    arb_add(&l->time, l->span->t, &l->s, z->prec + 64);
    enc_series_values(&z->at, l->box, &l->time, z->prec + 10);
    if (!arb_is_exact(&l->s)) {
        nearer(l);
        enc_series_values(&z->at, l->box, &l->time, z->prec + 10);
    }
    arb_set(g, enc_series_of(&z->at, z->p.root[z->q->n + 2 * l->which]));
    arb_set(d, enc_series_of(&z->at, z->p.root[z->q->n + 2 * l->which + 1]));
    if (may_jump(z, l->which))
        arb_zero_pm_inf(d);
}

/* l->s := the part u of the span. */
static void at_part(struct look *l, double u)
{
    arb_set_d(&l->s, u);
    arb_mul(&l->s, &l->s, l->span->s, ARF_PREC_EXACT);
}

/* l->s := all between the parts a and b. */
static void between(struct look *l, double a, double b)
{
    SGA_ENDS(arb_end) arb_t low = { 0 };
    at_part(l, a);
    arb_swap(low, &l->s);
    at_part(l, b);
    arb_union(&l->s, low, &l->s, l->z->prec + 64);
}

static int sign_of(const arb_t g)
{
    return arb_is_positive(g) ? 1 : arb_is_negative(g) ? -1 : 0;
}

/* 0: not shown. *valued: it has a value there. */
static int sign_at(struct look *l, double u, bool *valued)
{
    SGA_ENDS(arb_end) arb_t g = { 0 }, d = { 0 };
    at_part(l, u);
    values(l, g, d);
    *valued |= arb_is_finite(g);
    return arb_is_finite(g) ? sign_of(g) : 0;
}

/* One more of function `which`; its place and time are still to be set. direction 0: it is not decided. */
static struct enclose_happening *append(struct enc_zeros *z, int which, int direction)
{
    struct enclose_happened *out = z->out;
    out->list = sga_realloc(out->list, ((size_t)out->count + 1) * sizeof *out->list);
    struct enclose_happening *h = out->list + out->count++;
    *h = (struct enclose_happening){ .which = which, .direction = direction, .shown = direction != 0, .piece = -1, .x = _arb_vec_init(z->q->n) };
    arb_init(&h->t);
    return h;
}

/* The ball l->s holds it, or is not decided (direction 0). open: it reaches the span's end. */
static void add(struct look *l, int direction, int before, bool open)
{
    struct enclose_happening *h = append(l->z, l->which, direction);
    h->before = before;
    h->open = open;
    enc_step_at(l->span->step, l->span->set, &l->s, h->x);
    arb_add(&h->t, l->span->t, &l->s, l->z->prec + 64);
}

/* One of m - g(m) / d within l->s, whose rate d has no 0. False: there is none. */
static bool newton(struct look *l, const arb_t d)
{
    SGA_ENDS(arb_end) arb_t whole = { 0 }, g = { 0 }, rate = { 0 }, next = { 0 };
    arb_set(whole, &l->s);
    arb_get_mid_arb(&l->s, &l->s);
    arb_set(next, &l->s);
    values(l, g, rate);
    arb_div(g, g, d, l->z->prec + 10);
    arb_sub(next, next, g, l->z->prec + 64);
    return arb_intersection(&l->s, whole, next, l->z->prec + 64);
}

/* The only zero in l->s, in a ball as small as the solution is known. */
static void refine(struct look *l, arb_t d)
{
    SGA_ENDS(arb_end) arb_t g = { 0 }, kept = { 0 };
    SGA_ENDS(mag_end) mag_t half = { 0 };
    for (int k = 0; k < NEWTON && sga_watch_ok(); k++) {
        arb_set(kept, &l->s);
        mag_mul_2exp_si(half, arb_radref(&l->s), -1);
        if (!newton(l, d)) {
            arb_swap(&l->s, kept);      /* roundings: it is in both */
            break;
        }
        bool smaller = mag_cmp(arb_radref(&l->s), half) < 0;
        arb_set(kept, &l->s);
        values(l, g, d);
        if (!smaller || arb_contains_zero(d))
            break;
    }
}

/* As refine, of a zero that there may not be: false: there is none. */
static bool smaller(struct look *l, arb_t d)
{
    SGA_ENDS(arb_end) arb_t g = { 0 };
    SGA_ENDS(mag_end) mag_t half = { 0 };
    for (int k = 0; k < NEWTON && sga_watch_ok(); k++) {
        mag_mul_2exp_si(half, arb_radref(&l->s), -1);
        if (!newton(l, d))
            return false;
        if (mag_cmp(arb_radref(&l->s), half) >= 0)
            break;
        values(l, g, d);
        if (arb_contains_zero(d))
            break;
    }
    return true;
}

/* What was left open where this span begins goes on: as this function does not turn here, the signs beside decide. */
static bool closes(struct look *l, int slope, int after)
{
    struct enclose_happened *out = l->z->out;
    struct enclose_happening *last = NULL;
    for (int k = l->found - 1; k >= 0 && !last; k--)
        last = out->list[k].which == l->which && out->list[k].open ? out->list + k : NULL;
    if (!last || !last->before || !after || last->slope != slope)
        return false;
    last->open = false;
    last->direction = last->before == after ? 0 : slope;
    last->shown = true;          /* shown to be one, or (direction 0) to be none */
    SGA_ENDS(arb_end) arb_t here = { 0 };
    arb_add(here, l->span->t, &l->s, l->z->prec + 64);
    arb_union(&last->t, &last->t, here, l->z->prec + 64);
    for (int j = 0; j < l->z->q->n; j++)
        arb_union(last->x + j, last->x + j, l->box + j, l->z->prec + 10);
    return true;
}

/* The zero at the start, or next to it, does not count. */
static bool leaves(const struct look *l, int slope)
{
    const struct enclose_watch *w = l->z->q->watch + l->which;
    return !l->z->strict || w->zero || (w->direction && w->direction != slope);
}

/* One at most between a and b, whose rate is d; l->s is all between. Signs are 0 where the span's ends do not show them. */
static void one_at_most(struct look *l, double a, double b, int before, int after, arb_t d)
{
    int slope = sign_of(d);
    if (before && after && before == after)
        return;
    if (before && after) {
        refine(l, d);
        add(l, slope, before, false);
        return;
    }
    if (!smaller(l, d))
        return;
    if (!before && a == 0 && (l->span->first ? leaves(l, slope) : closes(l, slope, after)))
        return;
    add(l, 0, before, !after && b == 1);
    l->z->out->list[l->z->out->count - 1].slope = slope;
}

struct part {
    double a, b;
    int before, after, depth;
};

/* Where [a, b] is cut, and the sign there; 0: nowhere. */
static int cut(struct look *l, const struct part *p, double *at, bool *valued)
{
    int sign = 0;
    for (int k = 0; k < CUTS && !sign; k++) {
        *at = p->a + CUT[k] * (p->b - p->a);
        sign = sign_at(l, *at, valued);
    }
    return sign;
}

/* Not decided: joined with what is so just before it. */
static void undecided(struct look *l, const struct part *p)
{
    struct enclose_happened *out = l->z->out;
    struct enclose_happening *last = out->count > l->found ? out->list + out->count - 1 : NULL;
    between(l, p->a, p->b);
    add(l, 0, p->before, false);
    struct enclose_happening *now = out->list + out->count - 1;
    last = last ? now - 1 : NULL;
    if (!last || last->which != now->which || last->shown || !arb_overlaps(&last->t, &now->t))
        return;
    arb_union(&last->t, &last->t, &now->t, l->z->prec + 64);
    for (int j = 0; j < l->z->q->n; j++)
        arb_union(last->x + j, last->x + j, now->x + j, l->z->prec + 10);
    enclose_happened_cut(out, out->count - 1);
}

/* It is 0 at the start with its rate, which has one sign beyond: so has the function. After values(). */
static bool leaves_flat(const struct look *l, const struct part *p)
{
    const struct enc_zeros *z = l->z;
    arb_srcptr second = enc_series_of(&z->at, z->p.root[z->q->n + 2 * z->q->watches + l->which]);
    return z->strict && l->span->first && p->a == 0 && !may_jump(z, l->which) && !may_jump(z, z->q->watches + l->which) && z->q->watch[l->which].second && arb_is_finite(second) && !arb_contains_zero(second);
}

/* The zeros of one function, in order. */
static void search(struct look *l, int before, int after)
{
    struct part stack[HALVINGS + 2];
    int top = 0, looks = 0;
    SGA_ENDS(arb_end) arb_t g = { 0 }, d = { 0 };
    stack[top++] = (struct part){ 0, 1, before, after, 0 };
    while (top > 0 && sga_watch_ok()) {
        struct part p = stack[--top];
        between(l, p.a, p.b);
        values(l, g, d);
        if ((arb_is_finite(g) && !arb_contains_zero(g)) || leaves_flat(l, &p))
            continue;
        if (arb_is_finite(d) && !arb_contains_zero(d)) {
            one_at_most(l, p.a, p.b, p.before, p.after, d);
            continue;
        }
        double at;
        bool valued = p.depth == HALVINGS || looks == PARTS;
        int sign = valued ? 0 : cut(l, &p, &at, &valued);
        looks += looks < PARTS;
        if (!sign) {
            bool start = l->span->first && !l->z->strict && p.a == 0 && !p.before && p.b < AT_START;
            if (valued && !start)
                undecided(l, &p);
            continue;
        }
        assert(top + 2 <= HALVINGS + 2 && p.a < at && at < p.b);
        stack[top++] = (struct part){ at, p.b, sign, p.after, p.depth + 1 };
        stack[top++] = (struct part){ p.a, at, p.before, sign, p.depth + 1 };
    }
}

/* What may jump in e: its arguments into root from `roots` on, and where they are into jump; NULL: counted only. */
static int list_jumps(const struct expr_store *st, expr_id e, expr_id *root, int roots, struct enc_jump *jump)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    int count = 0;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    for (int i = 0; i < cone.count; i++) {
        enum expr_op op = expr_op_of(st, cone.list[i]);
        if (op != EXPR_SIGN && op != EXPR_ATAN2)
            continue;
        const struct expr_node *n = st->node + cone.list[i];
        if (jump) {
            root[roots + 2 * count] = n->a;
            root[roots + 2 * count + 1] = op == EXPR_SIGN ? n->a : n->b;
            jump[count] = (struct enc_jump){ roots + 2 * count, op == EXPR_SIGN ? -1 : roots + 2 * count + 1 };
        }
        count++;
    }
    return count;
}

/* All jumps, behind the other roots: how many roots there are then. */
static int all_jumps(struct enc_zeros *z, expr_id **root, int roots)
{
    const struct enclose_problem *q = z->q;
    int most = 0;
    for (int k = 0; k < 2 * q->watches; k++)
        most += list_jumps(q->st, k < q->watches ? q->watch[k].value : q->watch[k - q->watches].rate, NULL, 0, NULL);
    *root = sga_realloc(*root, ((size_t)roots + 2 * (size_t)most + 1) * sizeof **root);
    z->jump = sga_malloc(((size_t)most + 1) * sizeof *z->jump);
    z->jumps = sga_calloc(2 * (size_t)q->watches + 1, sizeof *z->jumps);
    for (int k = 0; k < 2 * q->watches; k++)
        z->jumps[k + 1] = z->jumps[k] + list_jumps(q->st, k < q->watches ? q->watch[k].value : q->watch[k - q->watches].rate, *root, roots + 2 * z->jumps[k], z->jump + z->jumps[k]);
    assert(z->jumps[2 * q->watches] == most);
    return roots + 2 * most;
}

bool enc_zeros_init(struct enc_zeros *z, const struct enclose_problem *q, struct enclose_happened *out, slong prec, struct sga_error *err)
{
    int roots = q->n + 3 * q->watches;
    SGA_FREED expr_id *root = sga_malloc(((size_t)roots + 1) * sizeof *root);
    memcpy(root, q->field, (size_t)q->n * sizeof *root);
    *z = (struct enc_zeros){ .q = q, .out = out, .prec = prec, .strict = z->strict, .side = sga_calloc((size_t)q->watches + 1, 1), .left = sga_malloc(((size_t)q->watches + 1) * sizeof *z->left) };
    for (int k = 0; k < q->watches; k++) {
        root[q->n + 2 * k] = q->watch[k].value;
        root[q->n + 2 * k + 1] = q->watch[k].rate;
        root[q->n + 2 * q->watches + k] = q->watch[k].second ? q->watch[k].second : q->watch[k].value;
        z->left[k] = q->watch[k].most ? q->watch[k].most : -1;
    }
    roots = all_jumps(z, &root, roots);
    bool ok = enc_program_init(&z->p, &(struct enc_of){ q->st, q->variable, q->n, q->time, q->tables }, root, roots, err);
    if (ok)
        enc_series_init(&z->at, &z->p);
    return ok;
}

void enc_zeros_clear(struct enc_zeros *z)
{
    free(z->jump);
    free(z->jumps);
    free(z->side);
    free(z->left);
    enc_series_clear(&z->at);
    enc_program_clear(&z->p);
    *z = (struct enc_zeros){ 0 };
}

void enc_zeros_begin(struct enc_zeros *z, const struct enc_set *set, const arb_t t)
{
    int n = z->q->n;
    SGA_ARENA(mem);
    arb_ptr box = arbs_take(&mem, n);
    enc_set_hull(set, box);
    enc_series_values(&z->at, box, t, z->prec + 10);
    for (int k = 0; k < z->q->watches; k++) {
        arb_srcptr g = enc_series_of(&z->at, z->p.root[n + 2 * k]);
        z->side[k] = (signed char)(arb_is_finite(g) ? sign_of(g) : 0);
    }
}

/* The signs at the end of a span. */
static void ends(struct enc_zeros *z, const struct enc_span *span, signed char *sign)
{
    struct look l;
    look_init(&l, z, span);
    bool valued = false;
    for (l.which = 0; l.which < z->q->watches; l.which++)
        sign[l.which] = (signed char)sign_at(&l, 1, &valued);
    look_clear(&l);
}

bool enc_zeros_told(struct enc_zeros *z, const struct enc_span *span)
{
    SGA_FREED signed char *sign = sga_calloc((size_t)z->q->watches + 1, 1);
    ends(z, span, sign);
    return !memchr(sign, 0, (size_t)z->q->watches);
}

static int sooner(const void *a, const void *b)
{
    const struct enclose_happening *p = a, *q = b;
    int order = arf_cmp(arb_midref(&p->t), arb_midref(&q->t));
    return order ? order : p->which - q->which;
}

/* Those from `from` on, sorted, without what is not asked for. The first that stops, or -1. */
static int sift(struct enc_zeros *z, int from, bool backward)
{
    struct enclose_happened *out = z->out;
    if (out->count == from)
        return -1;
    qsort(out->list + from, (size_t)(out->count - from), sizeof *out->list, sooner);
    for (int i = from, j = out->count - 1; backward && i < j; i++, j--) {
        struct enclose_happening other = out->list[i];
        out->list[i] = out->list[j];
        out->list[j] = other;
    }
    for (int i = from; i < out->count; ) {
        const struct enclose_happening *h = out->list + i;
        const struct enclose_watch *w = z->q->watch + h->which;
        bool counts = z->left[h->which] && !(w->direction && h->shown && h->direction != w->direction);
        if (!counts) {
            enclose_happened_cut(out, i);
            continue;
        }
        z->left[h->which] -= z->left[h->which] > 0;
        if (w->stop)
            return i;
        i++;
    }
    return -1;
}

/* Function k is past its zero at t, without having been there. */
static void add_jump(struct enc_zeros *z, int k, int direction, arb_srcptr box, const arb_t t, int piece)
{
    struct enclose_happening *h = append(z, k, direction);
    h->piece = piece;
    _arb_vec_set(h->x, box, z->q->n);
    arb_set(&h->t, t);
}

int enc_zeros_beyond(struct enc_zeros *z, const struct enc_set *set, const arb_t t, int piece, bool backward)
{
    int n = z->q->n, from = z->out->count;
    SGA_ARENA(mem);
    arb_ptr box = arbs_take(&mem, n), was = arbs_take(&mem, z->q->watches);
    for (int k = 0; k < z->q->watches; k++)
        arb_set(was + k, enc_series_of(&z->at, z->p.root[n + 2 * k]));
    SGA_FREED signed char *before = memcpy(sga_malloc((size_t)z->q->watches + 1), z->side, (size_t)z->q->watches);
    enc_zeros_begin(z, set, t);
    enc_set_hull(set, box);
    for (int k = 0; k < z->q->watches; k++) {
        arb_srcptr g = enc_series_of(&z->at, z->p.root[n + 2 * k]);
        bool jumps = !arb_is_finite(g) || !arb_is_finite(was + k) || !arb_overlaps(was + k, g);
        if (before[k] && z->side[k] && before[k] != z->side[k])
            add_jump(z, k, backward ? before[k] : z->side[k], box, t, piece);
        else if (jumps && (!before[k] || !z->side[k]))
            add_jump(z, k, 0, box, t, piece);
    }
    return sift(z, from, backward);
}

int enc_zeros_along(struct enc_zeros *z, const struct enc_span *span)
{
    SGA_FREED signed char *sign = sga_calloc((size_t)z->q->watches + 1, 1);
    struct look l;
    int from = z->out->count;
    ends(z, span, sign);
    look_init(&l, z, span);
    for (l.which = 0; l.which < z->q->watches; l.which++) {
        l.found = z->out->count;
        search(&l, z->side[l.which], sign[l.which]);
    }
    look_clear(&l);
    memcpy(z->side, sign, (size_t)z->q->watches);
    for (int i = from - 1; i >= 0; i--) {
        const struct enclose_happening *h = z->out->list + i;
        int wanted = z->q->watch[h->which].direction;
        if (h->shown && (!h->direction || (wanted && h->direction != wanted))) {      /* it was left open, and is shown to be none now */
            enclose_happened_cut(z->out, i);
            from--;
        }
    }
    return sift(z, from, arf_sgn(arb_midref(span->s)) < 0);
}
