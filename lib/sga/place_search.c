/* Searches of the present set for places where a function vanishes. */
#include "place_search.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "sides.h"
#include "warnings.h"

enum points_status place_sample_near(struct state *s, const double *x, double t)
{
    struct points_space keep = s->space;
    uint64_t random = s->oracle->random;
    points_oracle_forget(s->oracle);
    s->oracle->random = random;
    s->space.near = x;
    s->space.near_time = t;
    enum points_status status = state_sample(s);
    s->space.near = keep.near;
    s->space.near_time = keep.near_time;
    return status;
}

bool place_vanishes_far(struct state *s, expr_id e)
{
    struct points_space space = s->space;
    uint64_t random = s->oracle->random;
    bool all = true;
    space.near = NULL;
    space.before = NULL;
    double size = 1;
    for (int j = 0; j < space.variables && space.scale; j++)
        size = fmax(size, ldexp(1, space.scale[j]));
    for (int k = 0; k < 8 && all; k++) {
        SGA_ENDS(points_point_clear) struct points_point p;
        if (points_find(&space, (1 + k) * (k % 2 ? size : 1), &random, POINTS_BITS, &p) == POINTS_OK) {
            num_ball_extend(&p.ball);
            all = arb_contains_zero(num_ball_value(&p.ball, e));
        }
    }
    return all;
}

enum points_status place_with(struct state *s, expr_id extra, struct points_point *p)
{
    struct points_space space = s->space;
    uint64_t random = s->oracle->random;
    int c = s->sol->constraints;
    SGA_FREED expr_id *con = sga_malloc((size_t)(c + 1) * sizeof *con);
    if (c)
        memcpy(con, s->con, (size_t)c * sizeof *con);
    con[c] = extra;
    space.constraint = con;
    space.constraints = c + 1;
    return points_find(&space, space.near ? 0 : 1, &random, POINTS_BITS, p);
}

bool place_holds_elsewhere(struct state *s, expr_id e)
{
    SGA_ENDS(points_point_clear) struct points_point p = { 0 };
    if (s->sol->constraints > SGA_MOST_ELSEWHERE)
        sga_limit_met(s->options->budget, SGA_LIMIT_ELSEWHERE);
    if (!s->sol->constraints || s->sol->constraints > SGA_MOST_ELSEWHERE)
        return false;
    enum points_status status = place_with(s, e, &p);
    bool there = (status == POINTS_IRREGULAR || status == POINTS_OK) && place_sample_near(s, p.x, p.t) == POINTS_OK
                 && ech_zero(&s->ctx, e) == 1;
    if (!there && state_sample(s) != POINTS_OK)
        points_oracle_forget(s->oracle);
    return there;
}

/* Whether e is made with functions that are one analytic function on each side of a surface. */
static bool has_sides(struct state *s, expr_id e)
{
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count; k++)
        if (points_switches(expr_op_of(s->st, s->cone.list[k])))
            return true;
    return false;
}

bool place_holds_on_side(struct state *s, expr_id e)
{
    enum { TRIES = 16 };
    if (!has_sides(s, e))
        return false;
    struct points_space space = s->space;
    uint64_t random = s->oracle->random;
    int sides = s->oracle->sides;
    space.constraint = s->con;
    space.constraints = s->sol->constraints;
    space.before = NULL;
    bool found = false;
    for (int k = 0; k < TRIES && !found; k++) {
        SGA_ENDS(points_point_clear) struct points_point p;
        if (points_find(&space, space.near ? 0.05 * k : 1 + 0.5 * k, &random, POINTS_BITS, &p) == POINTS_OK) {
            num_ball_extend(&p.ball);
            if (arb_contains_zero(num_ball_value(&p.ball, e)) && place_sample_near(s, p.x, p.t) == POINTS_OK)
                found = points_oracle_zero(s->oracle, e).truth == POINTS_ZERO && s->oracle->sides > sides;
            if (!found)
                s->oracle->sides = sides;
        }
    }
    return found;
}
