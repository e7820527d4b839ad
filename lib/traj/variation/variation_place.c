/* The start of the derivatives of a motion, where linear equations have it: the tangents of the constraints, and what stays where it was given. */
#include "variation.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "defined.h"
#include "error.h"
#include "field.h"
#include "jacobian.h"
#include "kinds.h"
#include "leastnorm.h"
#include "print.h"
#include "sizes.h"
#include "tape.h"

/* A given value stayed if it is the start's up to this, relative to 1 + its size; equations hold if they are missed by no more than this beside
 * the sizes of their terms. */
static const double STAYED = 1e-13, MISSED = 1e-11;

bool variation_constants(const struct expr_store *st, const expr_id *e, int count, double *value)
{
    struct sga_error ignored = { 0 };
    struct num_tape *tape = num_tape_new(st, e, count, NULL, 0, &ignored);
    bool ok = tape && num_tape_eval(tape, NULL, value);
    num_tape_free(tape);
    return ok;
}

/* The tangent equations J s = -b of the constraints at the start. */
struct tangents {
    int n, rows, directions;
    double *J, *b;             /* rows x n; rows x directions */
};

static bool tangents_at(struct tangents *q, const struct sys_system *sys, const struct sga_solution *sol, double t, const double *in, struct sga_arena *mem)
{
    int all = sys->variables, n = q->n, c = sol->constraints;
    assert(c % (1 + q->directions) == 0);       /* each is followed by its derivatives */
    q->rows = c / (1 + q->directions);
    q->J = sga_zeros(mem, (size_t)q->rows * (size_t)n + 1, sizeof *q->J);
    q->b = sga_zeros(mem, (size_t)c + 1, sizeof *q->b);
    expr_id *root = sga_take(mem, ((size_t)c + 1) * sizeof *root);
    double *at = sga_zeros(mem, (size_t)all + 1, sizeof *at), *out = sga_zeros(mem, (size_t)c + 1, sizeof *out);
    for (int i = 0; i < c; i++)
        root[i] = sol->constraint[i].expr;
    memcpy(at, in, (size_t)n * sizeof *at);
    at[all] = t;
    SGA_FREED int *inputs = field_inputs(sys);
    struct sga_error ignored = { 0 };
    struct num_tape *tape = num_tape_new(sys->store, root, c, inputs, all + 1, &ignored);
    struct num_jacobian *jac = tape ? num_jacobian_new(tape, NULL, 0) : NULL;
    double *value = sga_zeros(mem, (size_t)(jac ? jac->nnz : 0) + 1, sizeof *value);
    bool ok = jac && num_jacobian_eval(jac, at, out, value);
    for (int i = 0; i < q->rows && ok; i++) {
        int row = i * (1 + q->directions);
        for (int k = jac->start[row]; k < jac->start[row + 1]; k++)
            if (jac->col[k] < n)
                q->J[(size_t)i * (size_t)n + (size_t)jac->col[k]] = value[k];
        for (int d = 0; d < q->directions; d++)
            q->b[i * q->directions + d] = out[row + 1 + d];
    }
    num_jacobian_free(jac);
    num_tape_free(tape);
    return ok;
}

/* Whether s, of one direction, has J s = -b. */
static bool meets(const struct tangents *q, const double *size, int d, const double *s)
{
    double largest = 0;
    for (int j = 0; j < q->n; j++)
        largest = fmax(largest, fabs(s[j]));
    for (int i = 0; i < q->rows; i++) {
        double sum = q->b[i * q->directions + d], terms = fabs(sum) + size[i] * largest;
        for (int j = 0; j < q->n; j++)
            sum += q->J[(size_t)i * (size_t)q->n + (size_t)j] * s[j];
        if (!(fabs(sum) <= MISSED * terms))
            return false;
    }
    return true;
}

