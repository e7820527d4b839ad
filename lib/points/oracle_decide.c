/* The zero oracle's decisions: balls at the points, points modulo a prime, more bits, algebra. */
#include "oracle.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "beyond.h"
#include "budget.h"
#include "mem.h"
#include "modp.h"
#include "modpoint.h"
#include "needed_bits.h"
#include "points_random.h"
#include "poly.h"
#include "sides.h"
#include "warnings.h"

const char *points_basis_text(enum points_basis basis)
{
    static const char *const text[POINTS_BASES] = {
        "exact", "nonzero_proved", "nonzero_numeric", "zero_algebraic", "zero_numeric", "split", "no_value",
    };
    return text[basis];
}

/* Decimal digits to which a ball that contains 0 is known to be 0. */
static int digits_of(const arb_t v)
{
    SGA_ENDS(mag_end) mag_t m = { 0 };
    arb_get_mag(m, v);
    return mag_is_zero(m) ? 100000 : (int)fmax(-1e6, fmin(1e6, -mag_get_d_log2_approx(m) * 0.30103));
}

struct tally {
    int nonzero, zero, none, digits;
    bool proved;
};

static void count_ball(struct tally *t, const struct points_point *p, const arb_t v)
{
    if (!arb_is_finite(v)) {
        t->none++;
    } else if (!arb_contains_zero(v)) {
        t->nonzero++;
        t->proved |= p->certified;
    } else {
        int d = digits_of(v);
        t->zero++;
        t->digits = d < t->digits ? d : t->digits;
    }
}

static struct tally look(struct points_oracle *s, expr_id e)
{
    struct tally t = { .digits = 1 << 20 };
    for (int k = 0; k < s->reals; k++) {
        num_ball_ask(&s->real[k].ball, e);
        count_ball(&t, s->real + k, num_ball_value(&s->real[k].ball, e));
    }
    return t;
}

static struct tally look_high(struct points_oracle *s, expr_id e)
{
    struct tally t = { .digits = 1 << 20 };
    for (int k = 0; k < s->reals; k++) {
        num_ball_ask(&s->high[k].ball, e);
        count_ball(&t, s->high + k, num_ball_value(&s->high[k].ball, e));
    }
    return t;
}

/* One more point modulo a prime; they are looked for when a question comes up. */
static bool more_modular(struct points_oracle *s)
{
    enum { VALUES_MOST = 4000000 };      /* of all points together */
    enum { PRIMES = 4 };
    double start = sga_now();
    if (!s->modulars && !s->modular_over)
        s->prime = (int)(points_random(&s->chance) % NUM_MODP_PRIMES);
    if (s->modulars >= POINTS_MODULAR_MOST || (s->modulars >= POINTS_MODULAR && s->space.st->nodes > VALUES_MOST / POINTS_MODULAR_MOST))
        s->modular_over = true;
    if (s->modular_over)
        return false;
    s->modular_over = true;
    for (int k = 0; k < PRIMES && s->modular_over; k++) {      /* a number that is a root has a residue for some primes only */
        s->modular_over = !points_modpoint_find(s->modular + s->modulars, &s->space, s->real[0].unsolved ? NULL : s->real[0].solved, s->prime,
                                                &s->chance);
        s->prime = (s->prime + 1) % NUM_MODP_PRIMES;
    }
    s->modulars += !s->modular_over;
    s->seconds_sampling += sga_now() - start;
    return !s->modular_over;
}

/* What the modular points say of a function that is 0 at the real ones. */
struct opinion {
    int zero, nonzero, none;      /* points */
};

/* The first points where they agree; where they do not, or roots have no value or another sign, points to the end, until
 * one says zero. */
static struct opinion modular(struct points_oracle *s, expr_id e)
{
    struct opinion o = { 0 };
    for (int k = 0; k < s->modulars || more_modular(s); k++) {
        bool chance;
        int z = points_modpoint_zero(s->modular + k, e, &chance);
        o.zero += z == 1;
        o.nonzero += z == 0;
        o.none += z < 0;
        if (k + 1 >= POINTS_MODULAR && (o.zero || !chance))
            break;
    }
    return o;
}

bool points_oracle_modular_zero(struct points_oracle *s, expr_id e)
{
    assert(s->reals > 0);
    return expr_is_const(s->space.st, e) ? expr_is_zero(s->space.st, e) : modular(s, e).zero > 0;
}

