/* The generator of gauge transformations with the time derivatives of its parameters.
 *
 * G = sum of e_A gamma_A over the first class preserves the equations where dG/dt is a combination of primary constraints: for each gamma_A that is
 * not primary  D e_A + sum over B of e_B V_BA = 0, with {gamma_B, H'} = V_BA gamma_A on the set to first order, D the derivative along the motion. Each
 * equation is solved for an e_B that V_BA brings in, or several for as many; what is left open is a parameter. What no chain that begins at a primary one reaches (Cawley's
 * constraints, which vanish to second order in the brackets) generates no transformation: e is 0 there. */
#include "basis.h"

#include <assert.h>
#include <string.h>

#include "derive.h"
#include "error.h"

struct chain {
    const struct dirac_system *d;
    const struct dirac_classes *c;
    struct dirac_generator *g;
    struct sga_arena mem;
    struct dirac_basis basis;
    expr_id *V;                   /* firsts x firsts */
    expr_id *mix;                 /* primary x others x others: of the brackets with primary ones in those that are not */
    bool mixed;                   /* some of it is not 0 */
    expr_id *e;                   /* firsts x parameters x orders */
    unsigned char *known, *used;  /* by first-class combination: e_A, and its equation */
    int parameters, orders;
};

/* The factors of f, which vanishes on the set, in the constraints to first order: rows of `of` functions at once. False: undecided or not of that kind. */
static bool expand(struct chain *h, const expr_id *f, int count, expr_id *factor, bool *possible)
{
    const struct dirac_space *s = h->d->space;
    struct expr_store *st = s->weak->st;
    int m = h->d->constraints, n2 = 2 * s->n, width = m + count;
    SGA_ARENA(mem);
    expr_id *a = sga_zeros(&mem, (size_t)(n2 * width) + 1, sizeof *a);
    int *pivot = sga_zeros(&mem, (size_t)m + 1, sizeof *pivot);
    for (int i = 0; i < n2; i++) {
        for (int k = 0; k < m; k++)
            a[i * width + k] = weak_normal(s->weak, expr_diff(st, h->d->chi[k], s->symbol[i]));
        for (int k = 0; k < count; k++)
            a[i * width + m + k] = weak_normal(s->weak, expr_diff(st, f[k], s->symbol[i]));
    }
    if (!weak_eliminate(s->weak, a, n2, m, width, pivot))
        return false;
    *possible = true;
    for (int k = 0; k < m; k++)
        *possible &= pivot[k] >= 0;
    for (int i = m; i < n2 && *possible; i++)
        for (int k = 0; k < count; k++) {
            int is = weak_zero(s->weak, a[i * width + m + k]);
            if (is < 0)
                return false;
            *possible &= is;
        }
    for (int k = 0; k < count && *possible; k++)
        for (int q = 0; q < m; q++)
            factor[k * m + q] = a[pivot[q] * width + m + k];
    return true;
}

/* Component A (not primary) of a function that vanishes on the set, from its factors in the constraints. */
static expr_id component(const struct chain *h, const expr_id *factor, int A)
{
    struct expr_store *st = h->d->space->weak->st;
    int P = h->basis.primary, N = h->basis.firsts - P;
    expr_id sum = expr_int(st, 0);
    for (int B = 0; B < N; B++)
        sum = expr_add(st, sum, expr_mul(st, factor[h->c->lead[P + B]], h->basis.inverse[B * N + A - P]));
    return weak_on_set(h->d->space->weak, weak_normal(h->d->space->weak, sum), h->d->chi, h->d->constraints);
}

