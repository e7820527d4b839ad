/* First integrals whose drift is reported: those that the request lists, and the energy of an
 * autonomous Hamiltonian or Lagrangian system. Whether they are constant along the motion is
 * decided like everything else: X(f) = 0 and K(f) = 0 on the final set, by the shadow. */
#include "answer.h"

#include <stdlib.h>
#include <string.h>

#include "derive.h"
#include "mem.h"

/* sum over the gradient of f times a vector; time counts as `rate`. */
static expr_id along(struct job *j, const struct expr_term *gradient, int terms, const expr_id *vector, const int *place, expr_id rate)
{
    struct expr_store *st = &j->request.store;
    expr_id sum = expr_int(st, 0);
    for (int i = 0; i < terms; i++) {
        int variable = place[gradient[i].symbol];
        expr_id speed = variable < 0 ? rate : vector[variable];
        sum = expr_add(st, sum, expr_mul(st, gradient[i].value, speed));
    }
    return sum;
}

static enum points_truth conserved(struct job *j, const struct sga_solution *s, struct points_shadow *shadow, expr_id f)
{
    struct expr_store *st = &j->request.store;
    const struct sys_system *sys = &j->request.system;
    unsigned char *active = sga_calloc((size_t)st->symbols + 1, 1);
    int *place = sga_malloc((size_t)(st->symbols + 1) * sizeof *place);
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
    enum points_truth truth = points_shadow_zero(shadow, along(j, gradient, terms, s->field, place, expr_int(st, 1))).truth;
    if (s->free_columns && !s->gauge)
        truth = POINTS_UNKNOWN;
    for (int k = 0; k < s->free_columns && truth != POINTS_UNKNOWN; k++) {
        const expr_id *field = s->gauge + (size_t)k * (size_t)sys->variables;
        enum points_truth here = points_shadow_zero(shadow, along(j, gradient, terms, field, place, expr_int(st, 0))).truth;
        truth = here == POINTS_ZERO ? truth : POINTS_UNKNOWN;      /* it depends on the choice of gauge */
    }
    expr_cone_clear(&cone);
    free(gradient);
    free(active);
    free(place);
    return truth;
}

/* H, or sum v dL/dv - L; EXPR_UNDEF where there is none. */
static expr_id energy(struct job *j)
{
    struct expr_store *st = &j->request.store;
    if (j->request.hamiltonian)
        return j->request.hamiltonian->hamiltonian;
    expr_id L = j->request.lagrangian, sum = EXPR_UNDEF;
    int k = j->request.coordinates;
    if (L == EXPR_UNDEF || !k)
        return EXPR_UNDEF;
    sum = expr_neg(st, L);
    for (int i = 0; i < k; i++) {
        int velocity = j->request.system.variable[k + i].symbol;
        sum = expr_add(st, sum, expr_mul(st, st->symbol[velocity].node, expr_diff(st, L, velocity)));
    }
    return sum;
}

void answer_integrals(struct job *j, const struct sga_solution *s, struct points_shadow *shadow, struct traj_request *r)
{
    const struct request_trajectory *t = &j->request.trajectory;
    answer_integrals_clear(j);
    if (!(j->request.want & REQUEST_TRAJECTORY) || s->verdict == SGA_ISOLATED)
        return;
    size_t most = (size_t)t->integrals + 1;
    j->integrals.expr = sga_calloc(most, sizeof *j->integrals.expr);
    j->integrals.given = sga_calloc(most, sizeof *j->integrals.given);
    j->integrals.truth = sga_calloc(most, sizeof *j->integrals.truth);
    expr_id own = energy(j);
    if (own != EXPR_UNDEF && conserved(j, s, shadow, own) == POINTS_ZERO) {
        j->integrals.truth[0] = POINTS_ZERO;
        j->integrals.given[0] = -1;
        j->integrals.expr[j->integrals.count++] = own;
    }
    for (int k = 0; k < t->integrals; k++) {
        int at = j->integrals.count++;
        j->integrals.expr[at] = t->integral[k];
        j->integrals.given[at] = k;
        j->integrals.truth[at] = conserved(j, s, shadow, t->integral[k]);
    }
    r->integral = j->integrals.expr;
    r->integrals = j->integrals.count;
}

void answer_integrals_clear(struct job *j)
{
    free(j->integrals.expr);
    free(j->integrals.given);
    free(j->integrals.truth);
    memset(&j->integrals, 0, sizeof j->integrals);
}

void answer_write_drift(const struct job *j, struct sga_json *w)
{
    const struct traj_result *r = &j->trajectory.result;
    if (!r->drift)
        return;
    sga_json_key(w, "drift");
    sga_json_object(w);
    sga_json_member_double(w, "constraints", r->residual);
    sga_json_key(w, "integrals");
    sga_json_array(w);
    for (int i = 0; i < j->integrals.count; i++) {
        const struct traj_drift *d = r->drift + i;
        enum points_truth truth = j->integrals.truth[i];
        double size = d->start < 0 ? -d->start : d->start;
        sga_json_object(w);
        sga_json_member_string(w, "function", j->integrals.given[i] < 0 ? "energy" : j->request.trajectory.integral_text[j->integrals.given[i]]);
        sga_json_key(w, "conserved");
        if (truth == POINTS_UNKNOWN)
            sga_json_null(w);
        else
            sga_json_bool(w, truth == POINTS_ZERO);
        sga_json_member_double(w, "start", d->start);
        sga_json_member_double(w, "end", d->end);
        sga_json_member_double(w, "largest", d->largest);
        sga_json_key(w, "relative");
        if (size > 0)
            sga_json_double(w, d->largest / size);
        else
            sga_json_null(w);
        sga_json_member_double(w, "t", d->t);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
    sga_json_end_object(w);
}
