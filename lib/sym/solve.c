/* Linear equations for rational unknowns, sampled at random points of Pf modulo primes.
 *
 * Points are added until the ranks stay; at enough random points the solutions modulo p are
 * no fewer than the rational ones, so a basis whose every member is confirmed afterwards is
 * complete. Coefficients come from their residues modulo one or more 60-bit primes (Chinese
 * remainders, rational reconstruction); a wrong guess does not pass the check that follows. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "ball.h"
#include "budget.h"
#include "derive.h"
#include "mem.h"
#include "modp.h"
#include "modpoint.h"
#include "oracle.h"
#include "points.h"
#include "points_random.h"
#include "reduction.h"
#include "seeds.h"
#include "sym_work.h"

enum { PRIMES = 4, PRIMES_TRIED = 8, STEADY = 3, FAILURES = 40, MARGIN_BITS = 12 };

static void spaces_init(struct sym_spaces *s, int cols, nmod_t mod)
{
    sym_space_init(&s->equation, cols, mod);
    sym_space_init(&s->trivial, cols, mod);
    sym_space_init(&s->gauge, cols, mod);
    s->points = 0;
}

static void spaces_clear(struct sym_spaces *s)
{
    sym_space_clear(&s->equation);
    sym_space_clear(&s->trivial);
    sym_space_clear(&s->gauge);
}

/* Other variables for the constraints to be solved for, at random among those whose Jacobian
 * is regular at the real point: some choices fall into steps of one unknown, others do not. */
static void choose_solved(struct sym_work *w, uint64_t *random)
{
    int c = w->sol->constraints, n = w->n;
    SGA_FREED double *a = sga_calloc((size_t)c * (size_t)n + 1, sizeof *a);
    num_ball_extend(&w->oracle->real[0].ball);
    for (int i = 0; i < c; i++)
        for (int j = 0; j < n; j++)
            a[i * n + j] = arf_get_d(arb_midref(num_ball_value(&w->oracle->real[0].ball, w->differential[i * n + j])), ARF_RND_NEAR);
    for (int i = 0; i < c; i++) {
        int best = -1;
        double most = 0, weight = 0;
        for (int j = 0; j < n; j++)
            most = fmax(most, fabs(a[i * n + j]));
        for (int j = 0; j < n; j++) {
            double here = fabs(a[i * n + j]) > 1e-6 * most ? points_uniform(random) : 0;
            if (here > weight) {
                weight = here;
                best = j;
            }
        }
        if (best < 0)
            break;             /* keeps the old choice */
        w->solved[i] = best;
        for (int k = i + 1; k < c; k++) {
            double f = a[k * n + best] / a[i * n + best];
            for (int j = 0; j < n; j++)
                a[k * n + j] = j == best ? 0 : a[k * n + j] - f * a[i * n + j];
        }
    }
    for (int i = 0; i < c; i++)
        for (int k = 0; k < i; k++)
            if (w->solved[i] == w->solved[k])
                memcpy(w->solved, w->oracle->real[0].solved, (size_t)c * sizeof *w->solved);
}

bool sym_modpoint(struct sym_work *w, int prime, uint64_t *random, struct points_modpoint *at)
{
    assert(w->oracle->reals > 0);
    enum { MOST_VARIABLES = 400 };
    int c = w->sol->constraints;
    if (!w->solved) {
        w->solved = sga_take(&w->mem, ((size_t)c + 1) * sizeof *w->solved);
        memcpy(w->solved, w->oracle->real[0].solved, (size_t)c * sizeof *w->solved);
    }
    if (points_modpoint_find_modulo(at, &w->oracle->space, w->solved, prime, random))
        return true;
    if (c && w->n <= MOST_VARIABLES) {
        if (!w->differential) {
            w->differential = sga_take(&w->mem, (size_t)(c * w->n) * sizeof *w->differential);
            for (int i = 0; i < c * w->n; i++)
                w->differential[i] = expr_diff(w->st, w->constraint[i / w->n], w->variable[i % w->n]);
        }
        choose_solved(w, random);
    }
    return false;
}

/* One more point; false where none is found, or a value is missing there. */
static bool add_point(struct sym_work *w, const struct sym_problem *p, int prime, uint64_t *random, struct sym_spaces *s,
                      struct sym_evidence *evidence)
{
    struct points_modpoint at;
    if (!sym_modpoint(w, prime, random, &at))
        return false;
    num_modp_extend(at.value);
    bool ok = true;
    for (int k = 0; k < p->nodes && ok; k++) {
        ok = !num_modp_bad(at.value, p->node[k]);
        evidence->kernels |= num_modp_kernel(at.value, p->node[k]);
    }
    if (ok) {
        if (!s->equation.row)
            spaces_init(s, p->cols, at.value->mod);
        p->rows(p->ctx, at.value, s);
        s->points++;
    }
    points_modpoint_clear(&at);
    return ok;
}

