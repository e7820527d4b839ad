/* W and independent conditions on its fibre: candidates are the constraints as they are given; where they
 * do not reach the rank, the functions that the reduction found. Rows are chosen by elimination in balls at a
 * certified point: what is kept is proved independent there, and the number of rows
 * must be the rank that the reduction decided. */
#include "mech.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "derive.h"
#include "error.h"
#include "form.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "reduction.h"
#include "signal.h"

/* H row by row as expressions. */
static expr_id *differentials(struct expr_store *st, const struct form_mechanical *in, const expr_id *function, int count)
{
    int n = in->coordinates;
    expr_id *H = sga_malloc(((size_t)count * (size_t)n + 1) * sizeof *H);
    SGA_ARENA(mem);
    unsigned char *active = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    int *place = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *place);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    for (int i = 0; i < n; i++) {
        active[in->velocity[i]] = 1;
        place[in->velocity[i]] = i;
    }
    expr_cone_init(&cone);
    for (int i = 0; i < count; i++) {
        expr_id *row = H + (size_t)i * (size_t)n;
        for (int j = 0; j < n; j++)
            row[j] = expr_int(st, 0);
        int terms = expr_gradient(st, &cone, function[i], active, &term, &cap);
        for (int k = 0; k < terms; k++)
            row[place[term[k].symbol]] = term[k].value;
    }
    return H;
}

/* Derivatives along the motion without the part of the accelerations, of all conditions. */
static expr_id *drifts(const struct sys_system *s, const struct form_mechanical *in, const expr_id *function, int count)
{
    struct expr_store *st = s->store;
    expr_id *rate = sga_malloc((size_t)(count + 1) * sizeof *rate);
    SGA_ARENA(mem);
    unsigned char *active = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    int *velocity = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *velocity);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    for (int i = 0; i < in->coordinates; i++) {
        active[in->coordinate[i]] = 1;
        velocity[in->coordinate[i]] = in->velocity[i];
    }
    expr_cone_init(&cone);
    for (int i = 0; i < count; i++) {
        int terms = expr_gradient(st, &cone, function[i], active, &term, &cap);
        rate[i] = expr_time_partial(st, function[i], s->time);
        for (int k = 0; k < terms; k++)
            rate[i] = expr_add(st, rate[i], expr_mul(st, term[k].value, st->symbol[velocity[term[k].symbol]].node));
    }
    return rate;
}

/* Elimination of a ball matrix with rows added one by one. */
struct rows {
    arb_ptr a;            /* kept rows, reduced */
    int *pivot, kept, n;
    slong prec;
};

/* row (n balls) -= what the kept rows explain; kept too if an entry surely differs from 0. */
static bool keep_row(struct rows *r, arb_ptr row)
{
    SGA_ENDS(arb_end) arb_t f = { 0 };
    for (int k = 0; k < r->kept; k++) {
        arb_srcptr old = r->a + (size_t)k * (size_t)r->n;
        if (arb_is_zero(row + r->pivot[k]))
            continue;
        arb_div(f, row + r->pivot[k], old + r->pivot[k], r->prec);
        arb_neg(f, f);
        for (int j = 0; j < r->n; j++)
            if (!arb_is_zero(old + j))
                arb_addmul(row + j, f, old + j, r->prec);
        arb_zero(row + r->pivot[k]);
    }
    int best = -1;
    for (int j = 0; j < r->n; j++)
        if (arb_is_finite(row + j) && !arb_contains_zero(row + j)
            && (best < 0 || arf_cmpabs(arb_midref(row + j), arb_midref(row + best)) > 0))
            best = j;
    if (best < 0)
        return false;
    r->pivot[r->kept] = best;
    _arb_vec_set(r->a + (size_t)r->kept++ * (size_t)r->n, row, r->n);
    return true;
}

/* Which rows of H are independent at a point: chosen[i] = 1. Returns how many. */
static int choose_at(struct points_point *p, const expr_id *H, int count, int n, unsigned char *chosen)
{
    int room = count < n ? count : n;
    struct rows r = { .a = _arb_vec_init((slong)(room + 1) * n), .pivot = sga_calloc((size_t)room + 1, sizeof(int)), .n = n,
                      .prec = POINTS_BITS };
    SGA_ARENA(mem);
    arb_ptr row = arbs_take(&mem, n);
    num_ball_extend(&p->ball);
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < n; j++)
            arb_set(row + j, num_ball_value(&p->ball, H[(size_t)i * (size_t)n + (size_t)j]));
        chosen[i] = r.kept < n && keep_row(&r, row);
    }
    _arb_vec_clear(r.a, (slong)(room + 1) * n);
    free(r.pivot);
    return r.kept;
}

/* The best choice over the points of W. */
static int choose(struct mech_fibre *f, const expr_id *H, int count, int n, unsigned char *chosen)
{
    SGA_FREED unsigned char *now = sga_calloc((size_t)count + 1, 1);
    int best = 0;
    for (int k = 0; k < f->oracle->reals; k++) {
        int kept = choose_at(f->oracle->real + k, H, count, n, now);
        if (kept > best) {
            best = kept;
            memcpy(chosen, now, (size_t)count);
        }
    }
    return best;
}

/* Takes the chosen functions as conditions. */
static void take(struct mech_fibre *f, const struct form_mechanical *in, const expr_id *function, const unsigned char *chosen,
                 int count)
{
    for (int i = 0; i < count; i++) {
        if (!chosen[i])
            continue;
        f->constraint[f->conditions] = f->own ? i : f->conditions;
        f->condition[f->conditions++] = function[i];
    }
    f->H = differentials(f->kinematics.store, in, f->condition, f->conditions);
    f->rate = drifts(&f->kinematics, in, f->condition, f->conditions);
}

