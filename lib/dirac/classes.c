/* Brackets, classes, multipliers and Dirac's bracket. */
#include "classes.h"

#include <assert.h>
#include <string.h>

#include "derive.h"
#include "error.h"
#include "signal.h"

expr_id dirac_poisson(const struct dirac_space *s, expr_id f, expr_id g)
{
    struct expr_store *st = s->weak->st;
    expr_id sum = expr_int(st, 0);
    for (int i = 0; i < s->n; i++) {
        expr_id fq = expr_diff(st, f, s->symbol[i]), gp = expr_diff(st, g, s->symbol[s->n + i]);
        expr_id fp = expr_diff(st, f, s->symbol[s->n + i]), gq = expr_diff(st, g, s->symbol[i]);
        sum = expr_add(st, sum, expr_sub(st, expr_mul(st, fq, gp), expr_mul(st, fp, gq)));
    }
    return weak_normal(s->weak, sum);
}

expr_id dirac_by_time(const struct dirac_space *s, expr_id f)
{
    return expr_time_partial(s->weak->st, f, s->time);
}

static expr_id zero(const struct dirac_system *d)
{
    return expr_int(d->space->weak->st, 0);
}

/* {chi_j, chi_k}, 0 where it vanishes on the set. */
static bool pair_all(struct dirac_classes *c, const struct dirac_system *d)
{
    const struct weak *w = d->space->weak;
    int m = d->constraints;
    c->pair = sga_zeros(d->space->mem, (size_t)(m * m) + 1, sizeof *c->pair);
    for (int j = 0; j < m; j++) {
        c->pair[j * m + j] = zero(d);
        for (int k = j + 1; k < m; k++) {
            expr_id e = dirac_poisson(d->space, d->chi[j], d->chi[k]);
            int is = weak_zero(w, e);
            if (is < 0)
                return false;
            c->pair[j * m + k] = is ? zero(d) : e;
            c->pair[k * m + j] = is ? zero(d) : weak_normal(w, expr_neg(w->st, e));
        }
    }
    return true;
}

/* Columns from left to right: one that depends on those before it gives a combination of first class, and the others a regular matrix, since the
 * matrix is antisymmetric. */
static bool split(struct dirac_classes *c, const struct dirac_system *d)
{
    const struct weak *w = d->space->weak;
    int m = d->constraints;
    SGA_ARENA(mem);
    expr_id *a = sga_zeros(&mem, (size_t)(m * m) + 1, sizeof *a);
    int *pivot = sga_zeros(&mem, (size_t)m + 1, sizeof *pivot);
    memcpy(a, c->pair, (size_t)(m * m) * sizeof *a);
    if (!weak_eliminate(w, a, m, m, m, pivot))
        return false;
    c->kernel = sga_zeros(d->space->mem, (size_t)(m * m) + 1, sizeof *c->kernel);
    c->lead = sga_zeros(d->space->mem, (size_t)m + 1, sizeof *c->lead);
    c->first = sga_zeros(d->space->mem, (size_t)m + 1, sizeof *c->first);
    c->second = sga_zeros(d->space->mem, (size_t)m + 1, sizeof *c->second);
    for (int k = 0; k < m; k++) {
        if (pivot[k] >= 0) {
            c->second[c->seconds++] = k;
            continue;
        }
        expr_id *row = c->kernel + c->firsts * m, sum = d->chi[k];
        for (int i = 0; i < m; i++) {
            bool used = i < k && pivot[i] >= 0;
            row[i] = i == k ? expr_int(w->st, 1) : used ? weak_normal(w, expr_neg(w->st, a[pivot[i] * m + k])) : zero(d);
            if (used)
                sum = expr_add(w->st, sum, expr_mul(w->st, row[i], d->chi[i]));
        }
        c->lead[c->firsts] = k;
        c->primary_firsts += k < d->primaries;
        c->first[c->firsts++] = weak_normal(w, sum);
    }
    assert(c->firsts + c->seconds == m && c->primary_firsts <= c->firsts);
    return true;
}

