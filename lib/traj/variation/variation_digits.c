/* A start that is a nearest point, with its derivatives, to the digits of longer numbers: what balls prove of it (enclosed_nearest.c). */
#include "variation.h"

#include <math.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "enclosed.h"
#include "field.h"
#include "flint_ends.h"
#include "mem.h"
#include "points.h"

/* Bits of the balls; what their radii may be, beside 1 + the size: below double-double's roundings; and how far the point may be from that in double. */
enum { BITS = 200 };
static const double SHARP = 1e-36, SAME_POINT = 1e-6;

static bool sharp(const arb_t x, double near)
{
    double size = 1 + fabs(near);
    return arb_is_finite(x) && mag_get_d(arb_radref(x)) <= SHARP * size && fabs(arf_get_d(arb_midref(x), ARF_RND_NEAR) - near) <= SAME_POINT * size;
}

bool variation_digits(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, struct traj_request *rq, expr_id *exact)
{
    int n = sys->variables;
    SGA_ARENA(mem);
    SGA_FREED int *variable = field_inputs(sys);
    SGA_ENDS(arb_end) arb_t t0 = { 0 };
    SGA_ENDS(fmpq_end) fmpq_t q = { 0 };
    arb_ptr x = arbs_take(&mem, n);
    struct enclose_problem p = { .st = sys->store, .variable = variable, .n = n, .time = sys->time, .budget = rq->budget };
    if (!rq->asked || !rq->asked->nearest || !rq->exact_time)
        return false;
    num_ball_constant(sys->store, rq->exact_start, rq->start, 2 * BITS, t0);
    bool ok = enclosed_nearest(sys, &p, sol, rq, NULL, v->initial, t0, BITS, x);
    for (int i = 0; i < n && ok; i++) {
        ok = sharp(x + i, v->initial[i]);
        if (ok) {
            arf_get_fmpq(q, arb_midref(x + i));
            exact[i] = expr_fmpq(sys->store, q);
            v->initial[i] = arf_get_d(arb_midref(x + i), ARF_RND_NEAR);
            if (fabs(v->initial[i]) <= SHARP) {       /* 0, whose roundings would be taken for the size that it has */
                v->initial[i] = 0;
                exact[i] = expr_int(sys->store, 0);
            }
        }
    }
    if (!ok || !expr_store_ok(sys->store))
        return false;
    rq->exact_initial = exact;
    rq->asked = NULL;
    return true;
}