/* On a subset of W (restrict) the fibre is still that of W: its tangent space is taken from the set, so from functions of
 * the first generation, which vanish on the subset without regard to motion. As many as W has conditions in general, or fewer: then
 * they describe the fibre; more of them mean that the fibre has a corner or a crossing there. */
static bool restricted_conditions(struct mech_fibre *f, const struct form_mechanical *in, int general, struct sga_error *err)
{
    int c = 0;
    while (c < f->W->constraints && f->W->constraint[c].generation == 1)
        c++;
    SGA_ARENA(mem);
    expr_id *function = sga_zeros(&mem, (size_t)c + 1, sizeof *function);
    unsigned char *chosen = sga_zeros(&mem, (size_t)c + 1, 1);
    for (int i = 0; i < c; i++)
        function[i] = f->W->constraint[i].expr;
    SGA_FREED expr_id *H = differentials(f->kinematics.store, in, function, c);
    f->condition = sga_calloc((size_t)c + 1, sizeof *f->condition);
    f->constraint = sga_calloc((size_t)c + 1, sizeof *f->constraint);
    bool ok = choose(f, H, c, in->coordinates, chosen) <= general;
    if (ok)
        take(f, in, function, chosen, c);
    else
        sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/system/restrict", "on this set the velocities that the constraints leave have no "
                    "tangent space, as branches meet there: which reactions act is not defined");
    return ok;
}

/* The rank of H along W, as the reduction decided it, is rank. */
static bool find_conditions(struct mech_fibre *f, const struct form_mechanical *in, int rank, struct sga_error *err)
{
    int m = in->constraints, c = f->W->constraints, most = m > c ? m : c;
    SGA_ARENA(mem);
    expr_id *function = sga_zeros(&mem, (size_t)most + 1, sizeof *function), *H;
    unsigned char *chosen = sga_zeros(&mem, (size_t)most + 1, 1);
    f->condition = sga_calloc((size_t)most + 1, sizeof *f->condition);
    f->constraint = sga_calloc((size_t)most + 1, sizeof *f->constraint);
    f->redundant = sga_calloc((size_t)m + 1, sizeof *f->redundant);
    for (int i = 0; i < m; i++)
        function[i] = form_fibre_condition(&f->kinematics, in, in->constraint[i]);
    H = differentials(f->kinematics.store, in, function, m);
    int count = m, kept = choose(f, H, m, in->coordinates, chosen);
    f->own = kept == rank;
    free(H);
    if (f->own) {
        for (int i = 0; i < m; i++)
            if (!chosen[i])
                f->redundant[f->redundants++] = i;
    } else {
        for (int i = 0; i < c; i++)
            function[i] = f->W->constraint[i].expr;
        H = differentials(f->kinematics.store, in, function, c);
        count = c;
        memset(chosen, 0, (size_t)most);
        kept = choose(f, H, c, in->coordinates, chosen);
        free(H);
    }
    bool ok = kept == rank;
    if (ok)
        take(f, in, function, chosen, count);
    else
        sga_fail_at(err, SGA_E_UNDECIDED, "/system/constraints", "the constraints leave %d conditions on the acceleration, but %d "
                    "independent ones were found at points of the configuration space", rank, kept);
    return ok;
}

static bool reduce(struct mech_fibre *f, const struct sys_system *system, const struct form_mechanical *in, bool restricted,
                   const struct reduction_options *options, struct sga_error *err)
{
    *f = (struct mech_fibre){ .W = sga_calloc(1, sizeof *f->W), .oracle = sga_calloc(1, sizeof *f->oracle) };
    sys_init(&f->kinematics, system->store);
    f->kinematics.time = system->time;
    for (int i = 0; i < system->parameters; i++)
        sys_add_parameter(&f->kinematics, system->parameter[i]);
    for (int i = 0; i < system->restrictions && restricted; i++)
        sys_add_restriction(&f->kinematics, system->restriction[i]);
    form_kinematics(&f->kinematics, in);
    points_oracle_init(f->oracle, 20250103);
    struct reduction_options own = *options;
    own.gauge_fields = own.combinations = false;
    return sga_reduce(&f->kinematics, &own, f->oracle, f->W, err);
}

bool mech_fibre_find(struct mech_fibre *f, const struct sys_system *system, const struct form_mechanical *in,
                     const struct reduction_options *options, struct sga_error *err)
{
    int general = in->coordinates;
    if (system->restrictions) {
        struct reduction_options anywhere = *options;
        anywhere.near = NULL;
        bool ok = reduce(f, system, in, false, &anywhere, err);
        general -= f->W->free_columns;
        mech_fibre_clear(f);
        if (!ok)
            return false;
    }
    if (!reduce(f, system, in, true, options, err))
        return false;
    if (f->W->verdict == SGA_INCONSISTENT)
        return true;
    return system->restrictions ? restricted_conditions(f, in, general, err)
                                : find_conditions(f, in, in->coordinates - f->W->free_columns, err);
}

void mech_fibre_clear(struct mech_fibre *f)
{
    if (!f->W)
        return;
    points_oracle_clear(f->oracle);
    sga_solution_clear(f->W);
    free(f->oracle);
    free(f->W);
    sys_clear(&f->kinematics);
    free(f->condition);
    free(f->constraint);
    free(f->redundant);
    free(f->H);
    free(f->rate);
    *f = (struct mech_fibre){ 0 };
}