/* s (directions x n) with J s = -b and s = g where it stays; whether there is exactly one. Cost: rows^2 times what does not stay. */
static bool determined(const struct tangents *q, const unsigned char *stays, const double *g, double *s, struct sga_arena *mem)
{
    size_t n = (size_t)q->n, m = (size_t)q->rows, frees = 0;
    int *free_at = sga_zeros(mem, n + 1, sizeof *free_at), *perm = sga_zeros(mem, m + 1, sizeof *perm);
    for (size_t j = 0; j < n; j++)
        if (!stays[j])
            free_at[frees++] = (int)j;
    if (frees > m)
        return false;
    double *M = sga_zeros(mem, m * frees + 1, sizeof *M), *size = sga_zeros(mem, m + 1, sizeof *size), *rhs = sga_zeros(mem, m + 1, sizeof *rhs);
    double *qr = sga_zeros(mem, frees ? (m + 1) * (m + 1) : 1, sizeof *qr), *found = sga_zeros(mem, frees + 1, sizeof *found), *unit = sga_zeros(mem, frees + 1, sizeof *unit);
    for (size_t i = 0; i < m; i++) {
        for (size_t j = 0; j < n; j++)
            size[i] = fmax(size[i], fabs(q->J[i * n + j]));
        for (size_t k = 0; k < frees && size[i] > 0; k++)
            M[i * frees + k] = q->J[i * n + (size_t)free_at[k]] / size[i];
    }
    for (size_t k = 0; k < frees; k++) {       /* derivatives in units of their own: those of variables may be far apart */
        for (size_t i = 0; i < m; i++)
            unit[k] = fmax(unit[k], fabs(M[i * frees + k]));
        for (size_t i = 0; i < m && unit[k] > 0; i++)
            M[i * frees + k] /= unit[k];
    }
    if (frees && points_least_norm_factor((int)m, (int)frees, M, perm, qr) < (int)frees)
        return false;
    bool ok = true;
    for (int d = 0; d < q->directions && ok; d++) {
        double *to = s + (size_t)d * n;
        for (size_t j = 0; j < n; j++)
            to[j] = stays[j] ? g[(size_t)d * n + j] : 0;
        for (size_t i = 0; i < m && frees; i++) {
            rhs[i] = q->b[i * (size_t)q->directions + (size_t)d];
            for (size_t j = 0; j < n; j++)
                rhs[i] += q->J[i * n + j] * to[j];
            rhs[i] = size[i] > 0 ? rhs[i] / size[i] : 0;
        }
        if (frees)
            points_least_norm_solve((int)m, (int)frees, M, (int)frees, perm, qr, rhs, found);
        for (size_t k = 0; k < frees; k++)
            to[free_at[k]] = unit[k] > 0 ? found[k] / unit[k] : 0;
        for (size_t j = 0; j < n && ok; j++)
            ok = isfinite(to[j]);
        ok = ok && meets(q, size, d, to);
    }
    return ok;
}

/* No given value moved: else all of its tier may (tiers.h), also what is by chance where it was. */
static bool given_stay(const struct variation *v, const double *x)
{
    bool all = true;
    for (int j = 0; j < v->n; j++)
        all &= !v->guessed[j] || v->kept[j] || fabs(x[j] - v->guess[j]) <= STAYED * (1 + fabs(x[j]));
    return all;
}

/* What stays: given values; and, where they do not say everything, coordinates and velocities that were not given, where all of them are 0. */
static bool find_stays(const struct tangents *q, const struct variation *v, const struct sys_system *sys, const double *x, const double *g, unsigned char *stays, double *s,
                       struct sga_arena *mem)
{
    unsigned char *kind = sga_zeros(mem, (size_t)sys->variables + 1, 1);
    bool moved[] = { [SYS_COORDINATE] = false, [SYS_VELOCITY] = false };
    sys_kinds(sys, kind);
    if (!given_stay(v, x))
        return false;
    for (int j = 0; j < q->n; j++)
        stays[j] = v->guessed[j] || v->kept[j];
    if (determined(q, stays, g, s, mem))
        return true;
    for (int j = 0; j < q->n; j++)
        if (!v->guessed[j] && !v->kept[j] && kind[j] < SYS_ALGEBRAIC)
            moved[kind[j]] |= fabs(x[j]) > STAYED;
    for (int j = 0; j < q->n; j++)
        stays[j] |= !v->guessed[j] && !v->kept[j] && kind[j] < SYS_ALGEBRAIC && !moved[kind[j]];
    return determined(q, stays, g, s, mem);
}

bool variation_place(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, struct traj_request *rq, const double *whole)
{
    size_t n = (size_t)v->n, q = (size_t)v->directions;
    SGA_ARENA(mem);
    double *x = sga_zeros(&mem, n + 1, sizeof *x), *g = sga_zeros(&mem, n * q + 1, sizeof *g), *s = sga_zeros(&mem, n * q + 1, sizeof *s);
    unsigned char *stays = sga_zeros(&mem, n + 1, 1);
    for (int i = 0; v->of_defined && i < v->defined->sol->definitions; i++)
        if (v->defined->rq->given[v->defined->sol->definition[i].variable])
            return false;
    for (size_t j = 0; j < n; j++)
        x[j] = whole[v->of_defined ? v->defined->variable[j] : (int)j];
    struct tangents at = { .n = v->n, .directions = v->directions };
    if (!variation_constants(sys->store, rq->exact_initial + n, (int)(n * q), g) || !tangents_at(&at, sys, sol, rq->start, x, &mem) || !find_stays(&at, v, sys, x, g, stays, s, &mem))
        return false;
    for (size_t i = 0; i < n * (1 + q); i++)
        v->initial[i] = i >= n ? s[i - n] : stays[i] && v->guessed[i] ? v->guess[i] : x[i];
    /* in double the rest is what it is already; longer numbers solve for it */
    bool longer = rq->arithmetic == TRAJ_DOUBLE_DOUBLE || rq->arithmetic == TRAJ_BALL;
    for (size_t i = 0; i < n * (1 + q); i++) {
        v->held[i] = longer && stays[i % n];
        v->given[i] = !longer || stays[i % n];
    }
    v->asked = (struct traj_asked){ .nearest = false, .base = v->n, .directions = v->directions };
    rq->asked = rq->arithmetic == TRAJ_BALL ? &v->asked : NULL;
    return true;
}

