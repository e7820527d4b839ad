/* Zeros of constraints and rates, from starts near a guess and far from it. */
#include "equilibria.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "budget.h"
#include "equilibria_shape.h"
#include "error.h"
#include "flint_ends.h"
#include "linearize.h"
#include "natural.h"
#include "oracle.h"
#include "points_random.h"
#include "reduction.h"
#include "seeds.h"
#include "set_points.h"
#include "system.h"

/* Two zeros nearer than this, relative to 1 and themselves, are one. */
static const double SAME = 1e-8;
/* Irregular places are reached slowly: nearer than this they are one. */
static const double SAME_IRREGULAR = 1e-3;
/* Where four zeros meet, places 0.1 away were seen. */
static const double SAME_ROUNDED = 0.15;
/* Of the boxes that starts are drawn from, in turn; each third round of them has one of any size between 10 to these powers. */
static const double SIZE[] = { 1, 10, 100, 0.1 }, LOWEST = -5, HIGHEST = 6;
enum { SIZES = sizeof SIZE / sizeof *SIZE, MOST_IRREGULAR = 20, MOST_DEFLATED = 30, BRANCH_STARTS = 4 };

struct list {
    double **x; int count; size_t cap;
};

struct search {
    struct equilibria *e;
    const struct equilibria_request *q;
    int n;
    int *scale; double *unit;      /* by variable: natural size (natural.h), its log2, or NULL: all near 1 */
    struct set_points on;
    struct sga_arena mem;
    struct list zero, irregular;   /* places of the search */
    expr_id *deflated; int deflations;   /* the rates, and how many zeros are taken out of them */
    struct list left;              /* that stay irregular, in e's memory */
};

static bool same(const struct search *s, const double *a, const double *b, double within)
{
    for (int k = 0; k < s->n; k++)
        if (!(fabs(a[k] - b[k]) <= within * fmax(s->unit[k], fmax(fabs(a[k]), fabs(b[k])))))
            return false;
    return true;
}

static double *copy(struct sga_arena *mem, const double *x, int n)
{
    double *to = sga_take(mem, ((size_t)n + 1) * sizeof *to);
    memcpy(to, x, (size_t)n * sizeof *to);
    return to;
}

static void add_place(const struct search *s, struct list *l, struct sga_arena *mem, const double *x, double within)
{
    for (int k = 0; k < s->n; k++)
        if (!isfinite(x[k]))
            return;
    for (int i = 0; i < l->count; i++)
        if (same(s, l->x[i], x, within))
            return;
    SGA_RESERVE_IN(mem, l->x, l->cap, (size_t)l->count + 1);
    l->x[l->count++] = copy(mem, x, s->n);
}

static bool inside(const struct equilibria_request *q, const double *x, int n)
{
    for (int k = 0; k < n; k++)
        if (x[k] < q->low[k] || x[k] > q->high[k])
            return false;
    return true;
}

/* About what starts are drawn: the guess, and by turns one of the zeros found, as others may lie beside it where few come from afar. */
static const double *centre(const struct search *s, int start, uint64_t *random)
{
    if (start / SIZES % 2 == 0 || !s->zero.count)
        return s->q->near;
    return s->zero.x[points_random(random) % (uint64_t)s->zero.count];
}

static double box(int start, uint64_t *random)
{
    if (start / (2 * SIZES) % 3 < 2)
        return SIZE[start % SIZES];
    return pow(10, LOWEST + (HIGHEST - LOWEST) * points_uniform(random));
}

/* Start 0 is the guess; the others lie in the bounds, or about the centre where there are none. */
static void draw(const struct search *s, int start, uint64_t *random, double *x)
{
    const struct equilibria_request *q = s->q;
    const double *about = centre(s, start, random), size = box(start, random);
    for (int k = 0; k < s->n; k++) {
        double far = size * s->unit[k], low = about[k] - far, high = about[k] + far;
        bool below = isfinite(q->low[k]), above = isfinite(q->high[k]);
        low = below ? q->low[k] : above ? fmin(low, q->high[k] - far) : low;
        high = above ? q->high[k] : below ? fmax(high, q->low[k] + far) : high;
        double u = points_uniform(random);
        x[k] = start ? points_short(low + u * (high - low)) : fmin(fmax(q->near[k], q->low[k]), q->high[k]);
    }
}

