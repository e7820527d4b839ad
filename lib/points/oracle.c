/* The points of the zero oracle: sampled where the set changes, raised to more bits where a decision asks for them. */
#include "oracle.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "beyond.h"
#include "budget.h"
#include "mem.h"
#include "modpoint.h"
#include "search.h"

void points_oracle_init(struct points_oracle *s, uint64_t seed)
{
    *s = (struct points_oracle){ .random = seed, .least_digits = 1 << 20, .height = -1 };
    s->real = sga_calloc(POINTS_REAL, sizeof *s->real);
    s->high = sga_calloc(POINTS_REAL, sizeof *s->high);
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

void points_oracle_lower(struct points_oracle *s)
{
    if (s->high_bits)
        for (int i = 0; i < s->reals; i++)
            points_point_clear(s->high + i);
    s->high_bits = 0;
}

void points_oracle_forget(struct points_oracle *s)
{
    points_oracle_lower(s);
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

void points_oracle_release(struct points_oracle *s)
{
    for (int i = 0; i < s->reals; i++) {
        num_ball_release(&s->real[i].ball);
        if (s->high_bits)
            num_ball_release(&s->high[i].ball);
    }
}

void points_oracle_clear(struct points_oracle *s)
{
    points_oracle_forget(s);
    if (s->beyond)
        points_beyond_clear(s->beyond);
    free(s->beyond);
    free(s->real);
    free(s->high);
    free(s->modular);
    free(s->zero);
    free(s->side);
    free(s->variable);
    free(s->parameter);
    free(s->constraint);
    free(s->end);
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
    SGA_ENDS(points_search_clear) struct points_search search;
    points_search_init(&search, &space);
    for (int k = 0; k < POINTS_REAL; k++) {
        /* a guess is only a guess: go a little away from it, to a generic point */
        double spread = k == 0 && !s->space.near ? 1 : (s->space.near_spread > 0 ? s->space.near_spread : 0.05) * (1 + k);
        space.before = k < befores ? before + k : NULL;
        space.side = s->side;
        space.sides = s->sides;
        space.same_branches = true;
        space.search = &search;
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
    int *end = copy_of(space->end, (size_t)space->ends, sizeof *end);
    signed char *cheap = space->cheap ? copy_of(space->cheap, (size_t)space->variables, sizeof *cheap) : NULL;
    s->space = *space;
    free(s->defined);
    free(s->cheap);
    free(s->end);
    free(s->variable);
    free(s->parameter);
    free(s->constraint);
    s->space.end = s->end = end;
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
    for (int k = 0; k < befores; k++)
        num_ball_clear(&before[k].ball);      /* starts are numbers: all values beside those of the next points would be twice the memory */
    points_oracle_lower(s);
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

bool points_oracle_raise(struct points_oracle *s, slong bits)
{
    if (s->high_bits >= bits)
        return true;
    const struct points_space *space = &s->space;
    struct points_point higher[POINTS_REAL];
    int count = 0;
    bool ok = true;
    assert(s->reals <= POINTS_REAL);
    for (; count < s->reals && ok; count++) {       /* from the digits that there are */
        points_point_copy(higher + count, (s->high_bits ? s->high : s->real) + count, bits);
        ok = !space->constraints || points_refine(space, higher + count, bits);
    }
    points_oracle_lower(s);
    for (int k = 0; k < count; k++)
        if (ok)
            s->high[k] = higher[k];
        else
            points_point_clear(higher + k);
    s->high_bits = ok ? bits : 0;
    return ok;
}

bool points_oracle_certified(const struct points_oracle *s)
{
    bool all = s->reals > 0;
    for (int k = 0; k < s->reals; k++)
        all = all && s->real[k].certified;
    return all;
}

double points_oracle_magnitude(struct points_oracle *s, expr_id e)
{
    assert(s->reals > 0);
    num_ball_ask(&s->real[0].ball, e);
    SGA_ENDS(mag_end) mag_t m = { 0 };
    arb_get_mag(m, num_ball_value(&s->real[0].ball, e));
    return mag_is_special(m) ? -1e9 : mag_get_d_log2_approx(m);
}
