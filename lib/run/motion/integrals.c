/* First integrals whose drift is reported: those that the request lists, and the energy of an
 * autonomous Hamiltonian or Lagrangian system. Whether they are constant along the motion is
 * decided like everything else: X(f) = 0 and K(f) = 0 on the final set, by the oracle; but for the energy of a Lagrangian. */
#include "integrate.h"

#include "form.h"
#include "run_job.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "job_integrals.h"
#include "oracle.h"
#include "reduction.h"
#include "request.h"
#include "system.h"
#include "trajectory.h"

/* sum over the gradient of f times a vector; time counts as `rate`. */
static expr_id along(struct job *j, const struct expr_term *gradient, int terms, const expr_id *vector, const int *place, expr_id rate)
{
    struct expr_store *st = &j->request->store;
    expr_id sum = expr_int(st, 0);
    for (int i = 0; i < terms; i++) {
        int variable = place[gradient[i].symbol];
        expr_id speed = variable < 0 ? rate : vector[variable];
        sum = expr_add(st, sum, expr_mul(st, gradient[i].value, speed));
    }
    return sum;
}

static enum points_truth conserved(struct job *j, const struct sga_solution *s, struct points_oracle *oracle, expr_id f)
{
    struct expr_store *st = &j->request->store;
    const struct sys_system *sys = &j->request->system;
    SGA_ARENA(mem);
    unsigned char *active = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    int *place = sga_take(&mem, (size_t)(st->symbols + 1) * sizeof *place);
    struct expr_cone cone;
    struct expr_term *gradient = NULL;
    size_t cap = 0;
    for (int v = 0; v < sys->variables; v++) {
        active[sys->variable[v].symbol] = 1;
        place[sys->variable[v].symbol] = v;
    }
    active[sys->time] = 1;
    place[sys->time] = -1;
    expr_cone_init(&cone);
    int terms = expr_gradient(st, &cone, f, active, &gradient, &cap);
    enum points_truth truth = points_oracle_zero(oracle, along(j, gradient, terms, s->field, place, expr_int(st, 1))).truth;
    if (s->free_columns && !s->gauge)
        truth = POINTS_UNKNOWN;
    for (int k = 0; k < s->free_columns && truth != POINTS_UNKNOWN; k++) {
        const expr_id *field = s->gauge + (size_t)k * (size_t)sys->variables;
        enum points_truth here = points_oracle_zero(oracle, along(j, gradient, terms, field, place, expr_int(st, 0))).truth;
        truth = here == POINTS_ZERO ? truth : POINTS_UNKNOWN;      /* it depends on the choice of gauge */
    }
    expr_cone_clear(&cone);
    free(gradient);
    return truth;
}

/* H, or sum v dL/dv - L; EXPR_UNDEF where there is none. */
static expr_id energy(struct job *j)
{
    struct expr_store *st = &j->request->store;
    if (j->request->hamiltonian)
        return j->request->hamiltonian->hamiltonian;
    expr_id L = j->request->lagrangian, sum = EXPR_UNDEF;
    int k = j->request->coordinates;
    if (L == EXPR_UNDEF || !k)
        return EXPR_UNDEF;
    sum = expr_neg(st, L);
    for (int i = 0; i < k; i++) {
        int velocity = j->request->system.variable[k + i].symbol;
        sum = expr_add(st, sum, expr_mul(st, st->symbol[velocity].node, expr_diff(st, L, velocity)));
    }
    return sum;
}

/* Along Euler-Lagrange equations without forces and time the energy is conserved: E' = v (p' - dL/dq) = lambda dg/dt = 0, whatever is free. */
static bool by_lagrange(const struct job *j, const struct sga_solution *s)
{
    const struct request *r = j->request;
    return r->lagrangian != EXPR_UNDEF && r->coordinates && !r->system.signals && !r->modes && !s->depends_on_time;
}

void answer_integrals(struct job *j, const struct sga_solution *s, struct points_oracle *oracle, struct traj_request *r)
{
    const struct request_trajectory *t = &j->request->trajectory;
    j->integrals = NULL;
    if (!(j->request->want & REQUEST_TRAJECTORY) || s->verdict == SGA_ISOLATED)
        return;
    size_t most = (size_t)t->integrals + 1;
    j->integrals = sga_zeros(&j->mem, 1, sizeof *j->integrals);
    j->integrals->expr = sga_zeros(&j->mem, most, sizeof *j->integrals->expr);
    j->integrals->given = sga_zeros(&j->mem, most, sizeof *j->integrals->given);
    j->integrals->truth = sga_zeros(&j->mem, most, sizeof *j->integrals->truth);
    expr_id own = energy(j);
    if (own != EXPR_UNDEF && (by_lagrange(j, s) || conserved(j, s, oracle, own) == POINTS_ZERO)) {
        j->integrals->truth[0] = POINTS_ZERO;
        j->integrals->given[0] = -1;
        j->integrals->expr[j->integrals->count++] = own;
    }
    for (int k = 0; k < t->integrals; k++) {
        int at = j->integrals->count++;
        j->integrals->expr[at] = t->integral[k];
        j->integrals->given[at] = k;
        j->integrals->truth[at] = conserved(j, s, oracle, t->integral[k]);
    }
    assert((size_t)j->integrals->count <= most);
    r->integral = j->integrals->expr;
    r->integrals = j->integrals->count;
}