static void from_start(struct search *s, uint64_t *random)
{
    struct equilibria *e = s->e;
    struct points_point p;
    enum points_status got = points_find(&s->on.space, 0, random, POINTS_BITS, &p);
    if (got == POINTS_OK) {
        bool in = inside(s->q, p.x, s->n);
        e->reached++;
        e->outside += !in;
        if (in)
            add_place(s, &s->zero, &s->mem, p.x, SAME);
    } else if (got == POINTS_IRREGULAR) {
        e->beside++;
        if (p.x && inside(s->q, p.x, s->n) && s->irregular.count < MOST_IRREGULAR)
            add_place(s, &s->irregular, &s->mem, p.x, SAME_IRREGULAR);
    }
    points_point_clear(&p);
}

/* The functions that are searched: constraints, and these. */
static void set_functions(struct search *s, const expr_id *rate, int rates, const double *near)
{
    s->on.space.constraints = s->q->rq->sol->constraints;
    for (int k = 0; k < rates; k++)
        s->on.constraint[s->on.space.constraints++] = rate[k];
    for (int k = 0; k < s->q->helds && rate; k++)
        s->on.constraint[s->on.space.constraints++] = s->q->held[k];
    s->on.space.near = near;
}

/* From what algebra says, where the starts did not come: on the part of the set that was solved. */
static void from_place(struct search *s, const double *x, uint64_t *random)
{
    struct points_point p;
    set_functions(s, NULL, 0, x);
    if (points_find(&s->on.space, 0, random, POINTS_BITS, &p) == POINTS_OK && inside(s->q, p.x, s->n) && same(s, p.x, x, SAME))
        add_place(s, &s->zero, &s->mem, p.x, SAME);
    points_point_clear(&p);
}

/* The rates in coordinates of the final set next to x. */
static bool own_rates(struct search *s, const double *x, struct linearization *l, double *from, uint64_t *random)
{
    struct sga_error why = { .code = SGA_E_OK };
    struct points_point p;
    bool of_time = false, ok;
    set_functions(s, NULL, 0, x);
    ok = points_find(&s->on.space, 0, random, POINTS_BITS, &p) == POINTS_OK && same(s, p.x, x, SAME_IRREGULAR);
    if (ok)
        memcpy(from, p.x, (size_t)s->n * sizeof *from);
    points_point_clear(&p);
    struct linear_guess guess = { .x = from, .budget = s->q->rq->budget };
    return ok && linear_rates(l, s->q->rq, &guess, &of_time, &why) && !of_time && l->states == s->q->rates;
}

static struct equilibrium *keep_point(struct search *s, const double *x, bool certified, const struct linearization *l)
{
    struct equilibria *e = s->e;
    for (int i = 0; i < e->points; i++)
        if (e->family || same(s, e->point[i].x, x, SAME))
            return e->point + i;
    struct equilibrium one = { .x = copy(&e->mem, x, s->n), .certified = certified, .zeros = l->states + s->q->helds };
    one.zero = sga_take(&e->mem, ((size_t)one.zeros + 1) * sizeof *one.zero);
    for (int k = 0; k < one.zeros; k++)
        one.zero[k] = k < l->states ? l->rate[k] : s->q->held[k - l->states];
    one.states = l->states;
    one.state = sga_take(&e->mem, ((size_t)l->states + 1) * sizeof *one.state);
    if (l->states)
        memcpy(one.state, l->state, (size_t)l->states * sizeof *one.state);
    SGA_RESERVE_IN(&e->mem, e->point, e->cap, (size_t)e->points + 1);
    e->point[e->points] = one;
    return e->point + e->points++;
}

/* Whether some variable is in none of the functions. */
static bool free_of_one(const struct search *s)
{
    const struct sys_system *sys = s->q->rq->sys;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    bool depends = true;
    expr_cone_init(&cone);
    for (int k = 0; k < s->n && depends; k++) {
        depends = false;
        for (int i = 0; i < s->on.space.constraints && !depends; i++)
            depends = expr_depends(sys->store, &cone, s->on.constraint[i], sys->variable[k].symbol);
    }
    return !depends;
}

