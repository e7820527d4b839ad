/* Identities at fresh points of Pf. */
#include "witness.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "budget.h"
#include "buf.h"
#include "differentials.h"
#include "error.h"
#include "mem.h"
#include "oracle.h"
#include "reduction.h"
#include "seeds.h"
#include "sides.h"
#include "signal.h"
#include "system.h"
#include "warnings.h"

/* Balls widen along long eliminations: more bits where the first do not tell. */
static const slong witness_bits[] = { 160, 640, 2560, 10240, 40960 };
enum { WITNESS_LEVELS = 5, LEAST_DIGITS = 8 };
enum { FAR_TRIES = 6 };         /* for points that the answer speaks of: beyond, points are near those of the reduction */

struct check {
    const struct sys_system *sys;
    const struct sga_claim *claim;
    const struct points_oracle *oracle;   /* of the reduction, or NULL */
    struct num_ball own;            /* the system's store at the point */
    struct points_point *point;
    struct points_jacobian *jac;
    struct points_jacobian time;    /* the same by `clock` */
    struct expr_cone asked, said;   /* what is looked at of the system, and of the claim: no other node of their stores is evaluated */
    int *clock, clocks;             /* symbols of the claim's store: time, and signals with their */
    int *rate;                      /* derivatives; of time -1 */
    arb_t sum, term;
    mag_t size, part;
    slong slope;                    /* log2 of what the constraint changes by; 0 at the least */
    bool last, beside;              /* no more bits can be had: what is small beside that is enough; and it was needed */
    int digits;
    const struct sga_budget *budget;
    struct sga_error *err;
    slong prec;
};

/* Add a * b to the residual, and |a b| to its size. */
static void add_term(struct check *c, const arb_t a, const arb_t b)
{
    arb_mul(c->term, a, b, c->prec);
    arb_add(c->sum, c->sum, c->term, c->prec);
    arb_get_mag(c->part, c->term);
    mag_add(c->size, c->size, c->part);
}

static void begin(struct check *c)
{
    arb_zero(c->sum);
    mag_zero(c->size);
    c->slope = 0;
}

/* Of a value of that size; not 0. exp(-10^8 x^2) has more digits than an int counts. */
static int digits_of(const mag_t size)
{
    return (int)fmax(-1e6, fmin(1e6, -mag_get_d_log2_approx(size) * 0.30103));
}

/* The residual must contain 0, and be narrow beside its terms, or by itself (a single
 * term that vanishes, such as a constraint that is an equation); with the most bits, beside what it changes by. */
static bool vanishes(struct check *c, const char *what, int index)
{
    if (!arb_is_finite(c->sum))
        return sga_fail(c->err, SGA_E_UNDECIDED, "the witness found no value of %s %d at a point of the final set", what, index + 1);
    if (!arb_contains_zero(c->sum))
        return sga_fail(c->err, SGA_E_WITNESS, "the witness found that %s %d does not hold at a random point of the final set", what, index + 1);
    arb_get_mag(c->part, c->sum);
    int digits = 1000;
    if (!mag_is_zero(c->part)) {
        digits = digits_of(c->part);
        mag_div(c->size, c->part, c->size);
        int relative = digits_of(c->size);
        digits = relative > digits ? relative : digits;
        if (digits < LEAST_DIGITS && c->last) {
            mag_mul_2exp_si(c->part, c->part, -c->slope);
            digits = digits_of(c->part);
            c->beside = true;
        }
    }
    if (digits < c->digits)
        c->digits = digits;
    if (digits < LEAST_DIGITS)
        return sga_fail(c->err, SGA_E_UNDECIDED, "the witness knows %s %d to %d digits only at a point of the final set", what, index + 1, digits);
    assert(digits >= LEAST_DIGITS && c->digits <= digits);
    return true;
}

static arb_ptr claimed(struct check *c, expr_id e)
{
    return num_ball_value(&c->point->ball, e);
}

/* What is added up in e counts, too: s - cosh(10^6 x) is 0 beside numbers of any size. */
static void add_parts(struct check *c, struct num_ball *b, expr_id e)
{
    enum { PARTS = 200 };
    const struct expr_store *st = b->st;
    expr_id part[PARTS];
    int parts = 0;
    for (part[parts++] = e; parts; ) {
        expr_id at = part[--parts];
        const struct expr_node n = st->node[at];
        bool sum = n.op == EXPR_ADD || n.op == EXPR_SUB || n.op == EXPR_NEG;
        if (!sum || parts + 2 > PARTS) {
            arb_get_mag(c->part, num_ball_value(b, at));
            mag_add(c->size, c->size, c->part);
            continue;
        }
        part[parts++] = n.a;
        if (n.op != EXPR_NEG)
            part[parts++] = n.b;
    }
}

