/* Linear equations for rational unknowns, sampled at random points of Pf modulo primes.
 *
 * Points are added until the ranks stay; at enough random points the solutions modulo p are
 * no fewer than the rational ones, so a basis whose every member is confirmed afterwards is
 * complete. Coefficients come from their residues modulo one or more 60-bit primes (Chinese
 * remainders, rational reconstruction); a wrong guess does not pass the check that follows. */
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "parts.h"

enum { PRIMES = 4, STEADY = 3, FAILURES = 40, MARGIN_BITS = 12 };

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

/* One more point; false where none is found, or a value is missing there. */
static bool add_point(struct sym_work *w, const struct sym_problem *p, int prime, uint64_t *random, struct sym_spaces *s,
                      struct sym_evidence *evidence)
{
    struct points_modpoint at;
    if (!points_modpoint_find_modulo(&at, &w->shadow->space, w->shadow->real[0].solved, prime, random))
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

static bool sample(struct sym_work *w, const struct sym_problem *p, int prime, uint64_t *random, struct sym_spaces *s,
                   struct sym_evidence *evidence, struct sga_error *err)
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
    if (steady < STEADY)
        evidence->why_not = "no random points of the constraint set modulo a prime were found at which all functions have values";
    return true;
}

/* Moves the rows of `from`, reduced by `base` and `other`, into `to`. */
static void complement(const struct sym_space *from, const struct sym_space *base, const struct sym_space *other,
                       struct sym_space *to)
{
    mp_limb_t *v = sga_malloc(((size_t)from->cols + 1) * sizeof *v);
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
    free(v);
}

/* The solutions modulo p: the distinguished ones modulo the trivial ones, then the others. */
static void bases(const struct sym_problem *p, struct sym_spaces *s, struct sym_space *special, struct sym_space *rest)
{
    struct sym_space trivial, all, both;
    sym_space_finish(&s->equation);
    sym_space_finish(&s->trivial);
    sym_space_kernel(&s->equation, &all);
    sym_space_kernel(&s->trivial, &trivial);
    if (p->split) {
        mp_limb_t *v = sga_malloc(((size_t)p->cols + 1) * sizeof *v);
        for (int j = 0; j < p->cols; j++)
            if (s->equation.row[j]) {
                memcpy(v, s->equation.row[j], (size_t)p->cols * sizeof *v);
                sym_space_insert(&s->gauge, v);
            }
        sym_space_finish(&s->gauge);
        sym_space_kernel(&s->gauge, &both);
        complement(&both, &trivial, NULL, special);
        sym_space_clear(&both);
        free(v);
    } else {
        sym_space_init(special, p->cols, all.mod);
    }
    complement(&all, &trivial, special, rest);
    sym_space_clear(&trivial);
    sym_space_clear(&all);
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

/* All values as fractions much smaller than the modulus allows. */
static bool reconstruct(const struct lift *l, struct sym_solutions *out)
{
    slong size = (slong)l->rows * l->cols, bits = (slong)fmpz_bits(l->product) - MARGIN_BITS;
    bool ok = true;
    *out = (struct sym_solutions){ .count = l->rows, .cols = l->cols, .distinguished = l->special };
    out->value = sga_malloc(((size_t)size + 1) * sizeof *out->value);
    for (slong k = 0; k < size; k++)
        fmpq_init(out->value + k);
    for (slong k = 0; k < size && ok; k++)
        ok = fmpz_is_zero(l->value + k)
             || (fmpq_reconstruct_fmpz(out->value + k, l->value + k, l->product)
                 && (slong)(fmpz_bits(fmpq_numref(out->value + k)) + fmpz_bits(fmpq_denref(out->value + k))) < bits);
    if (!ok)
        sym_solutions_clear(out);
    return ok;
}

void sym_solutions_clear(struct sym_solutions *s)
{
    for (slong k = 0; k < (slong)s->count * s->cols && s->value; k++)
        fmpq_clear(s->value + k);
    free(s->value);
    *s = (struct sym_solutions){ 0 };
}

bool sym_solve(struct sym_work *w, const struct sym_problem *p, struct sym_solutions *out, struct sym_evidence *evidence,
               struct sga_error *err)
{
    uint64_t random = 20250901;
    struct lift lift = { 0 };
    bool ok = true, done = false;
    *out = (struct sym_solutions){ 0 };
    evidence->unknowns = p->cols;
    for (int prime = 0; prime < PRIMES && ok && !done && !evidence->why_not; prime++) {
        struct sym_spaces s;
        struct sym_space special, rest;
        ok = sample(w, p, prime, &random, &s, evidence, err);
        if (ok && !evidence->why_not) {
            bases(p, &s, &special, &rest);
            if (lift.started && !same_shape(&lift, &special, &rest))
                lift_clear(&lift);      /* one of the primes was unlucky */
            if (!lift.started)
                lift_start(&lift, &special, &rest);
            lift_add(&lift, &special, &rest);
            done = reconstruct(&lift, out);
            evidence->primes++;
            evidence->points += s.points;
            sym_space_clear(&special);
            sym_space_clear(&rest);
        }
        spaces_clear(&s);
    }
    if (ok && !done && !evidence->why_not)
        evidence->why_not = "coefficients are not rational numbers of moderate size";
    lift_clear(&lift);
    return ok;
}