/* V from {gamma_B, H'} + d gamma_B/dt, and what the free multipliers bring in. */
static bool find_V(struct chain *h, bool *possible)
{
    const struct dirac_system *d = h->d;
    const struct dirac_classes *c = h->c;
    const expr_id *first = h->basis.first;
    struct expr_store *st = d->space->weak->st;
    int F = c->firsts, P = c->primary_firsts, N = F - P, m = d->constraints, count = F + F * P;
    expr_id *f = sga_zeros(&h->mem, (size_t)count + 1, sizeof *f), *factor = sga_zeros(&h->mem, (size_t)(count * m) + 1, sizeof *factor);
    for (int A = 0; A < F; A++) {
        f[A] = expr_add(st, dirac_poisson(d->space, first[A], c->first_class_hamiltonian), dirac_by_time(d->space, first[A]));
        for (int a = 0; a < P; a++)
            f[F + A * P + a] = dirac_poisson(d->space, first[A], first[a]);
    }
    h->mixed = false;
    if (!expand(h, f, count, factor, possible))
        return false;
    h->V = sga_zeros(&h->mem, (size_t)(F * F) + 1, sizeof *h->V);
    h->mix = sga_zeros(&h->mem, (size_t)(P * N * N) + 1, sizeof *h->mix);
    for (int B = 0; B < F && *possible; B++)
        for (int A = 0; A < F; A++) {
            h->V[B * F + A] = A < P ? factor[B * m + c->lead[A]] : component(h, factor + B * m, A);
            for (int a = 0; a < P && A >= P; a++) {
                expr_id e = component(h, factor + (F + B * P + a) * m, A);
                int is = weak_zero(d->space->weak, e);
                if (is < 0)
                    return false;
                h->mixed |= !is;
                if (B >= P)
                    h->mix[(a * N + B - P) * N + A - P] = is ? expr_int(st, 0) : e;
                else
                    *possible &= is;      /* primary ones stay as they are */
            }
        }
    return true;
}

/* V in a basis that the primary ones do not mix. *possible: there is one. False: undecided. */
static bool find_basis(struct chain *h, bool *possible)
{
    dirac_basis_begin(&h->basis, h->d, h->c);
    if (!find_V(h, possible) || !*possible || !h->mixed)
        return h->d->space->weak->err->code == SGA_E_OK;
    bool ok = dirac_basis_resolve(&h->basis, h->d) && find_V(h, possible);
    if (ok && *possible && h->mixed)
        ok = dirac_basis_scale(&h->basis, h->d, h->mix, possible) && (!*possible || find_V(h, possible));
    *possible &= !h->mixed;
    return ok;
}

static expr_id *e_at(const struct chain *h, int A, int parameter, int order)
{
    return h->e + (A * h->parameters + parameter) * h->orders + order;
}

/* The coefficient of the order-th derivative of a parameter in D e_A + sum of known e_B V_BA. */
static expr_id coefficient(const struct chain *h, int A, int parameter, int order)
{
    const struct dirac_space *s = h->d->space;
    struct expr_store *st = s->weak->st;
    expr_id own = *e_at(h, A, parameter, order);
    expr_id sum = expr_add(st, dirac_poisson(s, own, h->c->first_class_hamiltonian), dirac_by_time(s, own));
    if (order)
        sum = expr_add(st, sum, *e_at(h, A, parameter, order - 1));
    for (int B = 0; B < h->c->firsts; B++)
        if (h->known[B])
            sum = expr_add(st, sum, expr_mul(st, *e_at(h, B, parameter, order), h->V[B * h->c->firsts + A]));
    return weak_normal(s->weak, sum);
}

/* Solves the equation of A for e_B. */
static void solve_for(struct chain *h, int A, int B)
{
    struct expr_store *st = h->d->space->weak->st;
    for (int p = 0; p < h->parameters; p++)
        for (int k = 0; k < h->orders; k++)
            *e_at(h, B, p, k) = weak_normal(h->d->space->weak, expr_neg(st, expr_div(st, coefficient(h, A, p, k), h->V[B * h->c->firsts + A])));
    h->known[B] = 1;
    h->used[A] = 1;
}