/* rows of A times v (v[j] claimed), minus alpha where inhomogeneous */
static bool check_rows(struct check *c, const expr_id *v, bool inhomogeneous, const char *what)
{
    SGA_ENDS(arb_end) arb_t one = { 0 };
    arb_set_si(one, -1);
    bool ok = true;
    for (int i = 0; i < c->sys->rows && ok; i++) {
        const struct sys_row *r = c->sys->row + i;
        begin(c);
        for (int k = 0; k < r->entries; k++)
            add_term(c, num_ball_value(&c->own, r->entry[k].value), claimed(c, v[r->entry[k].col]));
        if (inhomogeneous) {
            add_term(c, num_ball_value(&c->own, r->alpha), one);
            add_parts(c, &c->own, r->alpha);
        }
        ok = vanishes(c, what, i);
    }
    return ok;
}

/* A variable at rest adds nothing, where the constraint has no derivative by it too (s = x^(3/5) where x stays 0). */
static bool moves(const struct check *c, expr_id v)
{
    return !expr_is_zero(c->claim->st, v);
}

/* What the constraint changes by where a variable of it moves by its natural size: that a residual is small beside this says the same
 * of any multiple of the constraint (x - exp(-10^8 t^2) and x exp(10^8 t^2) - 1). */
static void note_slopes(struct check *c, int constraint)
{
    const int *scale = c->claim->solution->scale;
    for (int k = 0; k < c->jac->cols[constraint]; k++) {
        arb_srcptr slope = c->jac->entry[constraint] + k;
        if (!arb_is_finite(slope) || arb_contains_zero(slope))
            continue;
        slong e = num_ball_log2(arb_midref(slope)) - 1 + (scale ? scale[c->jac->col[constraint][k]] : 0);
        c->slope = e > c->slope ? e : c->slope;
    }
}

static bool check_tangency(struct check *c, const expr_id *v, bool inhomogeneous, const char *what)
{
    SGA_ENDS(arb_end) arb_t one = { 0 };
    arb_one(one);
    bool ok = true;
    for (int i = 0; i < c->claim->constraints && ok; i++) {
        begin(c);
        for (int k = 0; k < c->jac->cols[i]; k++)
            if (moves(c, v[c->jac->col[i][k]]))
                add_term(c, c->jac->entry[i] + k, claimed(c, v[c->jac->col[i][k]]));
        if (inhomogeneous)
            for (int k = 0; k < c->time.cols[i]; k++) {
                int rate = c->rate[c->time.col[i][k]];
                add_term(c, c->time.entry[i] + k, rate < 0 ? one : c->point->ball.symbol + rate);
            }
        note_slopes(c, i);
        ok = vanishes(c, what, i);
    }
    return ok;
}

/* What moves with time by itself. */
static void make_clock(struct check *c)
{
    const struct sga_claim *cl = c->claim;
    c->clock = sga_malloc((size_t)(cl->parameters + 1) * sizeof *c->clock);
    c->rate = sga_malloc((size_t)(cl->parameters + 1) * sizeof *c->rate);
    c->clock[0] = cl->time;
    c->rate[0] = -1;
    c->clocks = 1;
    for (int i = 0; i < cl->parameters; i++) {
        bool signal = cl->st->symbol[cl->parameter[i]].kind == EXPR_SIGNAL;
        int rate = signal ? expr_signal_next(cl->st, cl->parameter[i]) : -1;
        if (rate < 0)
            continue;            /* of the highest derivative: nothing depends on that */
        c->clock[c->clocks] = cl->parameter[i];
        c->rate[c->clocks++] = rate;
    }
}

