/* Points of a constraint set beyond its switches: the function of a switch is set to a value of the other sign, as one
 * more constraint, and Newton steps go there from a point that is known. */
#include "pieces.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "facts.h"
#include "flint_ends.h"
#include "mem.h"
#include "points_space.h"
#include "seeds.h"
#include "warnings.h"

enum { STARTS = 4, VALUES = 3, NEAR = -20 };
/* Of all sets of a reduction, in steps times nodes as in the search for strata. */
static const double ALL_WORK = SGA_MOST_SIDE_WORK;

/* The values of a switch beyond, against its value here: powers of 2. */
static const int shift[VALUES] = { -3, 0, -12 };

/* What is searched from: values of the variables that move. */
struct passage {
    struct points_space space;     /* with one more constraint */
    struct points_point before;
    struct points_point *from;
    int *variable, *scale;
    expr_id *constraint;
};

static double middle(const struct points_point *p, int symbol)
{
    return (size_t)symbol < p->ball.symbol_cap ? arf_get_d(arb_midref(p->ball.symbol + symbol), ARF_RND_NEAR) : 0;
}

/* The variables that move on the way over w, and the constraints that hold them: those that constraints connect with w; all,
 * and time or parameters too, where w depends on these. Room in q for all of them. */
static void movable(struct points_beyond *b, const struct points_space *space, const struct points_switch *w, struct passage *q)
{
    bool all = w->timed || w->fixed || w->group < 0;
    int g = all ? -1 : points_beyond_group(b, w->group), n = 0, c = 0;
    for (int i = 0; i < space->variables; i++) {
        if (!all && (space->variable[i] >= b->symbols || points_beyond_group(b, space->variable[i]) != g))
            continue;
        if (q->scale)
            q->scale[n] = space->scale[i];
        q->variable[n++] = space->variable[i];
    }
    for (int i = 0; i < space->constraints; i++)
        if (all || (b->constraint_group[i] >= 0 && points_beyond_group(b, b->constraint_group[i]) == g))
            q->constraint[c++] = space->constraint[i];
    if (w->timed && space->time >= 0)
        q->variable[n++] = space->time;
    for (int i = 0; w->fixed && i < space->parameters; i++)
        q->variable[n++] = space->parameter[i];
    q->space.variables = n;
    q->space.constraints = c + 1;
}

static struct passage begin(struct points_beyond *b, const struct points_space *space, const struct points_switch *w, struct points_point *from)
{
    struct passage q = { .space = *space, .from = from };
    size_t room = (size_t)(space->variables + space->parameters + 2);
    q.variable = sga_malloc(room * sizeof *q.variable);
    q.scale = space->scale && !w->timed && !w->fixed ? sga_malloc(room * sizeof *q.scale) : NULL;
    q.constraint = sga_malloc((size_t)(space->constraints + 1) * sizeof *q.constraint);
    movable(b, space, w, &q);
    q.before = (struct points_point){ .x = sga_malloc(room * sizeof(double)), .t = from->t, .parameter = sga_malloc(room * sizeof(double)) };
    for (int i = 0; i < q.space.variables; i++)
        q.before.x[i] = middle(from, q.variable[i]);
    for (int i = 0; i < space->parameters; i++)
        q.before.parameter[i] = middle(from, space->parameter[i]);
    if (space->time >= 0)
        q.before.t = middle(from, space->time);
    q.space.variable = q.variable;
    q.space.parameters = w->fixed ? 0 : space->parameters;
    q.space.parameter_value = q.before.parameter;
    q.space.time = w->timed ? -1 : space->time;
    q.space.constraint = q.constraint;
    q.space.near = q.before.x;
    q.space.near_time = q.before.t;
    q.space.scale = q.scale;
    q.space.starts = STARTS;
    return q;
}

static void end(struct passage *q)
{
    free(q->variable);
    free(q->scale);
    free(q->constraint);
    free(q->before.x);
    free(q->before.parameter);
}

/* The symbols that did not move. */
static void complete(const struct passage *q, struct points_point *p)
{
    const struct expr_store *st = q->space.st;
    SGA_FREED unsigned char *moved = sga_calloc((size_t)st->symbols + 1, 1);
    for (int i = 0; i < q->space.variables; i++)
        moved[q->variable[i]] = 1;
    for (int i = 0; i < st->symbols && (size_t)i < q->from->ball.symbol_cap; i++)
        if (!moved[i])
            num_ball_set(&p->ball, i, q->from->ball.symbol + i);
}

/* What the system is made of has values there. */
static bool defined(const struct points_space *space, struct points_point *p, struct expr_cone *cone)
{
    bool ok = true;
    expr_cone_of(space->st, cone, space->defined, space->defineds);
    num_ball_list(&p->ball, cone->list, cone->count);
    for (int i = 0; i < space->defineds && ok; i++)
        ok = arb_is_finite(num_ball_value(&p->ball, space->defined[i]));
    num_ball_forget(&p->ball);
    return ok;
}