/* Where differentials are dependent a zero is one by rational arithmetic alone. */
static bool keep_exact(struct search *s, const double *x, const struct linearization *l)
{
    const struct linear_request *rq = s->q->rq;
    struct linear_place place;
    struct linear_guess guess = { .x = x, .zero = s->on.constraint + rq->sol->constraints, .zeros = s->on.space.constraints - rq->sol->constraints, .budget = rq->budget };
    bool exact = !s->e->family && linear_place_find(&place, rq->sys, rq->sol, &guess) && place.basis == LINEAR_EXACT;
    if (exact) {
        struct equilibrium *p = keep_point(s, place.x, true, l);
        p->degenerate = true;
        p->shifted = free_of_one(s);
    }
    if (!s->e->family)
        linear_place_clear(&place);
    return exact;
}

/* Where the reduced motion has no derivative, x stays at rest where alpha, restrictions and what is held are 0 and no constraint is hurt. */
static bool keep_kink(struct search *s, const double *x)
{
    const struct linear_request *rq = s->q->rq;
    const struct sys_system *sys = rq->sys;
    struct linearization none = { .states = 0 };
    struct linear_place place;
    int n = 0;
    expr_id *zero = sga_take(&s->mem, ((size_t)(sys->rows + sys->restrictions + s->q->helds) + 1) * sizeof *zero);
    for (int i = 0; i < sys->rows; i++)
        zero[n++] = sys->row[i].alpha;
    for (int i = 0; i < sys->restrictions; i++)
        zero[n++] = sys->restriction[i];
    for (int i = 0; i < s->q->helds; i++)
        zero[n++] = s->q->held[i];
    struct linear_guess guess = { .x = x, .zero = zero, .zeros = n, .budget = rq->budget };
    bool exact = linear_place_find(&place, sys, rq->sol, &guess) && place.basis == LINEAR_EXACT && inside(s->q, place.x, s->n);
    if (exact) {
        struct equilibrium *p = keep_point(s, place.x, true, &none);
        p->degenerate = p->kink = true;
        p->zeros = 0;
    }
    linear_place_clear(&place);
    return exact;
}

/* Factors of the functions may have independent differentials where they have not. */
static bool keep_shaped(struct search *s, const double *x)
{
    struct linearization none = { .states = 0 };
    struct equilibrium_shape shape;
    struct linear_place place;
    bool found = !s->e->family && equilibrium_shape_find(&shape, &s->e->mem, s->q->rq, s->q->held, s->q->helds, x, &place) && inside(s->q, place.x, s->n)
        && same(s, place.x, x, SAME_IRREGULAR);
    if (found) {
        struct equilibrium *p = keep_point(s, place.x, true, &none);
        p->degenerate = p->by_factors = true;
        p->zero = shape.factor + shape.constraints;
        p->zeros = shape.factors - shape.constraints;
    }
    if (!s->e->family)
        linear_place_clear(&place);
    return found;
}

enum outcome { NEITHER, KEPT, IRREGULAR };

/* A place is an equilibrium in its own coordinates, irregular in these too (or without any; then it is put into `there`), or neither. */
static enum outcome look(struct search *s, const double *x, double *there, uint64_t *random)
{
    struct linearization l = { .states = 0 };
    struct points_point p;
    double *from = sga_take(&s->mem, ((size_t)s->n + 1) * sizeof *from);
    enum outcome out = NEITHER;
    memcpy(there, x, (size_t)s->n * sizeof *there);
    if (!own_rates(s, x, &l, from, random)) {
        out = !s->e->family && keep_kink(s, x) ? KEPT : IRREGULAR;
    } else {
        set_functions(s, l.rate, l.states, from);
        enum points_status got = points_find(&s->on.space, 0, random, POINTS_BITS, &p);
        bool near = p.x && same(s, p.x, x, SAME_IRREGULAR) && inside(s->q, p.x, s->n);
        if (got == POINTS_OK && near) {
            keep_point(s, p.x, p.certified, &l);
            out = KEPT;
        } else if (got == POINTS_IRREGULAR && near) {
            memcpy(there, p.x, (size_t)s->n * sizeof *there);
            out = keep_exact(s, p.x, &l) ? KEPT : IRREGULAR;
        }
        points_point_clear(&p);
    }
    linearization_clear(&l);
    return out;
}