/* The same point for the system's own store: symbols by name. */
static void transfer(struct check *c)
{
    const struct expr_store *from = c->claim->st, *to = c->sys->store;
    num_ball_init(&c->own, to, c->prec);
    if (from == to) {
        for (int i = 0; i < to->symbols && (size_t)i < c->point->ball.symbol_cap; i++)
            num_ball_set(&c->own, i, c->point->ball.symbol + i);
    } else {
        for (int j = 0; j < c->sys->variables; j++)
            num_ball_set(&c->own, c->sys->variable[j].symbol, c->point->ball.symbol + c->claim->variable[j]);
        for (int j = 0; j < c->sys->parameters; j++)
            num_ball_set(&c->own, c->sys->parameter[j], c->point->ball.symbol + c->claim->parameter[j]);
        num_ball_set(&c->own, c->sys->time, c->point->ball.symbol + c->claim->time);
    }
    num_ball_list(&c->own, c->asked.list, c->asked.count);
}

/* Rows of the system, and what the answer rests on; of the claim fields and gauge fields. */
static void list_asked(struct check *c)
{
    const struct sga_claim *cl = c->claim;
    const struct sga_solution *sol = cl->solution;
    SGA_FREED expr_id *root = NULL;
    size_t cap = 0;
    int roots = 0, zeros = c->oracle ? c->oracle->zeros : 0;
    for (int i = 0; i < c->sys->rows; i++) {
        const struct sys_row *r = c->sys->row + i;
        SGA_RESERVE(root, cap, roots + r->entries + 1);
        root[roots++] = r->alpha;
        for (int k = 0; k < r->entries; k++)
            root[roots++] = r->entry[k].value;
    }
    SGA_RESERVE(root, cap, roots + zeros + sol->pivots + sol->sides + 1);
    for (int i = 0; i < zeros; i++)
        root[roots++] = c->oracle->zero[i].expr;
    for (int q = 0; q < sol->pivots; q++)
        root[roots++] = sol->pivot[q].value;
    for (int q = 0; q < sol->sides; q++)
        root[roots++] = sol->side[q].function;
    expr_cone_init(&c->asked);
    expr_cone_of(c->sys->store, &c->asked, root, roots);
    expr_cone_init(&c->said);
    if (!cl->field)
        return;
    roots = cl->variables * (1 + cl->gauges);
    SGA_RESERVE(root, cap, roots + 1);
    memcpy(root, cl->field, (size_t)cl->variables * sizeof *root);
    if (cl->gauges)
        memcpy(root + cl->variables, cl->gauge, (size_t)cl->gauges * (size_t)cl->variables * sizeof *root);
    expr_cone_of(cl->st, &c->said, root, roots);
}

static bool check_point(struct check *c)
{
    const struct sga_claim *cl = c->claim;
    assert(cl->field || !cl->gauges);
    if (!cl->field)
        return true;                /* the point lies on the constraints: no more is claimed */
    transfer(c);
    points_jacobian_values(c->jac, &c->point->ball);
    points_jacobian_entries(c->jac, &c->point->ball);
    points_jacobian_entries(&c->time, &c->point->ball);
    num_ball_forget(&c->point->ball);
    num_ball_list(&c->point->ball, c->said.list, c->said.count);
    bool ok = check_rows(c, cl->field, true, "equation")
              && check_tangency(c, cl->field, true, "tangency of the vector field to constraint");
    for (int g = 0; g < cl->gauges && ok; g++) {
        const expr_id *z = cl->gauge + (size_t)g * (size_t)cl->variables;
        ok = check_rows(c, z, false, "the kernel condition of a gauge field in equation")
             && check_tangency(c, z, false, "tangency of a gauge field to constraint");
    }
    num_ball_clear(&c->own);
    return ok;
}

/* A ball that contains 0 and is narrow. */
static bool seems_zero(const arb_t v)
{
    return arb_contains_zero(v) && mag_cmp_2exp_si(arb_radref(v), -60) < 0;
}

/* Whether so few bits do not tell the pivot from 0 at the reduction's own point either. */
static bool tiny(const struct check *c, expr_id pivot)
{
    if (!c->oracle || !c->oracle->reals)
        return true;
    struct num_ball *b = &((struct points_oracle *)c->oracle)->real[0].ball;
    num_ball_ask(b, pivot);
    return arb_contains_zero(num_ball_value(b, pivot));
}

/* Whether the answer speaks of the point: it is on the sides of surfaces that the answer is about, the equations have
 * values there (sqrt(x) has none where x < 0), what the reduction took for 0 is, and what it divided by is not. */
