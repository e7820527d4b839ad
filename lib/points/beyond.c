/* Switches of the constraints, and on which sides of them a zero holds. */
#include "beyond.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "facts.h"
#include "mem.h"
#include "pieces.h"
#include "points_space.h"
#include "sides.h"

void points_beyond_forget(struct points_beyond *b)
{
    for (int k = 0; k < b->pieces; k++) {
        points_point_clear(&b->piece[k].p);
        points_point_clear(&b->piece[k].back);
        free(b->piece[k].sign);
    }
    b->pieces = b->count = 0;
    b->listed = false;
}

void points_beyond_clear(struct points_beyond *b)
{
    points_beyond_forget(b);
    free(b->piece);
    free(b->at);
    free(b->group);
    free(b->constraint_group);
    *b = (struct points_beyond){ 0 };
}

bool points_beyond_has(const struct points_beyond *b, expr_id function)
{
    for (int i = 0; i < b->count; i++)
        if (b->at[i].function == function)
            return true;
    return false;
}

int points_beyond_group(struct points_beyond *b, int symbol)
{
    assert(b->group[symbol] >= 0 && b->group[symbol] < b->symbols);
    while (b->group[symbol] != symbol)
        symbol = b->group[symbol] = b->group[b->group[symbol]];
    return symbol;
}

/* Symbols of the list that stand for variables become one group. Returns it, or -1. */
static int join(struct points_beyond *b, const struct expr_store *st, const expr_id *list, int count, const unsigned char *variable)
{
    int group = -1;
    for (int k = 0; k < count; k++) {
        if (expr_op_of(st, list[k]) != EXPR_SYM || !variable[st->node[list[k]].a])
            continue;
        int g = points_beyond_group(b, st->node[list[k]].a);
        if (group < 0)
            group = g;
        b->group[g] = group;
    }
    return group;
}

static void add_switch(struct points_beyond *b, struct expr_store *st, struct expr_facts *facts, struct points_point *p, expr_id node, int group)
{
    expr_id u = points_surface(st, node);
    bool root = expr_op_of(st, node) == EXPR_SQRT;
    for (int i = 0; i < b->count; i++)
        b->at[i].root |= root && b->at[i].function == u;
    unsigned f = u ? expr_facts_of(facts, st, u) : EXPR_NONZERO;
    unsigned sees = f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME | EXPR_HAS_PARAMETER);
    if (f & EXPR_NONZERO || !sees || points_beyond_has(b, u))
        return;
    int sign = points_sign_at(p, u);
    if (!sign)
        return;             /* undecided: the set may lie in the surface */
    SGA_RESERVE(b->at, b->cap, b->count + 1);
    b->at[b->count++] = (struct points_switch){ .function = u, .sign = (signed char)sign, .group = group,
                                                .fixed = sees == EXPR_HAS_PARAMETER, .timed = sees & EXPR_HAS_TIME, .root = root };
}

void points_beyond_list(struct points_beyond *b, const struct points_space *space, struct points_point *p)
{
    struct expr_store *st = (struct expr_store *)space->st;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone = { 0 };
    SGA_ENDS(expr_facts_clear) struct expr_facts facts = { 0 };
    if (b->listed)
        return;
    b->listed = true;
    b->symbols = st->symbols;
    b->group = sga_realloc(b->group, (size_t)(st->symbols + 1) * sizeof *b->group);
    SGA_FREED unsigned char *variable = sga_calloc((size_t)st->symbols + 1, 1);
    for (int i = 0; i < st->symbols; i++)
        b->group[i] = i;
    for (int i = 0; i < space->variables; i++)
        variable[space->variable[i]] = 1;
    b->constraint_group = sga_realloc(b->constraint_group, (size_t)(space->constraints + 1) * sizeof *b->constraint_group);
    expr_facts_init(&facts);
    expr_cone_init(&cone);
    for (int i = 0; i < space->constraints && expr_store_ok(st); i++) {
        expr_cone_of(st, &cone, space->constraint + i, 1);
        int group = b->constraint_group[i] = join(b, st, cone.list, cone.count, variable);
        for (int k = 0; k < cone.count && group >= 0; k++)
            if (points_switches(expr_op_of(st, cone.list[k])))
                add_switch(b, st, &facts, p, cone.list[k], group);
    }
}

/* Whether constraints connect e with each switch (roots: of a square root): by switch into touches. False: with none. */
static bool connected(struct points_beyond *b, const struct expr_store *st, const expr_id *list, int count, bool roots, unsigned char *touches)
{
    bool any = false;
    for (int k = 0; k < count; k++) {
        int symbol = st->node[list[k]].a;
        if (expr_op_of(st, list[k]) != EXPR_SYM || symbol >= b->symbols)
            continue;
        int g = points_beyond_group(b, symbol);
        for (int i = 0; i < b->count; i++)
            any |= touches[i] |= (!roots || b->at[i].root) && points_beyond_group(b, b->at[i].group) == g;
    }
    return any;
}

/* 1: e is 0 there, 0: it is not, -1: not known. */
static int zero_at(struct points_point *p, expr_id e, const expr_id *list, int count)
{
    num_ball_list(&p->ball, list, count);
    arb_srcptr v = num_ball_value(&p->ball, e);
    int zero = !arb_is_finite(v) ? -1 : arb_contains_zero(v);
    num_ball_forget(&p->ball);
    return zero;
}

