/* Elimination of gradients, and integrating factors. */
#include "basis.h"

#include <assert.h>
#include <string.h>

#include "derive.h"
#include "facts.h"
#include "poly.h"

/* Of factors whose powers are tried, and those powers. */
enum { MOST_FACTORS = 4, MOST_POWER = 2, MOST_TRIES = 700 };

void dirac_basis_begin(struct dirac_basis *b, const struct dirac_system *d, const struct dirac_classes *c)
{
    struct sga_arena *mem = d->space->mem;
    struct expr_store *st = d->space->weak->st;
    int N = c->firsts - c->primary_firsts;
    *b = (struct dirac_basis){ .firsts = c->firsts, .primary = c->primary_firsts };
    b->first = sga_zeros(mem, (size_t)c->firsts + 1, sizeof *b->first);
    b->inverse = sga_zeros(mem, (size_t)(N * N) + 1, sizeof *b->inverse);
    memcpy(b->first, c->first, (size_t)c->firsts * sizeof *b->first);
    for (int i = 0; i < N * N; i++)
        b->inverse[i] = expr_int(st, i / N == i % N);
}

/* Gradients of e[0..rows) by momenta and then coordinates, and behind them a unit matrix of `unit` columns, from `from` on. */
static void gradients(const struct dirac_space *s, const expr_id *e, int rows, int unit, int from, int width, expr_id *m)
{
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < 2 * s->n; k++)
            m[i * width + k] = weak_normal(s->weak, expr_diff(s->weak->st, e[i], s->symbol[(k + s->n) % (2 * s->n)]));
        for (int k = 0; k < unit; k++)
            m[i * width + 2 * s->n + k] = expr_int(s->weak->st, k == from + i);
    }
}

/* inverse := inverse * T^-1, as new = T old. */
static bool divide(struct dirac_basis *b, const struct dirac_space *s, const expr_id *T, int N)
{
    struct expr_store *st = s->weak->st;
    SGA_ARENA(mem);
    int width = 2 * N;
    expr_id *m = sga_zeros(&mem, (size_t)(N * width) + 1, sizeof *m), *was = sga_zeros(&mem, (size_t)(N * N) + 1, sizeof *was);
    int *pivot = sga_zeros(&mem, (size_t)N + 1, sizeof *pivot);
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++) {
            m[i * width + k] = T[i * N + k];
            m[i * width + N + k] = expr_int(st, i == k);
        }
    if (!weak_eliminate(s->weak, m, N, N, width, pivot))
        return false;
    memcpy(was, b->inverse, (size_t)(N * N) * sizeof *was);
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++) {
            expr_id sum = expr_int(st, 0);
            for (int j = 0; j < N; j++)
                sum = expr_add(st, sum, expr_mul(st, was[i * N + j], m[pivot[j] * width + N + k]));
            b->inverse[i * N + k] = weak_normal(s->weak, sum);
        }
    return true;
}

bool dirac_basis_resolve(struct dirac_basis *b, const struct dirac_system *d)
{
    const struct dirac_space *s = d->space;
    struct expr_store *st = s->weak->st;
    int P = b->primary, N = b->firsts - P, n2 = 2 * s->n, width = n2 + b->firsts;
    SGA_ARENA(mem);
    expr_id *p = sga_zeros(&mem, (size_t)(P * width) + 1, sizeof *p), *m = sga_zeros(&mem, (size_t)(N * width) + 1, sizeof *m), *T = sga_zeros(&mem, (size_t)(N * N) + 1, sizeof *T);
    expr_id *first = sga_zeros(&mem, (size_t)N + 1, sizeof *first);
    int *pivot = sga_zeros(&mem, (size_t)n2 + 1, sizeof *pivot);
    gradients(s, b->first, P, b->firsts, 0, width, p);
    gradients(s, b->first + P, N, b->firsts, P, width, m);
    if (!weak_eliminate(s->weak, p, P, n2, width, pivot))
        return false;
    for (int c = 0; c < n2; c++)                 /* what the primary ones are solved for leaves the others */
        for (int i = 0; i < N && pivot[c] >= 0; i++) {
            expr_id by = m[i * width + c];
            for (int k = 0; k < width && !expr_is_zero(st, by); k++)
                m[i * width + k] = weak_normal(s->weak, expr_sub(st, m[i * width + k], expr_mul(st, by, p[pivot[c] * width + k])));
        }
    if (!weak_eliminate(s->weak, m, N, n2, width, pivot))
        return false;
    for (int i = 0; i < N; i++) {
        first[i] = expr_int(st, 0);
        for (int k = 0; k < b->firsts; k++)
            first[i] = expr_add(st, first[i], expr_mul(st, m[i * width + n2 + k], b->first[k]));
        first[i] = weak_normal(s->weak, first[i]);
        for (int k = 0; k < N; k++)
            T[i * N + k] = m[i * width + n2 + P + k];
    }
    memcpy(b->first + P, first, (size_t)N * sizeof *first);
    return divide(b, s, T, N);
}