static bool spoken_of(struct check *c)
{
    const struct sga_solution *sol = c->claim->solution;
    c->prec = c->point->ball.prec;
    transfer(c);
    bool in = !sol->sides || points_on_sides(c->sys->store, &c->own, sol->side, sol->sides);
    for (int i = 0; i < c->sys->rows && in; i++) {
        const struct sys_row *r = c->sys->row + i;
        in = arb_is_finite(num_ball_value(&c->own, r->alpha));
        for (int k = 0; k < r->entries && in; k++)
            in = arb_is_finite(num_ball_value(&c->own, r->entry[k].value));
    }
    for (int i = 0; c->oracle && i < c->oracle->zeros && in; i++)
        in = c->oracle->zero[i].constraints > c->claim->constraints || arb_contains_zero(num_ball_value(&c->own, c->oracle->zero[i].expr));
    for (int q = 0; q < sol->pivots && in; q++)
        in = !seems_zero(num_ball_value(&c->own, sol->pivot[q].value)) || tiny(c, sol->pivot[q].value);
    num_ball_clear(&c->own);
    return in;
}

/* Regular functions that took a constraint's place near the points may have more zeros elsewhere: that is said of them. */
static bool near_only(const struct sga_solution *sol)
{
    bool is = false;
    for (int i = 0; i < sol->constraints; i++)
        is |= sol->constraint[i].near_point;
    return is;
}

/* The answer does not hold at a far point of its own constraints. */
static void part_only(struct check *c, const char *why)
{
    SGA_ENDS(sga_buf_free) struct sga_buf at = { 0 };
    for (int j = 0; j < c->claim->variables && j < 8; j++)
        sga_buf_printf(&at, "%s%s = %.4g", j ? ", " : "", c->sys->store->symbol[c->sys->variable[j].symbol].name, c->point->x[j]);
    sga_warn(c->budget, SGA_W_PART_ONLY, "", "near %s: %.200s", at.data, why);
}

/* A point of the claimed set: from a start near the guess, or (far) from one of the witness's own that no point of the
 * reduction lies near to. */
static enum points_status draw(const struct points_space *space, const int *end, int stages, int k, bool far, uint64_t *random,
                               struct points_point *p)
{
    struct points_space own = *space;
    if (far) {
        own.near = NULL;
        own.starts = 4;
    }
    return points_find_staged(&own, end, stages, own.near ? 0.03 * (k + 1) : 1 + k, random, witness_bits[0], p);
}

/* q = exp(-10^8 x^2) is known to so many digits of 1, and not of itself, where steps met it: solved variable by variable, it may be known to
 * digits of its own, and an answer that is wrong by a part of it is seen. False: it is. */
static bool check_closely(struct check *c, const struct points_space *space)
{
    struct points_space own = *space;
    SGA_ENDS(points_point_clear) struct points_point here;
    struct points_point *point = c->point;
    struct sga_error found = { 0 }, *err = c->err;
    uint64_t random = SGA_SEED_WITNESS_DRAWS;
    int digits = c->digits;
    own.near = point->x;
    own.near_time = point->t;
    own.parameter_value = point->parameter;
    own.by_shape = true;
    own.starts = 1;
    bool solved = points_find(&own, 0, &random, witness_bits[0], &here) == POINTS_OK && here.certified, ok = true;
    if (solved) {
        c->point = &here;
        c->err = &found;
        c->last = false;
        c->prec = witness_bits[0];
        ok = !spoken_of(c) || check_point(c) || found.code != SGA_E_WITNESS;
    }
    c->point = point;
    c->err = err;
    c->digits = digits;
    if (!ok)
        *err = found;
    return ok;
}

/* check_point with as many bits as it takes. */
static bool check_levels(struct check *c, const struct points_space *space)
{
    struct sga_error *err = c->err;
    for (int l = 0; l < WITNESS_LEVELS; l++) {
        struct sga_error here = { 0 };
        int digits = c->digits;
        if (l && !points_refine(space, c->point, witness_bits[l]))
            break;
        c->prec = witness_bits[l];
        c->last = l + 1 == WITNESS_LEVELS;
        c->beside = false;
        c->err = &here;
        bool ok = check_point(c);
        c->err = err;
        if (ok)
            return !c->beside || check_closely(c, space);
        /* a point that is not certified may miss the set by what was found: more bits tell */
        bool sure = here.code != SGA_E_UNDECIDED && (c->point->certified || here.code != SGA_E_WITNESS);
        if (sure || l + 1 == WITNESS_LEVELS) {
            *err = here;
            return false;
        }
        c->digits = digits;
    }
    return sga_fail(err, SGA_E_UNDECIDED, "the witness could not refine a point of the final set");
}