static void add_side(const struct points_switch *w, bool unseen, struct points_side **side, int *sides, size_t *cap)
{
    for (int i = 0; i < *sides; i++)
        if ((*side)[i].function == w->function) {
            (*side)[i].unseen &= unseen;
            return;
        }
    SGA_RESERVE(*side, *cap, *sides + 1);
    (*side)[(*sides)++] = (struct points_side){ w->function, w->sign, unseen };
}

void points_beyond_check(struct points_beyond *b, const struct points_space *space, struct points_point *p, expr_id e,
                         const expr_id *list, int count, struct points_side *side, int *sides, int known)
{
    assert(known >= 0 && known <= *sides);
    int kept = known;
    for (int i = known; i < *sides; i++) {
        struct points_point q = { 0 };
        bool both = points_pieces_over(b, space, p, side[i], &q) && zero_at(&q, e, list, count) == 1;
        points_point_clear(&q);
        if (both)
            continue;
        side[i].unseen = !points_pieces_near(b, space, p, side[i], &q);
        points_point_clear(&q);
        side[kept++] = side[i];
    }
    *sides = kept;
}

void points_beyond_pairs(struct points_beyond *b, const struct points_space *space, struct points_point *p, expr_id e,
                         const expr_id *list, int count, struct points_side **side, int *sides, size_t *cap)
{
    struct points_side pair[POINTS_PAIRS][2];
    int pairs = points_pairs_of(space->budget, (struct expr_store *)space->st, p, e, list, count, b, *side, *sides, pair);
    for (int i = 0; i < pairs; i++) {
        SGA_ENDS(points_point_clear) struct points_point one = { 0 }, both = { 0 };
        bool known = false;
        for (int k = 0; k < *sides; k++)
            known |= (*side)[k].function == pair[i][0].function || (*side)[k].function == pair[i][1].function;
        if (!known && points_pieces_over(b, space, p, pair[i][0], &one) && points_pieces_over(b, space, &one, pair[i][1], &both)
            && zero_at(&both, e, list, count) == 0) {
            SGA_RESERVE(*side, *cap, *sides + 1);
            (*side)[(*sides)++] = pair[i][1];
        }
    }
}

void points_beyond_sides(struct points_beyond *b, const struct points_space *space, struct points_point *p, expr_id e,
                         const expr_id *list, int count, bool roots, struct points_side **side, int *sides, size_t *cap)
{
    SGA_FREED unsigned char *touches = sga_calloc((size_t)b->count + 1, 1);
    if (b->count && connected(b, space->st, list, count, roots, touches)) {
        points_pieces_search(b, space, p, touches);
        for (int k = 0; k < b->pieces; k++) {
            struct points_piece *q = b->piece + k;
            const struct points_switch *w = b->at + q->last;
            if (!touches[q->last] || zero_at(&q->p, e, list, count) != 0 || !points_on_sides(space->st, &q->p.ball, *side, *sides))
                continue;
            /* not 0 back on this side either: another part of a set that is a union, and nothing about the switch */
            bool part = points_pieces_back(b, space, k) && zero_at(&q->back, e, list, count) == 0;
            add_side(w, part, side, sides, cap);
        }
        for (int i = 0; i < b->count; i++)
            if (touches[i] && b->at[i].reached == POINTS_NONE_BEYOND)
                add_side(b->at + i, true, side, sides, cap);
    }
}

/* By switches that are none of the constraints'. */
static void own_zeros(struct points_beyond *b, const struct points_space *space, struct points_point *p, expr_id e,
                      const expr_id *list, int count, struct points_side **side, int *sides, size_t *cap)
{
    struct expr_store *st = (struct expr_store *)space->st;
    for (int k = 0; k < count; k++) {
        expr_id u = points_switches(expr_op_of(st, list[k])) ? points_surface(st, list[k]) : EXPR_UNDEF;
        int sign = u && !points_beyond_has(b, u) ? points_sign_at(p, u) : 0;
        for (int i = 0; i < *sides; i++)
            sign = (*side)[i].function == u ? 0 : sign;
        if (!sign)
            continue;
        struct points_side from = { u, sign, false };
        SGA_ENDS(points_point_clear) struct points_point q = { 0 };
        if (points_pieces_over(b, space, p, from, &q) && zero_at(&q, e, list, count) == 1) {
            SGA_RESERVE(*side, *cap, *sides + 1);
            (*side)[(*sides)++] = from;
        }
    }
}

void points_beyond_zeros(struct points_beyond *b, const struct points_space *space, struct points_point *p, expr_id e,
                         const expr_id *list, int count, struct points_side **side, int *sides, size_t *cap)
{
    SGA_FREED unsigned char *touches = sga_calloc((size_t)b->count + 1, 1);
    own_zeros(b, space, p, e, list, count, side, sides, cap);
    if (b->count && connected(b, space->st, list, count, false, touches)) {
        points_pieces_search(b, space, p, touches);
        for (int k = 0; k < b->pieces; k++) {
            struct points_piece *q = b->piece + k;
            if (!touches[q->last] || zero_at(&q->p, e, list, count) != 1 || !points_on_sides(space->st, &q->p.ball, *side, *sides))
                continue;
            if (!points_pieces_back(b, space, k) || zero_at(&q->back, e, list, count) != 1)   /* otherwise on another part of a union */
                add_side(b->at + q->last, false, side, sides, cap);
        }
    }
}