/* Where many zeros meet Newton's method hardly gets near: numbers of few digits about the place are tried, which rational arithmetic proves. */
static bool rounded(struct search *s, const double *x, uint64_t *random)
{
    static const double UNIT[] = { 1, 0.5, 0.1, 0.01 };     /* and a power of ten, of natural sizes */
    double *short_x = sga_take(&s->mem, ((size_t)s->n + 1) * sizeof *short_x), *there = sga_take(&s->mem, ((size_t)s->n + 1) * sizeof *there);
    for (size_t i = 0; i < sizeof UNIT / sizeof *UNIT; i++) {
        for (int k = 0; k < s->n; k++) {
            double unit = UNIT[i] * (s->scale ? pow(10, nearbyint(log10(s->unit[k]))) : 1);
            short_x[k] = round(x[k] / unit) * unit;
        }
        if (same(s, short_x, x, SAME_ROUNDED) && inside(s->q, short_x, s->n) && look(s, short_x, there, random) == KEPT)
            return true;
    }
    return false;
}

static void settle(struct search *s, const double *x, uint64_t *random)
{
    double *there = sga_take(&s->mem, ((size_t)s->n + 1) * sizeof *there);
    if (look(s, x, there, random) == IRREGULAR && !keep_shaped(s, there))
        add_place(s, &s->left, &s->e->mem, there, SAME_IRREGULAR);
}

static expr_id number(struct expr_store *st, double v)
{
    SGA_ENDS(fmpq_end) fmpq_t q = { { 0, 1 } };
    SGA_ENDS(arf_end) arf_t value = { 0 };
    arf_set_d(value, v);
    arf_get_fmpq(q, value);
    return expr_fmpq(st, q);
}

/* 1 + size^2/|x - place|^2 in natural units, where size is that of the place, and 1 at the least */
static expr_id repulsion(const struct search *s, const double *place)
{
    const struct sys_system *sys = s->q->rq->sys;
    struct expr_store *st = sys->store;
    expr_id sum = expr_int(st, 0);
    double size = 1;
    for (int k = 0; k < sys->variables; k++) {
        size = fmax(size, fabs(place[k]) / s->unit[k]);
        expr_id d = expr_sub(st, st->symbol[sys->variable[k].symbol].node, number(st, points_short(place[k])));
        d = expr_div(st, d, number(st, s->unit[k]));
        sum = expr_add(st, sum, expr_mul(st, d, d));
    }
    expr_id apart = number(st, points_short(size));
    return expr_add(st, expr_int(st, 1), expr_div(st, expr_mul(st, apart, apart), sum));
}

/* The rates times what grows beyond bounds at zeros found: others are left (Brown & Gearhart, Numer. Math. 16 (1971) 334). */
static void deflate(struct search *s)
{
    struct expr_store *st = s->q->rq->sys->store;
    if (!s->deflated) {
        s->deflated = sga_take(&s->mem, ((size_t)s->q->rates + 1) * sizeof *s->deflated);
        memcpy(s->deflated, s->q->rate, (size_t)s->q->rates * sizeof *s->deflated);
    }
    assert(s->deflations <= s->zero.count);
    for (; s->deflations < s->zero.count; s->deflations++) {
        expr_id factor = repulsion(s, s->zero.x[s->deflations]);
        for (int k = 0; k < s->q->rates; k++)
            s->deflated[k] = expr_mul(st, s->deflated[k], factor);
    }
}

/* Which functions the start is for: by turns those without the zeros found, while these are few. */
static void choose(struct search *s, int start, const double *x)
{
    bool without = start % 2 && s->zero.count && s->zero.count <= MOST_DEFLATED && !s->e->family;
    if (without)
        deflate(s);
    set_functions(s, without ? s->deflated : s->q->rate, s->q->rates, x);
}