/* Near the guess another component may be nearer, or nothing regular: near the reduction's own points, then. False: that is so already,
 * or there are none. */
static bool near_oracle(struct points_space *space, const struct points_oracle *oracle)
{
    if (!oracle || !oracle->reals || space->near == oracle->real[0].x)
        return false;
    space->near = oracle->real[0].x;
    space->near_time = oracle->real[0].t;
    return true;
}

bool sga_witness_check(const struct sys_system *system, const struct sga_claim *claim,
                       const struct points_oracle *oracle, const double *near, double near_time, uint64_t seed, int points,
                       const struct sga_budget *budget, struct sga_witness *result, struct sga_error *err)
{
    double start = sga_now();
    struct points_space space = {
        .st = claim->st, .variable = claim->variable, .variables = claim->variables,
        .parameter = claim->parameter, .parameters = claim->parameters, .time = claim->time,
        .constraint = claim->constraint, .constraints = claim->constraints,
        .near = near ? near : oracle && oracle->reals ? oracle->real[0].x : NULL,
        .near_time = near || !oracle || !oracle->reals ? near_time : oracle->real[0].t, .scale = claim->solution->scale, .time_unit = claim->solution->time_unit, .budget = budget,
    };
    struct points_space clock = space;
    SGA_ENDS(points_jacobian_clear) struct points_jacobian jac;
    struct check c = { .sys = system, .claim = claim, .oracle = oracle, .jac = &jac, .digits = 1000, .budget = budget, .err = err };
    make_clock(&c);
    list_asked(&c);
    clock.variable = c.clock;
    clock.variables = c.clocks;
    points_jacobian_init(&jac, &space);
    points_jacobian_init(&c.time, &clock);
    arb_init(c.sum);
    arb_init(c.term);
    mag_init(c.size);
    mag_init(c.part);
    *result = (struct sga_witness){ .certified = true };
    bool ok = true;
    int again = 0;
    uint64_t random = seed;
    SGA_FREED int *end = sga_calloc((size_t)claim->solution->generations + 1, sizeof *end);
    int stages = sga_stages(claim->solution, claim->solution->constraints, end);
    int fars = near_only(claim->solution) ? 0 : FAR_TRIES;
    for (int k = 0; k < points && ok; k++) {
        struct points_point p;
        bool far = k % 2 && fars > 0;
        enum points_status status = draw(&space, end, stages, k, far, &random, &p);
        c.point = &p;
        if (status == POINTS_STOPPED)
            ok = sga_budget_ok(budget, err);
        else if (status != POINTS_OK && !far && near_oracle(&space, oracle)) {
            points_point_clear(&p);
            k--;
            continue;
        } else if (status != POINTS_OK && !far)
            ok = k > 0 ? true : sga_fail(err, SGA_E_UNDECIDED, "the witness found no fresh point of the final set");
        if (ok && ((far && status != POINTS_OK) || (status == POINTS_OK && !spoken_of(&c)))) {
            points_point_clear(&p);
            fars -= far;
            again += !far;
            k -= far || again < 20;
            if (again)
                near_oracle(&space, oracle);
            continue;
        }
        if (status == POINTS_OK) {
            ok = check_levels(&c, &space);
            result->points += ok;
            result->far += ok && far;
            result->certified &= p.certified || !ok;
        }
        if (!ok && far && (err->code == SGA_E_WITNESS || err->code == SGA_E_UNDECIDED)) {
            if (err->code == SGA_E_WITNESS)
                part_only(&c, err->detail);
            *err = (struct sga_error){ 0 };
            fars--;
            k--;
            ok = true;
        }
        points_point_clear(&p);
    }
    if (ok && again && !result->points)
        ok = sga_fail(err, SGA_E_UNDECIDED, "the witness found no fresh point of the final set where the equations have a value");
    expr_cone_clear(&c.asked);
    expr_cone_clear(&c.said);
    free(c.clock);
    free(c.rate);
    arb_clear(c.sum);
    arb_clear(c.term);
    mag_clear(c.size);
    mag_clear(c.part);
    points_jacobian_clear(&c.time);
    result->digits = c.digits;
    result->seconds = sga_now() - start;
    if (!ok)
        memcpy(err->stage, "witness", 8);
    return ok;
}
