/* Sampling and the zero oracle. */
#include "oracle.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "beyond.h"
#include "mem.h"
#include "modp.h"
#include "modpoint.h"
#include "needed_bits.h"
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

void points_oracle_init(struct points_oracle *s, uint64_t seed)
{
    *s = (struct points_oracle){ .random = seed, .least_digits = 1 << 20, .height = -1 };
    s->modular = sga_calloc(POINTS_MODULAR_MOST, sizeof *s->modular);
    s->beyond = sga_calloc(1, sizeof *s->beyond);
    expr_cone_init(&s->cone);
}

bool points_oracle_cut_short(const struct points_oracle *s)
{
    return s->beyond->cut_short;
}

void points_oracle_forget_cut(struct points_oracle *s)
{
    s->beyond->cut_short = false;
}

static void drop_high(struct points_oracle *s)
{
    if (s->high_bits)
        for (int i = 0; i < s->reals; i++)
            points_point_clear(s->high + i);
    s->high_bits = 0;
}

void points_oracle_forget(struct points_oracle *s)
{
    drop_high(s);
    for (int i = 0; i < s->reals; i++)
        points_point_clear(s->real + i);
    for (int i = 0; i < s->modulars; i++)
        points_modpoint_clear(s->modular + i);
    s->reals = s->modulars = 0;
    s->height = -1;
    s->modular_over = false;
    if (s->beyond)
        points_beyond_forget(s->beyond);
}

void points_oracle_clear(struct points_oracle *s)
{
    points_oracle_forget(s);
    if (s->beyond)
        points_beyond_clear(s->beyond);
    free(s->beyond);
    free(s->modular);
    free(s->zero);
    free(s->side);
    free(s->variable);
    free(s->parameter);
    free(s->constraint);
    free(s->defined);
    free(s->cheap);
    free(s->near);
    expr_cone_clear(&s->cone);
}

static enum points_status sample_reals(struct points_oracle *s, const struct points_point *before, int befores)
{
    struct points_space space = s->space;
    double *near = NULL;
    SGA_FREED signed char *sign = sga_calloc((size_t)space.parameters + 1, 1);
    enum points_status status = POINTS_OK;
    for (int k = 0; k < POINTS_REAL; k++) {
        /* a guess is only a guess: go a little away from it, to a generic point */
        double spread = k == 0 && !s->space.near ? 1 : (s->space.near_spread > 0 ? s->space.near_spread : 0.05) * (1 + k);
        space.before = k < befores ? before + k : NULL;
        space.side = s->side;
        space.sides = s->sides;
        space.same_branches = true;
        status = points_find(&space, spread, &s->random, POINTS_BITS, s->real + k);
        if (status != POINTS_OK) {
            points_point_clear(s->real + k);
            break;
        }
        s->reals++;
        if (k == 0) {
            near = sga_malloc((size_t)space.variables * sizeof *near);
            memcpy(near, s->real[0].x, (size_t)space.variables * sizeof *near);
            space.near = near;
            space.near_time = s->real[0].t;
            for (int i = 0; i < space.parameters; i++)
                sign[i] = s->real[0].parameter[i] < 0 ? -1 : 1;
            space.parameter_sign = sign;
        }
    }
    free(near);
    return status;
}

static void *copy_of(const void *from, size_t count, size_t size)
{
    void *to = sga_malloc((count + 1) * size);
    if (count)
        memcpy(to, from, count * size);
    return to;
}

/* The lists of the space become the oracle's own: it may be asked after its user has gone. */
static void take_space(struct points_oracle *s, const struct points_space *space)
{
    int *variable = copy_of(space->variable, (size_t)space->variables, sizeof *variable);
    int *parameter = copy_of(space->parameter, (size_t)space->parameters, sizeof *parameter);
    expr_id *constraint = copy_of(space->constraint, (size_t)space->constraints, sizeof *constraint);
    expr_id *defined = copy_of(space->defined, (size_t)space->defineds, sizeof *defined);
    signed char *cheap = space->cheap ? copy_of(space->cheap, (size_t)space->variables, sizeof *cheap) : NULL;
    s->space = *space;
    free(s->defined);
    free(s->cheap);
    free(s->variable);
    free(s->parameter);
    free(s->constraint);
    s->space.variable = s->variable = variable;
    s->space.parameter = s->parameter = parameter;
    s->space.constraint = s->constraint = constraint;
    s->space.defined = s->defined = defined;
    s->space.cheap = s->cheap = cheap;
}

/* The guess of the space, which is gone before the oracle is, as a rule. */
static void take_guess(struct points_oracle *s, const struct points_space *given)
{
    double *near = given->near ? copy_of(given->near, (size_t)given->variables, sizeof *near) : NULL;
    free(s->near);
    s->space.near = s->near = near;
    s->space.near_time = given->near_time;
}

/* Whether the set is a part of the one that the present points lie on. */
static bool shrinks(const struct points_oracle *s, const struct points_space *space)
{
    bool prefix = s->space.constraints <= space->constraints;
    for (int i = 0; i < s->space.constraints && prefix; i++)
        prefix = s->constraint[i] == space->constraint[i];
    return prefix;
}

