/* One more point, near the set: see at_start.h. */
#include "at_start.h"

#include <math.h>

#include "ball.h"
#include "echelon.h"
#include "oracle.h"
#include "points.h"

enum { BITS = 64 };
/* log2, beside the value in general. */
static const double FAINT = -30, NOTHING = 100;

void at_start_init(struct at_start *a, const struct ech_context *c)
{
    const struct points_space *space = &c->oracle->space;
    const struct points_point *p = c->oracle->real;
    *a = (struct at_start){ .known = c->near && c->oracle->reals };
    if (!a->known)
        return;
    num_ball_init(&a->ball, c->st, BITS);
    for (int j = 0; j < space->parameters; j++)
        num_ball_set_d(&a->ball, space->parameter[j], p->parameter[j]);
    for (int j = 0; j < space->variables; j++)
        num_ball_set_d(&a->ball, space->variable[j], !c->near_given || c->near_given[j] ? c->near[j] : p->x[j]);
    if (space->time >= 0)
        num_ball_set_d(&a->ball, space->time, c->near_time);
}

void at_start_clear(struct at_start *a)
{
    if (a->known)
        num_ball_clear(&a->ball);
    a->known = false;
}

double at_start_value(struct at_start *a, expr_id e)
{
    if (!a->known)
        return 0;
    num_ball_extend(&a->ball);
    arb_srcptr v = num_ball_value(&a->ball, e);
    return !arb_is_finite(v) || arb_contains_zero(v) ? 0 : arf_get_d(arb_midref(v), ARF_RND_NEAR);
}

double at_start_faintness(struct at_start *a, const struct ech_context *c, expr_id e)
{
    double bits = a->known ? points_oracle_magnitude(c->oracle, e) - log2(fabs(at_start_value(a, e))) : 0;
    return bits < 0 || isnan(bits) ? 0 : fmin(bits, NOTHING);
}

bool at_start_vanishes(struct at_start *a, const struct ech_context *c, expr_id e)
{
    return a->known && !(log2(fabs(at_start_value(a, e))) > points_oracle_magnitude(c->oracle, e) + FAINT);
}