/* The only unknown e_B in the equation of A; -1: none, or several; -2: undecided. */
static int only_unknown(const struct chain *h, int A)
{
    int found = -1;
    for (int B = 0; B < h->c->firsts; B++) {
        int is = h->known[B] ? 1 : weak_zero(h->d->space->weak, h->V[B * h->c->firsts + A]);
        if (is < 0)
            return -2;
        if (is)
            continue;
        if (found >= 0)
            return -1;
        found = B;
    }
    return found;
}

/* 1: an equation was solved; 0: none can be; -1: undecided. */
static int step(struct chain *h)
{
    for (int A = h->c->firsts - 1; A >= h->c->primary_firsts; A--) {
        if (!h->known[A] || h->used[A])
            continue;
        int B = only_unknown(h, A);
        if (B == -2)
            return -1;
        if (B < 0)
            continue;
        solve_for(h, A, B);
        return 1;
    }
    return 0;
}

/* Equations whose e_A is known, for as many others that they bring in, all at once. 1: they were solved; 0: these are more, or what is brought in is not
 * independent; -1: undecided. */
static int solve_together(struct chain *h)
{
    const struct weak *weak = h->d->space->weak;
    struct expr_store *st = weak->st;
    int F = h->c->firsts, sides = h->parameters * h->orders, rows = 0, unknowns = 0;
    SGA_ARENA(mem);
    int *row = sga_zeros(&mem, (size_t)F + 1, sizeof *row), *unknown = sga_zeros(&mem, (size_t)F + 1, sizeof *unknown), *pivot = sga_zeros(&mem, (size_t)F + 1, sizeof *pivot);
    for (int A = h->c->primary_firsts; A < F; A++)
        if (h->known[A] && !h->used[A])
            row[rows++] = A;
    for (int B = 0; B < F; B++) {
        bool in = false;
        for (int i = 0; i < rows && !h->known[B] && !in; i++) {
            int is = weak_zero(weak, h->V[B * F + row[i]]);
            if (is < 0)
                return -1;
            in = !is;
        }
        if (in)
            unknown[unknowns++] = B;
    }
    if (!unknowns || unknowns > rows)
        return 0;
    int width = unknowns + sides;
    expr_id *a = sga_zeros(&mem, (size_t)(rows * width) + 1, sizeof *a);
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < unknowns; k++)
            a[i * width + k] = h->V[unknown[k] * F + row[i]];
        for (int k = 0; k < sides; k++)
            a[i * width + unknowns + k] = coefficient(h, row[i], k / h->orders, k % h->orders);
    }
    if (!weak_eliminate(weak, a, rows, unknowns, width, pivot))
        return -1;
    for (int k = 0; k < unknowns; k++)
        if (pivot[k] < 0)
            return 0;
    for (int k = 0; k < unknowns; k++) {
        for (int q = 0; q < sides; q++)
            *e_at(h, unknown[k], q / h->orders, q % h->orders) = weak_normal(weak, expr_neg(st, a[pivot[k] * width + unknowns + q]));
        h->known[unknown[k]] = 1;
    }
    for (int i = 0; i < rows; i++)       /* those that are left over are asked about at the end */
        h->used[row[i]] = 1;
    return 1;
}

/* Whether the equations that were not used hold by themselves, and coefficients do not move with the free multipliers: 1, 0, -1. */
static int holds(struct chain *h)
{
    const struct dirac_space *s = h->d->space;
    for (int A = h->c->primary_firsts; A < h->c->firsts; A++)
        for (int p = 0; p < h->parameters; p++)
            for (int k = 0; k < h->orders; k++) {
                int is = weak_zero(s->weak, coefficient(h, A, p, k));
                for (int a = 0; a < h->c->primary_firsts && is == 1; a++)
                    is = weak_zero(s->weak, dirac_poisson(s, *e_at(h, A, p, k), h->basis.first[a]));
                if (is != 1)
                    return is;
            }
    return 1;
}