/* u = sign 2^exponent on the set, from where the passage begins. Only on these sides, where there are any. */
static bool pass(struct points_beyond *b, struct passage *q, expr_id u, int sign, slong exponent,
                 const struct points_side *side, int sides, struct points_point *p)
{
    struct expr_store *st = (struct expr_store *)q->space.st;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_ENDS(fmpq_end) fmpq_t value = { { 0, 1 } };
    expr_cone_init(&cone);
    fmpq_set_si(value, sign, 1);
    exponent < 0 ? fmpq_div_2exp(value, value, (ulong)-exponent) : fmpq_mul_2exp(value, value, (ulong)exponent);
    q->constraint[q->space.constraints - 1] = expr_sub(st, u, expr_fmpq(st, value));
    expr_cone_of(st, &cone, q->constraint, q->space.constraints);
    double cost = cone.count + 20.0 * (q->space.constraints + q->space.variables);
    long granted = (long)fmax(0, fmin(STARTS * 60, (ALL_WORK - b->work) / cost)), steps = granted;
    uint64_t random = SGA_SEED_CELLS;
    q->space.steps = &steps;
    q->space.before = &q->before;
    q->space.side = side;
    q->space.sides = sides;
    *p = (struct points_point){ 0 };
    bool ok = expr_store_ok(st) && granted > 0 && points_find(&q->space, 0.3, &random, POINTS_BITS, p) == POINTS_OK && p->certified;
    if (ok) {
        complete(q, p);
        ok = defined(&q->space, p, &cone);
    }
    b->work += (double)(granted - (steps > 0 ? steps : 0)) * cost;
    b->denied = !ok && (granted < STARTS * 60 && steps <= 0);
    if (!ok)
        points_point_clear(p);
    return ok;
}

/* How large u is at the point: log2. */
static slong exponent_at(const struct points_space *space, struct points_point *p, expr_id u)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(space->st, &cone, &u, 1);
    num_ball_list(&p->ball, cone.list, cone.count);
    slong e = num_ball_log2(arb_midref(num_ball_value(&p->ball, u)));
    num_ball_forget(&p->ball);
    return e < -400 ? -400 : e > 400 ? 400 : e;
}

/* The sides of a piece, but for one switch, of those that move on the way over that. */
static int other_sides(struct points_beyond *b, const signed char *sign, int but, struct points_side *side)
{
    const struct points_switch *w = b->at + but;
    bool all = w->timed || w->fixed;
    int sides = 0;
    for (int i = 0; i < b->count; i++)
        if (i != but && (all || points_beyond_group(b, b->at[i].group) == points_beyond_group(b, w->group)))
            side[sides++] = (struct points_side){ b->at[i].function, sign[i], false };
    return sides;
}

static bool known(const struct points_beyond *b, const signed char *sign)
{
    for (int k = 0; k < b->pieces; k++)
        if (memcmp(b->piece[k].sign, sign, (size_t)b->count) == 0)
            return true;
    return false;
}

static void keep(struct points_beyond *b, const struct points_space *space, struct points_point *p, int last)
{
    signed char *sign = sga_malloc((size_t)b->count + 1);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < b->count; i++) {
        expr_cone_of(space->st, &cone, &b->at[i].function, 1);
        num_ball_list(&p->ball, cone.list, cone.count);
        arb_srcptr v = num_ball_value(&p->ball, b->at[i].function);
        sign[i] = arb_is_positive(v) ? 1 : arb_is_negative(v) ? -1 : 0;
        num_ball_forget(&p->ball);
    }
    SGA_RESERVE(b->piece, b->piece_cap, b->pieces + 1);
    b->piece[b->pieces++] = (struct points_piece){ .p = *p, .sign = sign, .last = last };
}

/* From a point (with these signs) over switch i: near it first, then far from it and very near, then wherever the others are. */
static bool leave(struct points_beyond *b, const struct points_space *space, struct points_point *from, const signed char *sign, int i, bool deeper)
{
    const struct points_switch *w = b->at + i;
    struct passage q = begin(b, space, w, from);
    SGA_FREED struct points_side *side = sga_malloc((size_t)(b->count + 1) * sizeof *side);
    int sides = other_sides(b, sign, i, side);
    slong e = exponent_at(space, from, w->function);
    struct points_point p;
    bool found = false, denied = false;
    for (int k = 0; k < (deeper ? 1 : 2 * VALUES) && !found; k++)
        if (k < VALUES || sides)
            denied |= !(found = pass(b, &q, w->function, -sign[i], e + shift[k % VALUES], side, k < VALUES ? sides : 0, &p)) && b->denied;
    b->denied = denied;
    if (found)
        keep(b, space, &p, i);
    end(&q);
    return found;
}