/* Where differentials are dependent, factors of the functions are met one by one: a point of each branch, in general position. */
static bool from_branches(struct search *s, uint64_t *random, struct sga_error *err)
{
    const struct sga_budget *budget = s->q->rq->budget;
    struct equilibria_branch *branch;
    double *x = sga_take(&s->mem, ((size_t)s->n + 1) * sizeof *x);
    int branches = equilibria_branches(s->q->rq, s->q->held, s->q->helds, &s->mem, &branch);
    for (int b = 0; b < branches; b++)
        for (int start = 1; branch[b].factors <= s->n && start <= BRANCH_STARTS && sga_budget_ok(budget, err); start++) {
            struct points_point p;
            draw(s, start, random, x);
            s->on.space.constraints = branch[b].factors;
            memcpy(s->on.constraint, branch[b].factor, (size_t)branch[b].factors * sizeof *s->on.constraint);
            s->on.space.near = x;
            bool kept = points_find(&s->on.space, 0, random, POINTS_BITS, &p) == POINTS_OK && inside(s->q, p.x, s->n) && keep_shaped(s, p.x);
            points_point_clear(&p);
            if (kept)
                break;
        }
    return sga_budget_ok(budget, err);
}

static bool run(struct search *s, struct sga_error *err)
{
    struct equilibria *e = s->e;
    const struct sga_budget *budget = s->q->rq->budget;
    uint64_t random = SGA_SEED_EQUILIBRIA;
    double *x = sga_take(&s->mem, ((size_t)s->n + 1) * sizeof *x);
    for (; e->tried < s->q->starts && sga_budget_ok(budget, err); e->tried++) {
        draw(s, e->tried, &random, x);
        choose(s, e->tried, x);
        from_start(s, &random);
    }
    for (int i = 0; i < s->q->places && sga_budget_ok(budget, err); i++)
        from_place(s, s->q->place[i], &random);
    for (int i = 0; i < s->zero.count && !(e->family && e->points) && sga_budget_ok(budget, err); i++)
        settle(s, s->zero.x[i], &random);
    for (int i = 0; i < s->irregular.count && sga_budget_ok(budget, err); i++)
        if (!rounded(s, s->irregular.x[i], &random))
            settle(s, s->irregular.x[i], &random);
    assert(e->reached + e->beside <= e->tried && e->outside <= e->reached);
    if (e->beside && !e->family && !from_branches(s, &random, err))
        return false;
    e->irregular = s->left.x;
    e->irregulars = s->left.count;
    return sga_budget_ok(budget, err);
}

static void measure(struct search *s)
{
    double time;
    s->scale = natural_sizes(s->q->rq->sys, &time);
    s->unit = sga_take(&s->mem, ((size_t)s->n + 1) * sizeof *s->unit);
    for (int k = 0; k < s->n; k++)
        s->unit[k] = s->scale ? ldexp(1, s->scale[k]) : 1;
    s->on.space.scale = s->scale;
}

bool equilibria_search(struct equilibria *e, const struct equilibria_request *q, struct sga_error *err)
{
    const struct sys_system *sys = q->rq->sys;
    struct search s = { .e = e, .q = q, .n = sys->variables };
    *e = (struct equilibria){ .family = s.n - q->rq->sol->constraints - q->rates - q->helds };
    if (e->family < 0)
        return sga_fail_at(err, SGA_E_INPUTS, "/equilibria/hold", "%d more is held than the motion leaves to choose: for each variable that is held, name an input in "
                           "equilibria.free", -e->family);
    int most = sys->variables > q->rates + q->helds ? sys->variables : q->rates + q->helds;      /* of branches, or of rates and what is held */
    set_points_init(&s.on, sys, q->rq->sol, q->rq->sol->constraints, 0, most);
    measure(&s);
    s.on.space.starts = 1;
    s.on.space.side = q->rq->oracle->side;
    s.on.space.sides = q->rq->oracle->sides;
    s.on.space.budget = q->rq->budget;
    bool ok = run(&s, err);
    set_points_clear(&s.on);
    sga_arena_end(&s.mem);
    free(s.scale);
    return ok;
}

void equilibria_clear(struct equilibria *e)
{
    sga_arena_end(&e->mem);
    *e = (struct equilibria){ .points = 0 };
}