/* Points until the ranks stay; *enough: they did. False where the budget ends. */
static bool sample(struct sym_work *w, const struct sym_problem *p, int prime, uint64_t *random, struct sym_spaces *s,
                   struct sym_evidence *evidence, bool *enough, struct sga_error *err)
{
    int steady = 0, failures = 0;
    *s = (struct sym_spaces){ 0 };
    while (steady < STEADY && failures < FAILURES) {
        int before = s->equation.rank + s->trivial.rank + s->gauge.rank;
        if (!sga_budget_ok(w->budget, err))
            return false;
        if (!add_point(w, p, prime, random, s, evidence)) {
            failures++;
            continue;
        }
        steady = s->equation.rank + s->trivial.rank + s->gauge.rank == before ? steady + 1 : 0;
    }
    *enough = steady >= STEADY;
    return true;
}

/* Moves the rows of `from`, reduced by `base` and `other`, into `to`. */
static void complement(const struct sym_space *from, const struct sym_space *base, const struct sym_space *other,
                       struct sym_space *to)
{
    SGA_FREED mp_limb_t *v = sga_malloc(((size_t)from->cols + 1) * sizeof *v);
    sym_space_init(to, from->cols, from->mod);
    for (int j = 0; j < from->cols; j++) {
        if (!from->row[j])
            continue;
        memcpy(v, from->row[j], (size_t)from->cols * sizeof *v);
        sym_space_reduce(base, v);
        if (other)
            sym_space_reduce(other, v);
        sym_space_insert(to, v);
    }
    sym_space_finish(to);
}

/* The solutions modulo p: the distinguished ones modulo the trivial ones, then the others. */
static void bases(const struct sym_problem *p, struct sym_spaces *s, struct sym_space *special, struct sym_space *rest)
{
    SGA_ENDS(sym_space_clear) struct sym_space trivial, all;
    sym_space_finish(&s->equation);
    sym_space_finish(&s->trivial);
    sym_space_kernel(&s->equation, &all);
    sym_space_kernel(&s->trivial, &trivial);
    if (p->split) {
        SGA_FREED mp_limb_t *v = sga_malloc(((size_t)p->cols + 1) * sizeof *v);
        for (int j = 0; j < p->cols; j++)
            if (s->equation.row[j]) {
                memcpy(v, s->equation.row[j], (size_t)p->cols * sizeof *v);
                sym_space_insert(&s->gauge, v);
            }
        sym_space_finish(&s->gauge);
        SGA_ENDS(sym_space_clear) struct sym_space both;
        sym_space_kernel(&s->gauge, &both);
        complement(&both, &trivial, NULL, special);
    } else {
        sym_space_init(special, p->cols, all.mod);
    }
    complement(&all, &trivial, special, rest);
}

/* Residues of the present guess: rows of integers modulo `product`. */
struct lift {
    fmpz *value;
    int *pivot;               /* by row */
    int rows, special, cols;
    fmpz_t product;
    bool started;
};

static bool same_shape(const struct lift *l, const struct sym_space *special, const struct sym_space *rest)
{
    int r = 0;
    if (l->special != special->rank || l->rows != special->rank + rest->rank)
        return false;
    for (int part = 0; part < 2; part++) {
        const struct sym_space *s = part ? rest : special;
        for (int j = 0; j < s->cols; j++)
            if (s->row[j] && l->pivot[r++] != j)
                return false;
    }
    return true;
}

static void lift_clear(struct lift *l)
{
    if (l->started) {
        _fmpz_vec_clear(l->value, (slong)l->rows * l->cols);
        free(l->pivot);
        fmpz_clear(l->product);
    }
    l->started = false;
}

static void lift_start(struct lift *l, const struct sym_space *special, const struct sym_space *rest)
{
    int r = 0;
    *l = (struct lift){ .rows = special->rank + rest->rank, .special = special->rank, .cols = special->cols, .started = true };
    l->value = _fmpz_vec_init((slong)l->rows * l->cols);
    l->pivot = sga_malloc(((size_t)l->rows + 1) * sizeof *l->pivot);
    fmpz_init_set_ui(l->product, 1);
    for (int part = 0; part < 2; part++) {
        const struct sym_space *s = part ? rest : special;
        for (int j = 0; j < s->cols; j++)
            if (s->row[j])
                l->pivot[r++] = j;
    }
}