/* Points within their number; sides have signs; decisions that were counted have a basis. */
static bool oracle_sane(const struct points_oracle *s)
{
    bool sane = s->reals >= 0 && s->reals <= POINTS_REAL && s->modulars >= 0 && s->modulars <= POINTS_MODULAR_MOST;
    for (int i = 0; i < s->sides && sane; i++)
        sane = s->side[i].function && (s->side[i].sign == 1 || s->side[i].sign == -1);
    return sane;
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

enum points_status points_oracle_sample(struct points_oracle *s, const struct points_space *given)
{
    double start = sga_now();
    /* where sets shrink the last points are good starts; those of a smaller set are special ones on a larger, and it begins beside them */
    struct points_space own = *given, *space = &own;
    struct points_point before[POINTS_REAL];
    int befores = s->reals;
    bool smaller = befores && shrinks(s, given);
    if (befores && !smaller && !own.near) {
        own.near = s->real[0].x;
        own.near_time = s->real[0].t;
    }
    memcpy(before, s->real, (size_t)befores * sizeof *before);
    drop_high(s);
    s->reals = 0;
    points_oracle_forget(s);
    take_space(s, space);
    enum points_status status = sample_reals(s, before, smaller ? befores : 0);
    s->chance = ~s->random;
    take_guess(s, given);
    for (int k = 0; k < befores; k++)
        points_point_clear(before + k);
    if (status != POINTS_OK)
        points_oracle_forget(s);
    s->seconds_sampling += sga_now() - start;
    assert(oracle_sane(s));
    return status;
}

bool points_oracle_certified(const struct points_oracle *s)
{
    bool all = s->reals > 0;
    for (int k = 0; k < s->reals; k++)
        all = all && s->real[k].certified;
    return all;
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
        num_ball_extend(&s->real[k].ball);
        count_ball(&t, s->real + k, num_ball_value(&s->real[k].ball, e));
    }
    return t;
}

static bool raise_points(struct points_oracle *s, slong bits)
{
    if (s->high_bits >= bits)
        return true;
    drop_high(s);
    const struct points_space *space = &s->space;
    for (int k = 0; k < s->reals; k++) {
        struct points_point *p = s->real + k, *q = s->high + k;
        points_point_copy(q, p, bits);
        if (space->constraints && !points_refine(space, q, bits)) {
            for (int i = 0; i <= k; i++)
                points_point_clear(s->high + i);
            return false;
        }
    }
    s->high_bits = bits;
    return true;
}

static struct tally look_high(struct points_oracle *s, expr_id e)
{
    struct tally t = { .digits = 1 << 20 };
    expr_cone_of(s->space.st, &s->cone, &e, 1);
    for (int k = 0; k < s->reals; k++) {
        num_ball_list(&s->high[k].ball, s->cone.list, s->cone.count);
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
        s->modular_over = !points_modpoint_find(s->modular + s->modulars, &s->space, s->real[0].solved, s->prime, &s->chance);
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

double points_oracle_height(struct points_oracle *s)
{
    if (s->height < 0 && s->reals) {
        int n = s->space.constraints + s->space.defineds;
        SGA_FREED expr_id *root = sga_malloc((size_t)(n + 1) * sizeof *root);
        for (int i = 0; i < n; i++)
            root[i] = i < s->space.constraints ? s->space.constraint[i] : s->space.defined[i - s->space.constraints];
        expr_cone_of(s->space.st, &s->cone, root, n);
        num_ball_extend(&s->real[0].ball);
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
        num_ball_extend(&s->real[k].ball);
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
        if (l && !raise_points(s, level[l]))
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
                drop_high(s);       /* no other decision should pay for these */
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
    assert(decision_sane(d));
    s->count[d.basis]++;
    keep_zero(s, e, d);
    if (d.truth == POINTS_ZERO && d.basis != POINTS_EXACT)
        note_sides(s, e, d.basis);
    if (d.basis == POINTS_ZERO_NUMERIC && d.digits < s->least_digits)
        s->least_digits = d.digits;
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
    assert(decision_sane(d));
    int known = s->sides;
    SGA_FREED struct points_side *before = copy_of(s->side, (size_t)known, sizeof *before);
    bool zero = d.truth == POINTS_ZERO;
    *mixed = false;
    if (zero && d.basis != POINTS_EXACT)
        note_sides(s, e, d.basis);
    else if (nonzero && d.truth == POINTS_NONZERO && d.basis != POINTS_EXACT && any_switches(s))
        note_zeros(s, e);
    for (int i = 0; i < s->sides; i++)
        *mixed |= (i >= known || before[i].unseen) && !s->side[i].unseen;
    if (*mixed && !accept) {
        memcpy(s->side, before, (size_t)known * sizeof *before);
        s->sides = known;
    }
    if (*mixed && !accept)
        return d;
    s->count[d.basis]++;
    keep_zero(s, e, d);
    if (d.basis == POINTS_ZERO_NUMERIC && d.digits < s->least_digits)
        s->least_digits = d.digits;
    return d;
}

double points_oracle_magnitude(struct points_oracle *s, expr_id e)
{
    assert(s->reals > 0);
    num_ball_extend(&s->real[0].ball);
    SGA_ENDS(mag_end) mag_t m = { 0 };
    arb_get_mag(m, num_ball_value(&s->real[0].ball, e));
    return mag_is_special(m) ? -1e9 : mag_get_d_log2_approx(m);
}