double points_oracle_height(struct points_oracle *s)
{
    if (s->height < 0 && s->reals) {
        int n = s->space.constraints + s->space.defineds;
        SGA_FREED expr_id *root = sga_malloc((size_t)(n + 1) * sizeof *root);
        for (int i = 0; i < n; i++)
            root[i] = i < s->space.constraints ? s->space.constraint[i] : s->space.defined[i - s->space.constraints];
        expr_cone_of(s->space.st, &s->cone, root, n);
        for (int i = 0; i < n; i++)
            num_ball_ask(&s->real[0].ball, root[i]);
        s->height = points_height(&s->real[0].ball, s->cone.list, s->cone.count);
    }
    return s->height;
}

/* Bits to which e must be seen to be 0 at the points before that is believed. */
static slong needed_bits(struct points_oracle *s, expr_id e)
{
    slong need = 0;
    double height = points_oracle_height(s);
    expr_cone_of(s->space.st, &s->cone, &e, 1);
    for (int k = 0; k < s->reals; k++) {
        num_ball_ask(&s->real[k].ball, e);
        slong here = points_needed_bits(&s->real[k].ball, s->cone.list, s->cone.count, height);
        need = here > need ? here : need;
    }
    return need;
}

/* The last resort: a zero by algebra, whatever the points say. */
static bool zero_by_algebra(struct points_oracle *s, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, s->space.budget);
    return poly_is_zero((struct expr_store *)s->space.st, e, &limits) == POLY_YES;
}

static struct points_decision decide(struct points_oracle *s, expr_id e)
{
    slong level[] = { 0, 400, 1200, 3600, 0 }, need = 0;
    struct points_decision d = { .points = s->reals };
    if (expr_is_const(s->space.st, e)) {
        d.truth = expr_is_zero(s->space.st, e) ? POINTS_ZERO : POINTS_NONZERO;
        d.basis = POINTS_EXACT;
        return d;
    }
    struct opinion o = { 0 };
    bool asked = false;
    for (int l = 0; l < 5; l++) {
        if (l == 4)         /* beyond the usual levels only for what may be that small */
            level[l] = need < 4000 ? 8000 : need + need / 2 + 2000;
        if (l == 4 && d.truth == POINTS_ZERO && level[l] > SGA_MOST_DEEPEST_BITS)
            sga_limit_met(s->space.budget, SGA_LIMIT_DEEPEST_BITS);
        if (l == 4 && (level[l] > SGA_MOST_DEEPEST_BITS || d.truth != POINTS_ZERO))
            break;
        if (l && !points_oracle_raise(s, level[l]))
            break;
        struct tally t = l ? look_high(s, e) : look(s, e);
        d.points = t.nonzero + t.zero;
        d.digits = t.digits;
        if (t.nonzero && !t.zero) {
            d.truth = POINTS_NONZERO;
            d.basis = t.proved ? POINTS_NONZERO_PROVED : POINTS_NONZERO_NUMERIC;
            return d;
        }
        if (!d.points)
            continue;       /* more bits may give a value */
        if (!asked)
            o = modular(s, e);
        asked = true;
        if (t.nonzero) {        /* mixed: more bits, then a split */
            d.truth = POINTS_UNKNOWN;
            continue;
        }
        d.truth = POINTS_ZERO;
        d.modular = o.zero;
        d.basis = o.zero ? POINTS_ZERO_ALGEBRAIC : POINTS_ZERO_NUMERIC;
        if (o.zero && !o.nonzero && t.digits >= 20)
            return d;
        /* a modular point that says no is a serious objection: only many digits overrule it
         * (it may lie on a component without real points, and elementary functions have
         * identities that it does not know) */
        int enough = o.nonzero ? 900 : 100;
        if (!need)
            need = needed_bits(s, e);
        if (t.digits >= enough && t.digits * 3.32 >= (double)need) {
            if (l == 4)
                points_oracle_lower(s);       /* no other decision should pay for these */
            return d;
        }
    }
    /* more bits could not be had: enough only where nothing objects */
    if (d.truth == POINTS_ZERO && !o.nonzero && d.digits * 3.32 >= (double)need)
        return d;
    if (d.truth == POINTS_ZERO && zero_by_algebra(s, e)) {
        d.basis = POINTS_EXACT;
        return d;
    }
    d.truth = POINTS_UNKNOWN;
    struct tally t = s->high_bits ? look_high(s, e) : look(s, e);
    d.basis = t.nonzero && t.zero ? POINTS_IS_SPLIT : POINTS_NO_VALUE;
    return d;
}

static void keep_zero(struct points_oracle *s, expr_id e, struct points_decision d)
{
    if (d.truth != POINTS_ZERO || d.basis == POINTS_EXACT)
        return;
    for (int i = 0; i < s->zeros; i++)
        if (s->zero[i].expr == e)
            return;
    if (s->zeros >= SGA_MOST_ZEROS_LISTED) {
        sga_limit_met(s->space.budget, SGA_LIMIT_ZEROS_LISTED);
        return;
    }
    SGA_RESERVE(s->zero, s->zero_cap, s->zeros + 1);
    s->zero[s->zeros++] = (struct points_zero){ e, d, s->space.constraints };
}