void variation_place_at(struct variation *v, struct traj_request *rq, const double *whole, const double *slope)
{
    size_t n = (size_t)v->n, all = n * (size_t)(1 + v->directions), variables = v->of_defined ? (size_t)v->defined->sys->variables : n;
    for (size_t i = 0; i < all; i++) {
        size_t j = v->of_defined ? (size_t)v->defined->variable[i % n] : i % n;
        v->initial[i] = i < n ? whole[j] : slope[(i / n - 1) * variables + j];
        v->given[i] = 1;
        v->held[i] = 0;
    }
    rq->exact_initial = NULL;
}

bool variation_place_nearest(struct variation *v, struct traj_request *rq, const double *whole, const double *slope, const double *unit)
{
    const expr_id *exact = rq->exact_initial;
    if (v->of_defined)
        return false;
    variation_place_at(v, rq, whole, slope);
    v->asked = (struct traj_asked){ true, false, v->n, v->directions, v->guess, unit, v->guessed, v->kept };
    rq->asked = &v->asked;
    rq->exact_initial = exact;
    return true;
}

bool variation_units(const struct sys_system *sys, const struct traj_request *rq, const double *x, double *unit)
{
    struct sizes sizes;
    bool fixed = true;
    sizes_init(&sizes, sys, rq);
    sizes_met(&sizes, x);
    for (int j = 0; j < sys->variables; j++) {
        unit[j] = sizes_move(&sizes, j, rq->initial[j]);
        fixed &= !rq->given[j] || unit[j] == sizes_move(&sizes, j, 0);
    }
    sizes_clear(&sizes);
    return fixed;
}

/* Beside 1 + the sizes of variables: on a surface; along a direction it does not move; at rest. */
static const double ON = 1e-12;

bool variation_starts_clear(const struct variation *v, const struct sys_system *sys, const struct traj_request *rq, struct sga_error *err)
{
    const struct traj_turns *q = rq->turns;
    int n = sys->variables;
    if (!q)
        return true;
    SGA_ARENA(mem);
    size_t surfaces = (size_t)q->surfaces, directions = (size_t)q->directions, roots = surfaces * (2 + directions);
    expr_id *root = sga_take(&mem, (roots + 1) * sizeof *root);
    double *out = sga_zeros(&mem, roots + 1, sizeof *out), *in = sga_zeros(&mem, (size_t)n + 1, sizeof *in), size = 1;
    memcpy(root, q->surface, surfaces * sizeof *root);
    memcpy(root + surfaces, q->rate, surfaces * sizeof *root);
    memcpy(root + 2 * surfaces, q->slope, surfaces * directions * sizeof *root);
    memcpy(in, rq->initial, (size_t)n * sizeof *in);
    in[n] = rq->start;
    for (int j = 0; j < q->base; j++)
        size = fmax(size, fabs(in[j]));
    SGA_FREED int *inputs = field_inputs(sys);
    struct num_tape *tape = num_tape_new(sys->store, root, (int)roots, inputs, n + 1, err);
    if (tape)
        num_tape_eval(tape, in, out);
    num_tape_free(tape);
    for (size_t i = 0; i < surfaces && tape; i++) {
        bool on = fabs(out[i]) <= ON * size, leaves = fabs(out[surfaces + i]) > ON * size, moves = false;
        for (size_t d = 0; d < directions; d++)
            moves |= fabs(out[2 * surfaces + i * directions + d]) > ON;
        if (on && moves && (v->may_jump || !leaves)) {
            char *text = expr_text(sys->store, q->surface[i], 200);
            sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial", "the motion starts where the equations change, at %s = 0: a change of what is differentiated by moves it to one side or the "
                        "other, and its derivatives there are not the same; start beside it", text);
            free(text);
            return false;
        }
    }
    return tape != NULL;
}