struct factors { expr_id e[MOST_FACTORS]; int count; };

static void add_factors(struct factors *f, const struct weak *w, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, w->budget);
    for (int below = 0; below < 2; below++) {
        struct poly_factors list;
        if (expr_is_const(w->st, e) || !(below ? poly_denominator_factors : poly_numerator_factors)(w->st, e, &limits, &list))
            continue;
        for (int i = 0; i < list.factors; i++) {
            bool known = false;
            for (int k = 0; k < f->count; k++)
                known |= f->e[k] == list.factor[i].expr;
            if (!known && f->count < MOST_FACTORS && list.factor[i].depends & ~(unsigned)EXPR_HAS_PARAMETER)
                f->e[f->count++] = list.factor[i].expr;
        }
        poly_factors_clear(&list);
    }
}

/* Whether f = product of powers makes up for C: {f, phi} + f C = 0, that is sum of power_i {g_i, phi}/g_i + C = 0, for each primary phi: 1, 0, -1 undecided. */
static int makes_up(const struct dirac_basis *b, const struct dirac_system *d, const struct factors *f, const int *power, const expr_id *mix, int A)
{
    struct expr_store *st = d->space->weak->st;
    int N = b->firsts - b->primary;
    for (int a = 0; a < b->primary; a++) {
        expr_id sum = mix[(a * N + A) * N + A];
        for (int i = 0; i < f->count; i++)
            if (power[i])
                sum = expr_add(st, sum, expr_mul(st, expr_int(st, power[i]), expr_div(st, dirac_poisson(d->space, f->e[i], b->first[a]), f->e[i])));
        int is = weak_zero(d->space->weak, weak_normal(d->space->weak, sum));
        if (is != 1)
            return is;
    }
    return 1;
}

/* Small powers first. */
static int search(const struct dirac_basis *b, const struct dirac_system *d, const struct factors *f, const expr_id *mix, int A, int *power)
{
    int tries = 1;
    for (int i = 0; i < f->count; i++)
        tries *= 2 * MOST_POWER + 1;
    for (int size = 0; size <= MOST_POWER * MOST_FACTORS; size++)
        for (int k = 0; k < tries && k < MOST_TRIES; k++) {
            int left = k, sum = 0;
            for (int i = 0; i < f->count; i++) {
                power[i] = left % (2 * MOST_POWER + 1) - MOST_POWER;
                left /= 2 * MOST_POWER + 1;
                sum += power[i] < 0 ? -power[i] : power[i];
            }
            int is = sum == size ? makes_up(b, d, f, power, mix, A) : 0;
            if (is)
                return is;
        }
    return 0;
}

static expr_id product(struct expr_store *st, const struct factors *f, const int *power)
{
    expr_id e = expr_int(st, 1);
    for (int i = 0; i < f->count; i++)
        for (int k = 0; k < (power[i] < 0 ? -power[i] : power[i]); k++)
            e = power[i] < 0 ? expr_div(st, e, f->e[i]) : expr_mul(st, e, f->e[i]);
    return e;
}

bool dirac_basis_scale(struct dirac_basis *b, const struct dirac_system *d, const expr_id *mix, bool *found)
{
    const struct weak *w = d->space->weak;
    int P = b->primary, N = b->firsts - P;
    *found = true;
    assert(P > 0);
    for (int A = 0; A < N && *found; A++) {
        struct factors f = { .count = 0 };
        int power[MOST_FACTORS];
        for (int a = 0; a < P && *found; a++)
            for (int B = 0; B < N && *found; B++) {
                int is = A == B ? 1 : weak_zero(w, mix[(a * N + A) * N + B]);
                if (is < 0)
                    return false;
                *found &= is;
                if (A == B)
                    add_factors(&f, w, mix[(a * N + A) * N + A]);
            }
        for (int a = 0; a < P; a++)
            for (int k = 0; k < 2 * d->space->n; k++)
                add_factors(&f, w, weak_normal(w, expr_diff(w->st, b->first[a], d->space->symbol[k])));
        int is = *found ? search(b, d, &f, mix, A, power) : 0;
        if (is < 0)
            return false;
        *found &= is;
        if (!is)
            continue;
        expr_id by = product(w->st, &f, power);
        b->first[P + A] = weak_normal(w, expr_mul(w->st, by, b->first[P + A]));
        for (int i = 0; i < N; i++)
            b->inverse[i * N + A] = weak_normal(w, expr_div(w->st, b->inverse[i * N + A], by));
    }
    return true;
}