/* {chi_j, H} + d chi_j/dt + sum over primary a of u_a {chi_j, chi_a} = 0 on the set. */
static bool fix_multipliers(struct dirac_classes *c, const struct dirac_system *d)
{
    const struct weak *w = d->space->weak;
    struct expr_store *st = w->st;
    int m = d->constraints, a = d->primaries, width = a + 1, rank = 0;
    SGA_ARENA(mem);
    expr_id *u = sga_zeros(&mem, (size_t)(m * width) + 1, sizeof *u);
    int *pivot = sga_zeros(&mem, (size_t)a + 1, sizeof *pivot);
    for (int j = 0; j < m; j++) {
        for (int k = 0; k < a; k++)
            u[j * width + k] = c->pair[j * m + k];
        u[j * width + a] = expr_neg(st, expr_add(st, dirac_poisson(d->space, d->chi[j], d->hamiltonian), dirac_by_time(d->space, d->chi[j])));
    }
    if (!weak_eliminate(w, u, m, a, width, pivot))
        return false;
    for (int k = 0; k < a; k++)
        rank += pivot[k] >= 0;
    assert(rank <= m);
    for (int j = rank; j < m; j++) {
        int is = weak_zero(w, u[j * width + a]);
        if (is < 0)
            return false;
        if (!is)
            return sga_fail(w->err, SGA_E_WITNESS, "the brackets with the Hamiltonian leave a constraint that the reduction did not find");
    }
    c->fixed = sga_zeros(d->space->mem, (size_t)a + 1, 1);
    c->multiplier = sga_zeros(d->space->mem, (size_t)a + 1, sizeof *c->multiplier);
    c->factor = sga_zeros(d->space->mem, (size_t)(a * a) + 1, sizeof *c->factor);
    c->first_class_hamiltonian = d->hamiltonian;
    for (int k = 0; k < a; k++) {
        c->fixed[k] = pivot[k] >= 0;
        c->multiplier[k] = pivot[k] < 0 ? zero(d) : weak_normal(w, u[pivot[k] * width + a]);
        for (int f = 0; f < a; f++)
            c->factor[k * a + f] = pivot[k] < 0 || pivot[f] >= 0 ? zero(d) : weak_normal(w, expr_neg(st, u[pivot[k] * width + f]));
        c->first_class_hamiltonian = expr_add(st, c->first_class_hamiltonian, expr_mul(st, c->multiplier[k], d->chi[k]));
    }
    return true;
}

/* {x, y}* = {x, y} - {x, chi_a} (Delta^-1)_ab {chi_b, y} over the second class. */
static bool bracket(struct dirac_classes *c, const struct dirac_system *d)
{
    const struct weak *w = d->space->weak;
    struct expr_store *st = w->st;
    int m = d->constraints, s = c->seconds, n2 = 2 * d->space->n, width = s + n2;
    SGA_ARENA(mem);
    /* [Delta | {chi_b, y}] by elimination: Delta^-1 {chi, y} */
    expr_id *a = sga_zeros(&mem, (size_t)(s * width) + 1, sizeof *a), *y = sga_zeros(&mem, (size_t)(s * n2) + 1, sizeof *y);
    int *pivot = sga_zeros(&mem, (size_t)s + 1, sizeof *pivot);
    for (int i = 0; i < s; i++) {
        for (int k = 0; k < s; k++)
            a[i * width + k] = c->pair[c->second[i] * m + c->second[k]];
        for (int k = 0; k < n2; k++)
            y[i * n2 + k] = a[i * width + s + k] = dirac_poisson(d->space, d->chi[c->second[i]], st->symbol[d->space->symbol[k]].node);
    }
    if (!weak_eliminate(w, a, s, s, width, pivot))
        return false;
    for (int k = 0; k < s; k++)
        if (pivot[k] < 0)
            return sga_fail(w->err, SGA_E_WITNESS, "the brackets of the second class are not regular");
    c->bracket = sga_zeros(d->space->mem, (size_t)(n2 * n2) + 1, sizeof *c->bracket);
    for (int i = 0; i < n2; i++)
        for (int k = 0; k < n2; k++) {
            expr_id e = expr_int(st, k == i + d->space->n ? 1 : i == k + d->space->n ? -1 : 0);
            for (int b = 0; b < s; b++)      /* {x_i, chi} = -{chi, x_i} */
                e = expr_add(st, e, expr_mul(st, y[b * n2 + i], a[pivot[b] * width + s + k]));
            c->bracket[i * n2 + k] = weak_normal(w, e);
        }
    return true;
}

bool dirac_classes_find(struct dirac_classes *c, const struct dirac_system *d)
{
    assert(d->primaries <= d->constraints);
    return pair_all(c, d) && split(c, d) && fix_multipliers(c, d) && bracket(c, d);
}