static bool none(struct chain *h, const char *why)
{
    *h->g = (struct dirac_generator){ .why_not = why };
    return true;
}

/* Marks what the chains of the primary ones reach; the others stay at 0. False: undecided. */
static bool find_chains(struct chain *h)
{
    int F = h->c->firsts;
    SGA_ARENA(mem);
    unsigned char *reached = sga_zeros(&mem, (size_t)F + 1, 1);
    for (int B = 0; B < h->c->primary_firsts; B++)
        reached[B] = 1;
    for (bool more = true; more; ) {
        more = false;
        for (int B = 0; B < F; B++)
            for (int A = 0; A < F && reached[B]; A++) {
                int is = reached[A] ? 1 : weak_zero(h->d->space->weak, h->V[B * F + A]);
                if (is < 0)
                    return false;
                if (!is)
                    reached[A] = 1, more = true;
            }
    }
    h->g->idle = sga_zeros(h->d->space->mem, (size_t)F + 1, 1);
    for (int A = 0; A < F; A++) {
        h->g->idle[A] = h->known[A] = h->used[A] = !reached[A];
        h->g->idles += !reached[A];
    }
    return true;
}

static bool solve_chain(struct chain *h)
{
    struct expr_store *st = h->d->space->weak->st;
    int F = h->c->firsts, chosen = 0;
    bool possible;
    if (!find_basis(h, &possible))
        return false;
    if (!possible)
        return none(h, "the brackets of the first class with the Hamiltonian, or with the free multipliers' constraints, mix with what is not primary: no generator whose parameters "
                    "are functions of time alone was found");
    h->parameters = h->c->primary_firsts;
    h->orders = F - h->c->primary_firsts + 1;
    h->e = sga_zeros(&h->mem, (size_t)(F * h->parameters * h->orders) + 1, sizeof *h->e);
    h->known = sga_zeros(&h->mem, (size_t)F + 1, 1);
    h->used = sga_zeros(&h->mem, (size_t)F + 1, 1);
    for (int i = 0; i < F * h->parameters * h->orders; i++)
        h->e[i] = expr_int(st, 0);
    if (!find_chains(h))
        return false;
    for (;;) {
        int did = step(h), last = F - 1;
        if (!did)
            did = solve_together(h);
        if (did < 0)
            return false;
        if (did)
            continue;
        while (last >= 0 && h->known[last])
            last--;
        if (last < 0)
            break;
        if (chosen == h->parameters)
            return none(h, "the chains of the first class do not close");
        *e_at(h, last, chosen++, 0) = expr_int(st, 1);
        h->known[last] = 1;
    }
    int is = holds(h);
    if (is < 0)
        return false;
    if (!is || chosen != h->parameters)
        return none(h, "the chains of the first class do not close");
    h->g->parameters = h->parameters;
    h->g->orders = h->orders;
    h->g->term = sga_zeros(h->d->space->mem, (size_t)(h->parameters * h->orders) + 1, sizeof *h->g->term);
    for (int p = 0; p < h->parameters; p++)
        for (int k = 0; k < h->orders; k++) {
            expr_id sum = expr_int(st, 0);
            for (int A = 0; A < F; A++)
                sum = expr_add(st, sum, expr_mul(st, *e_at(h, A, p, k), h->basis.first[A]));
            h->g->term[p * h->orders + k] = weak_normal(h->d->space->weak, sum);
        }
    return true;
}

bool dirac_generator_find(struct dirac_generator *g, const struct dirac_system *d, struct dirac_classes *c)
{
    struct chain h = { .d = d, .c = c, .g = g };
    *g = (struct dirac_generator){ .orders = 1 };
    bool ok = c->firsts == 0 || solve_chain(&h);
    if (ok && c->firsts && !g->why_not)
        memcpy(c->first, h.basis.first, (size_t)c->firsts * sizeof *c->first);
    sga_arena_end(&h.mem);
    return ok;
}