/* Zero, not zero and unknown rest on what shows them. */
static bool decision_sane(struct points_decision d)
{
    switch (d.basis) {
    case POINTS_NONZERO_PROVED: case POINTS_NONZERO_NUMERIC: return d.truth == POINTS_NONZERO;
    case POINTS_ZERO_ALGEBRAIC: case POINTS_ZERO_NUMERIC: return d.truth == POINTS_ZERO;
    case POINTS_IS_SPLIT: case POINTS_NO_VALUE: return d.truth == POINTS_UNKNOWN;
    default: return d.basis == POINTS_EXACT && d.truth != POINTS_UNKNOWN;
    }
}

/* What the evidence says of a decision. */
static void record(struct points_oracle *s, expr_id e, struct points_decision d)
{
    assert(decision_sane(d));
    s->count[d.basis]++;
    keep_zero(s, e, d);
    if (d.basis == POINTS_ZERO_NUMERIC && d.digits < s->least_digits)
        s->least_digits = d.digits;
}

static bool any_switches(struct points_oracle *s)
{
    const struct expr_store *st = s->space.st;
    for (; s->looked < st->nodes; s->looked++)
        s->switches |= points_switches(expr_op_of(st, s->looked));
    return s->switches && s->reals && expr_store_ok(st);
}

/* A zero that was found at the points: the sides that it depends on, by switches of its own and, where it does not
 * hold by algebra whatever they are (roots have one sign or the other modulo a prime), by those of the constraints. */
static void note_sides(struct points_oracle *s, expr_id e, enum points_basis basis)
{
    struct expr_store *st = (struct expr_store *)s->space.st;
    if (!any_switches(s))
        return;
    expr_cone_of(st, &s->cone, &e, 1);
    int known = s->sides;
    points_beyond_list(s->beyond, &s->space, s->real);
    points_sides_of(st, s->real, e, s->cone.list, s->cone.count, s->beyond, &s->side, &s->sides, &s->side_cap);
    points_beyond_check(s->beyond, &s->space, s->real, e, s->cone.list, s->cone.count, s->side, &s->sides, known);
    points_beyond_pairs(s->beyond, &s->space, s->real, e, s->cone.list, s->cone.count, &s->side, &s->sides, &s->side_cap);
    points_beyond_sides(s->beyond, &s->space, s->real, e, s->cone.list, s->cone.count, basis == POINTS_ZERO_ALGEBRAIC, &s->side, &s->sides,
                        &s->side_cap);
}

struct points_decision points_oracle_zero(struct points_oracle *s, expr_id e)
{
    struct points_decision d = decide(s, e);
    if (d.truth == POINTS_ZERO && d.basis != POINTS_EXACT)
        note_sides(s, e, d.basis);
    record(s, e, d);
    return d;
}

/* Sides of a function that is not 0 at the points beyond which it is. */
static void note_zeros(struct points_oracle *s, expr_id e)
{
    struct expr_store *st = (struct expr_store *)s->space.st;
    expr_cone_of(st, &s->cone, &e, 1);
    points_beyond_list(s->beyond, &s->space, s->real);
    points_beyond_zeros(s->beyond, &s->space, s->real, e, s->cone.list, s->cone.count, &s->side, &s->sides, &s->side_cap);
}

struct points_decision points_oracle_cells(struct points_oracle *s, expr_id e, bool nonzero, bool accept, bool *mixed)
{
    struct points_decision d = decide(s, e);
    int known = s->sides;
    SGA_FREED struct points_side *before = sga_malloc((size_t)(known + 1) * sizeof *before);
    if (known)
        memcpy(before, s->side, (size_t)known * sizeof *before);
    bool zero = d.truth == POINTS_ZERO;
    *mixed = false;
    if (zero && d.basis != POINTS_EXACT)
        note_sides(s, e, d.basis);
    else if (nonzero && d.truth == POINTS_NONZERO && d.basis != POINTS_EXACT && any_switches(s))
        note_zeros(s, e);
    for (int i = 0; i < s->sides; i++)
        *mixed |= (i >= known || before[i].unseen) && !s->side[i].unseen;
    if (*mixed && !accept) {
        if (known)
            memcpy(s->side, before, (size_t)known * sizeof *before);
        s->sides = known;
    } else {
        record(s, e, d);
    }
    return d;
}