static void lift_add(struct lift *l, const struct sym_space *special, const struct sym_space *rest)
{
    for (int r = 0; r < l->rows; r++) {
        const mp_limb_t *row = (r < l->special ? special : rest)->row[l->pivot[r]];
        for (int j = 0; j < l->cols; j++) {
            fmpz *v = l->value + (slong)r * l->cols + j;
            fmpz_CRT_ui(v, v, l->product, row[j], special->mod.n, 0);
        }
    }
    fmpz_mul_ui(l->product, l->product, special->mod.n);
}

/* One row as fractions much smaller than the modulus allows. */
static bool reconstruct_row(const struct lift *l, int r, fmpq *out)
{
    slong bits = (slong)fmpz_bits(l->product) - MARGIN_BITS;
    bool ok = true;
    for (int j = 0; j < l->cols && ok; j++) {
        const fmpz *v = l->value + (slong)r * l->cols + j;
        fmpq_zero(out + j);
        ok = fmpz_is_zero(v) || (fmpq_reconstruct_fmpz(out + j, v, l->product)
                                 && (slong)(fmpz_bits(fmpq_numref(out + j)) + fmpz_bits(fmpq_denref(out + j))) < bits);
    }
    return ok;
}

/* The rows that are rational; true where all are. */
static bool reconstruct(const struct lift *l, struct sym_solutions *out)
{
    slong size = (slong)l->rows * l->cols;
    sym_solutions_clear(out);
    *out = (struct sym_solutions){ .cols = l->cols, .room = l->rows, .value = sga_malloc(((size_t)size + 1) * sizeof *out->value) };
    for (slong k = 0; k < size; k++)
        fmpq_init(out->value + k);
    for (int r = 0; r < l->rows; r++)
        if (reconstruct_row(l, r, out->value + (slong)out->count * l->cols)) {
            out->distinguished += r < l->special;
            out->count++;
        }
    return out->count == l->rows;
}

void sym_solutions_clear(struct sym_solutions *s)
{
    for (slong k = 0; k < (slong)s->room * s->cols && s->value; k++)
        fmpq_clear(s->value + k);
    free(s->value);
    *s = (struct sym_solutions){ 0 };
}

/* One prime's spaces to the guess; true where all of it is rational. */
static bool add_prime(const struct sym_problem *p, struct sym_spaces *s, struct lift *lift, struct sym_solutions *out)
{
    SGA_ENDS(sym_space_clear) struct sym_space special, rest;
    bases(p, s, &special, &rest);
    if (lift->started && !same_shape(lift, &special, &rest))
        lift_clear(lift);           /* one of the primes was unlucky */
    if (!lift->started)
        lift_start(lift, &special, &rest);
    lift_add(lift, &special, &rest);
    return reconstruct(lift, out);
}

/* At real points, where no prime has any. */
static bool solve_real(struct sym_work *w, const struct sym_problem *p, struct sym_solutions *out, struct sym_evidence *evidence,
                       bool *done, struct sga_error *err)
{
    SGA_ENDS(spaces_clear) struct sym_spaces s;
    SGA_ENDS(lift_clear) struct lift lift = { 0 };
    bool enough, ok = sym_real_spaces(w, p, &s, evidence, &enough, err);
    *done = ok && enough && add_prime(p, &s, &lift, out);
    return ok;
}

bool sym_solve(struct sym_work *w, const struct sym_problem *p, struct sym_solutions *out, struct sym_evidence *evidence,
               struct sga_error *err)
{
    assert(p->cols > 0);
    uint64_t random = SGA_SEED_SYM_SOLVE;
    SGA_ENDS(lift_clear) struct lift lift = { 0 };
    bool ok = true, done = false;
    *out = (struct sym_solutions){ 0 };
    evidence->unknowns = p->cols;
    for (int prime = 0; prime < PRIMES_TRIED && evidence->primes < PRIMES && ok && !done; prime++) {
        SGA_ENDS(spaces_clear) struct sym_spaces s;
        bool enough;
        ok = sample(w, p, prime, &random, &s, evidence, &enough, err);
        if (ok && enough) {
            done = add_prime(p, &s, &lift, out);
            evidence->primes++;
            evidence->points += s.points;
        }
        if (prime + 1 == PRIMES && !evidence->primes && w->sol->constraints && !evidence->kernels)
            break;             /* it is the constraints that cannot be met, not a missing root */
    }
    if (ok && !evidence->primes)
        ok = solve_real(w, p, out, evidence, &done, err);
    if (ok && done && evidence->reals)
        evidence->why_not = "no points of the constraint set modulo a prime were found, and those at real points prove nothing";
    if (ok && !done)
        evidence->why_not = evidence->irrational ? "some coefficients are not rational numbers of moderate size" : evidence->primes
            ? "some coefficients are not rational numbers of moderate size" : "no random points of the constraint set modulo a prime were found at which all functions have values";
    assert(!ok || (out->count <= out->room && out->distinguished <= out->count));
    return ok;
}