/* Whether the search beyond several switches may go on. */
static bool goes_on(struct points_beyond *b, const struct sga_budget *budget, int tries, int most)
{
    bool pieces = b->pieces >= most, tried = tries >= SGA_MOST_SIDE_TRIES;
    if (pieces || tried)
        sga_limit_met(budget, pieces ? SGA_LIMIT_SIDE_PIECES : SGA_LIMIT_SIDE_TRIES);
    b->cut_short |= b->work >= ALL_WORK;
    return !pieces && !tried && b->work < ALL_WORK;
}

static void search_deeper(struct points_beyond *b, const struct points_space *space, const signed char *own, const unsigned char *asked)
{
    SGA_FREED signed char *sign = sga_malloc((size_t)b->count + 1);
    int tries = 0, most = b->pieces + SGA_MOST_SIDE_PIECES;
    bool more = true;
    for (int k = 0; k < b->pieces && more; k++)
        for (int i = 0; i < b->count && asked[b->piece[k].last] && more; i++) {
            memcpy(sign, b->piece[k].sign, (size_t)b->count);
            if (!asked[i] || sign[i] != own[i])
                continue;
            sign[i] = (signed char)-sign[i];
            if (known(b, sign))
                continue;
            more = goes_on(b, space->budget, tries++, most);
            if (!more)
                break;
            sign[i] = own[i];
            struct points_point from = b->piece[k].p;     /* pieces may move in memory */
            leave(b, space, &from, sign, i, true);
            b->piece[k].p = from;
        }
}

void points_pieces_search(struct points_beyond *b, const struct points_space *space, struct points_point *p, const unsigned char *asked)
{
    SGA_FREED signed char *own = sga_malloc((size_t)b->count + 1);
    bool fresh = false;
    for (int i = 0; i < b->count; i++)
        own[i] = b->at[i].sign;
    for (int i = 0; i < b->count; i++) {
        struct points_switch *w = b->at + i;
        if (!asked[i] || w->reached != POINTS_NOT_ASKED)
            continue;
        bool found = sga_budget_ok(space->budget, NULL) && leave(b, space, p, own, i, false);
        w->reached = found ? POINTS_BEYOND : !b->denied ? POINTS_NONE_BEYOND : POINTS_NOT_SEARCHED;
        b->cut_short |= w->reached == POINTS_NOT_SEARCHED;
        fresh |= found;
    }
    if (fresh)
        search_deeper(b, space, own, asked);
}

/* A switch that is none of the constraints'. */
static struct points_switch alone(const struct points_space *space, struct points_side from)
{
    SGA_ENDS(expr_facts_clear) struct expr_facts facts;
    expr_facts_init(&facts);
    unsigned sees = expr_facts_of(&facts, space->st, from.function) & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME | EXPR_HAS_PARAMETER);
    return (struct points_switch){ .function = from.function, .sign = (signed char)from.sign, .fixed = sees == EXPR_HAS_PARAMETER,
                                   .timed = sees & EXPR_HAS_TIME, .group = -1 };
}

bool points_pieces_over(struct points_beyond *b, const struct points_space *space, struct points_point *p, struct points_side from,
                        struct points_point *q)
{
    struct points_switch w = alone(space, from);
    struct passage way = begin(b, space, &w, p);
    SGA_FREED struct points_side *side = sga_malloc((size_t)(b->count + 1) * sizeof *side);
    slong e = exponent_at(space, p, w.function);
    bool found = false;
    *q = (struct points_point){ 0 };
    for (int i = 0; i < b->count; i++)
        side[i] = (struct points_side){ b->at[i].function, b->at[i].sign, false };
    for (int k = 0; k < 2 * VALUES && !found; k++)      /* at first with the constraints' switches as they are; they may have the same surface */
        found = pass(b, &way, w.function, -w.sign, e + shift[k % VALUES], side, k < VALUES ? b->count : 0, q);
    end(&way);
    return found;
}

bool points_pieces_near(struct points_beyond *b, const struct points_space *space, struct points_point *p, struct points_side from,
                        struct points_point *q)
{
    struct points_switch w = alone(space, from);
    struct passage way = begin(b, space, &w, p);
    bool found = pass(b, &way, w.function, w.sign, exponent_at(space, p, w.function) + NEAR, NULL, 0, q);
    end(&way);
    return found;
}

bool points_pieces_back(struct points_beyond *b, const struct points_space *space, int k)
{
    assert(k >= 0 && k < b->pieces && b->piece[k].last < b->count);
    struct points_piece *piece = b->piece + k;
    if (piece->backed)
        return piece->backed > 0;
    const struct points_switch *w = b->at + piece->last;
    struct passage q = begin(b, space, w, &piece->p);
    SGA_FREED struct points_side *side = sga_malloc((size_t)(b->count + 1) * sizeof *side);
    int sides = other_sides(b, piece->sign, piece->last, side);
    slong e = exponent_at(space, &piece->p, w->function);
    piece->backed = pass(b, &q, w->function, -piece->sign[piece->last], e, side, sides, &piece->back) ? 1 : -1;
    end(&q);
    return piece->backed > 0;
}
