/* Factors that vanish at a point, and what follows from them. */
#include "equilibria_shape.h"

#include <math.h>
#include <string.h>

#include "linear_gradients.h"
#include "linear_place.h"
#include "linearize.h"
#include "poly.h"
#include "reduction.h"
#include "system.h"

enum { MOST_PRODUCTS = 64, MOST_BRANCHES = 64 };       /* of factors, one of each family, or of each function */
/* A factor may vanish next to a place if its zeros are, by its slope, within this beside 1 and the variables that it depends on there: a multiple zero is found to half of the digits. */
static const double NEAR = 1e-4;

/* One function: its factors, those first that may vanish next to the place. */
struct factored { expr_id *factor; int count, near; };

struct shaping {
    struct sga_arena *mem;
    const struct linear_request *rq;
    struct expr_store *st;
    struct linear_gradients g;
    int n;
    struct factored *of; int functions;
    expr_id *chosen; int chosens;
};

/* Zero there exactly: 1, not 0: 0, not known: -1. */
static int is_zero_at(struct linear_place *place, expr_id e)
{
    struct linear_matrix v;
    int is = -1;
    if (linear_place_matrix(place, &e, 1, 1, &v)) {
        if (v.exact)
            is = fmpq_is_zero(fmpq_mat_entry(v.q, 0, 0));
        else if (!arb_contains_zero(arb_mat_entry(v.b, 0, 0)))
            is = 0;
    }
    linear_matrix_clear(&v);
    return is;
}

int equilibria_functions(const struct linear_request *rq, const expr_id *held, int helds, bool constraints, expr_id *e)
{
    const struct sys_system *sys = rq->sys;
    int n = 0;
    for (int i = 0; i < sys->rows; i++)
        e[n++] = sys->row[i].alpha;
    for (int i = 0; i < sys->restrictions; i++)
        e[n++] = sys->restriction[i];
    for (int i = 0; i < helds; i++)
        e[n++] = held[i];
    for (int i = 0; i < rq->sol->constraints && constraints; i++)
        e[n++] = rq->sol->constraint[i].expr;
    return n;
}

int equilibria_functions_most(const struct linear_request *rq, int helds)
{
    return rq->sys->rows + rq->sys->restrictions + helds + rq->sol->constraints;
}

/* Gradients of what was chosen, at the place. */
static bool independent(const struct shaping *s, struct linear_place *place)
{
    struct linear_matrix m;
    int rank = 0;
    const expr_id *all = linear_gradients_of(&s->g, s->mem, s->chosen, s->chosens);
    expr_id *own = sga_take(s->mem, ((size_t)s->chosens * (size_t)s->n + 1) * sizeof *own);
    for (int i = 0; i < s->chosens; i++)
        memcpy(own + (size_t)i * (size_t)s->n, all + (size_t)i * (size_t)s->g.cols, (size_t)s->n * sizeof *own);
    if (linear_place_matrix(place, own, s->chosens, s->n, &m))
        linear_matrix_rank(&m, &rank);
    linear_matrix_clear(&m);
    return rank == s->chosens;
}

static double size_of(const struct linear_matrix *m)
{
    double size = 0;
    for (int k = 0; k < linear_cols(m); k++)
        size = fmax(size, fabs(linear_matrix_double(m, 0, k)));
    return size;
}

/* 1, or the largest variable that the gradient has. */
static double scale_of(const struct shaping *s, const struct linear_place *place, const struct linear_matrix *gradient)
{
    double scale = 1;
    for (int k = 0; k < s->n; k++)
        if (linear_matrix_double(gradient, 0, k) != 0)
            scale = fmax(scale, fabs(place->x[k]));
    return scale;
}

/* About how far the zeros of e are from the place, by its scale; infinite: no slope tells. */
static double distance(const struct shaping *s, struct linear_place *place, expr_id e)
{
    struct linear_matrix v, d;
    expr_id *gradient = linear_gradients_of(&s->g, s->mem, &e, 1);
    double off = INFINITY;
    bool ok = linear_place_matrix(place, &e, 1, 1, &v);
    ok = linear_place_matrix(place, gradient, 1, s->n, &d) && ok;
    if (ok && size_of(&v) == 0)
        off = 0;
    else if (ok && size_of(&d) > 0)
        off = size_of(&v) / size_of(&d) / scale_of(s, place, &d);
    linear_matrix_clear(&v);
    linear_matrix_clear(&d);
    return off;
}

/* False: its factors are not known, or none vanishes next to the place. */
static bool factor(struct shaping *s, struct linear_place *place, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, s->rq->budget);
    struct poly_factors f;
    if (!poly_numerator_factors(s->st, e, &limits, &f))
        return false;
    struct factored *to = s->of + s->functions;
    bool ok = true;
    to->factor = sga_take(s->mem, ((size_t)f.factors + 1) * sizeof *to->factor);
    for (int k = 0; k < f.factors; k++) {
        expr_id one = f.factor[k].expr;
        ok &= f.factor[k].irreducible;
        to->factor[to->count++] = one;
        if (distance(s, place, one) > NEAR)
            continue;
        to->factor[to->count - 1] = to->factor[to->near];
        to->factor[to->near++] = one;
    }
    ok &= f.sign == 0 || to->near > 0;       /* 0 itself vanishes everywhere */
    s->functions += to->count > 0;
    poly_factors_clear(&f);
    return ok;
}

static bool factor_all(struct shaping *s, struct linear_place *place, const expr_id *held, int helds)
{
    expr_id *e = sga_take(s->mem, ((size_t)equilibria_functions_most(s->rq, helds) + 1) * sizeof *e);
    int count = equilibria_functions(s->rq, held, helds, true, e);
    s->of = sga_zeros(s->mem, (size_t)count + 1, sizeof *s->of);
    for (int i = 0; i < count; i++)
        if (!factor(s, place, e[i]))
            return false;
    return true;
}

static bool follows(const struct shaping *s, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, s->rq->budget);
    for (int i = 0; i < s->chosens; i++)
        if (e == s->chosen[i])
            return true;
    return poly_vanishes_with(s->st, e, s->chosen, s->chosens, &limits);
}

static bool one_follows(const struct shaping *s, const struct factored *f)
{
    for (int k = 0; k < f->count; k++)
        if (follows(s, f->factor[k]))
            return true;
    return false;
}

/* One of each function that does not follow: of those with one factor first. More than variables are no choice. */
static bool choose(struct shaping *s)
{
    for (int several = 0; several < 2; several++)
        for (int i = 0; i < s->functions; i++) {
            const struct factored *f = s->of + i;
            if ((f->near > 1) != several || one_follows(s, f))
                continue;
            if (s->chosens >= s->n)
                return false;
            s->chosen[s->chosens++] = f->factor[0];
        }
    return true;
}

/* The factor of a function that alone vanishes at the place; EXPR_UNDEF: more than one may. */
static expr_id alone(const struct factored *f, struct linear_place *place)
{
    expr_id one = EXPR_UNDEF;
    for (int k = 0; k < f->count; k++) {
        if (is_zero_at(place, f->factor[k]) == 0)
            continue;
        if (one)
            return EXPR_UNDEF;
        one = f->factor[k];
    }
    return one;
}

/* Whether all that was chosen follows from the constraints and the factors that functions have to vanish by: then there are no other zeros about
 * the place. */
static bool nothing_else(const struct shaping *s, struct linear_place *place, int constraints)
{
    struct shaping by = *s;
    by.chosen = sga_take(s->mem, ((size_t)s->functions + (size_t)constraints + 1) * sizeof *by.chosen);
    by.chosens = constraints;
    if (constraints)
        memcpy(by.chosen, s->chosen, (size_t)constraints * sizeof *by.chosen);
    for (int i = 0; i < s->functions; i++) {
        expr_id one = alone(s->of + i, place);
        if (one)
            by.chosen[by.chosens++] = one;
    }
    for (int i = constraints; i < s->chosens; i++)
        if (!follows(&by, s->chosen[i]))
            return false;
    return true;
}

/* Whether all functions have a value at the place: a numerator says nothing of what is divided by. */
static bool all_have_values(const struct shaping *s, struct linear_place *place, const expr_id *held, int helds)
{
    expr_id *e = sga_take(s->mem, ((size_t)equilibria_functions_most(s->rq, helds) + 1) * sizeof *e);
    struct linear_matrix v;
    int count = equilibria_functions(s->rq, held, helds, true, e);
    bool have = linear_place_matrix(place, e, count, 1, &v);
    for (int i = 0; i < linear_rows(&v) && have; i++)
        have = arb_is_finite(arb_mat_entry(v.b, i, 0));
    linear_matrix_clear(&v);
    return have;
}

bool equilibrium_shape_find(struct equilibrium_shape *out, struct sga_arena *mem, const struct linear_request *rq, const expr_id *held, int helds, const double *x, struct linear_place *place)
{
    struct shaping s = { .mem = mem, .rq = rq, .st = rq->sys->store, .n = rq->sys->variables };
    const struct sga_solution *sol = rq->sol;
    struct linear_guess guess = { .x = x, .budget = rq->budget };
    *out = (struct equilibrium_shape){ .dimension = -1, .constraints = sol->constraints };
    linear_gradients_init(&s.g, mem, rq);
    s.chosen = sga_take(mem, ((size_t)s.n + (size_t)sol->constraints + 1) * sizeof *s.chosen);
    for (int i = 0; i < sol->constraints; i++)
        s.chosen[s.chosens++] = sol->constraint[i].expr;
    bool found = linear_place_find(place, rq->sys, sol, &guess) && factor_all(&s, place, held, helds) && choose(&s);
    if (!found)
        return false;
    linear_place_clear(place);
    guess.zero = s.chosen + sol->constraints;
    guess.zeros = s.chosens - sol->constraints;
    if (!linear_place_find(place, rq->sys, sol, &guess) || place->basis == LINEAR_NUMERIC || !independent(&s, place) || !all_have_values(&s, place, held, helds))
        return false;
    out->factor = s.chosen;
    out->factors = s.chosens;
    if (nothing_else(&s, place, sol->constraints))
        out->dimension = s.n - s.chosens;
    else
        out->crossing = s.chosens < s.n;
    return true;
}

bool equilibrium_shape_has(const struct equilibrium_shape *s, const struct equilibrium_shape *other, struct linear_place *place)
{
    bool has = s->dimension >= 0;
    for (int k = 0; k < s->factors && has; k++) {
        bool stands = false;
        for (int i = 0; i < other->factors; i++)
            stands |= other->factor[i] == s->factor[k];
        has = stands || is_zero_at(place, s->factor[k]) == 1;
    }
    return has;
}

bool equilibrium_shape_may_have(const struct equilibrium_shape *s, struct linear_place *place)
{
    for (int k = 0; k < s->factors; k++)
        if (is_zero_at(place, s->factor[k]) == 0)
            return false;
    return true;
}

/* All factors of a function. */
static bool factors_of(struct shaping *s, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, s->rq->budget);
    struct poly_factors f;
    struct factored *to = s->of + s->functions;
    if (!poly_numerator_factors(s->st, e, &limits, &f))
        return false;
    bool known = true;
    to->factor = sga_take(s->mem, ((size_t)f.factors + 1) * sizeof *to->factor);
    for (int k = 0; k < f.factors; k++) {
        known &= f.factor[k].irreducible;
        if (!f.factor[k].never_zero)
            to->factor[to->count++] = f.factor[k].expr;
    }
    s->functions += f.sign != 0;
    poly_factors_clear(&f);
    return known;
}

/* Function `at` and those after it, with one factor each: s->chosen holds those before. */
static bool branch(struct shaping *s, int at, struct equilibria_branch *out, int *count)
{
    while (at < s->functions && one_follows(s, s->of + at))
        at++;
    if (at == s->functions) {
        if (*count == MOST_BRANCHES)
            return false;
        struct equilibria_branch *b = out + (*count)++;
        b->factors = s->chosens;
        b->factor = sga_take(s->mem, ((size_t)s->chosens + 1) * sizeof *b->factor);
        memcpy(b->factor, s->chosen, (size_t)s->chosens * sizeof *b->factor);
        return true;
    }
    for (int k = 0; k < s->of[at].count; k++) {
        s->chosen[s->chosens++] = s->of[at].factor[k];
        bool ok = branch(s, at + 1, out, count);
        s->chosens--;
        if (!ok)
            return false;
    }
    return true;
}

int equilibria_branches(const struct linear_request *rq, const expr_id *held, int helds, struct sga_arena *mem, struct equilibria_branch **out)
{
    struct shaping s = { .mem = mem, .rq = rq, .st = rq->sys->store, .n = rq->sys->variables };
    int most = equilibria_functions_most(rq, helds), count = 0;
    expr_id *e = sga_take(mem, ((size_t)most + 1) * sizeof *e);
    bool several = false;
    most = equilibria_functions(rq, held, helds, false, e);      /* constraints come first, as they are */
    s.of = sga_zeros(mem, (size_t)most + 1, sizeof *s.of);
    s.chosen = sga_take(mem, ((size_t)most + (size_t)rq->sol->constraints + 1) * sizeof *s.chosen);
    for (int i = 0; i < rq->sol->constraints; i++)
        s.chosen[s.chosens++] = rq->sol->constraint[i].expr;
    *out = sga_take(mem, MOST_BRANCHES * sizeof **out);
    for (int i = 0; i < most; i++) {
        if (!factors_of(&s, e[i]))
            return 0;
        several |= s.functions > 0 && s.of[s.functions - 1].count > 1;
    }
    return several && branch(&s, 0, *out, &count) ? count : 0;
}

/* A symbol that no name of the request can be. */
static int inverse_symbol(struct expr_store *st)
{
    static const char name[] = " 1/h";
    int symbol = expr_symbol_find(st, name, strlen(name));
    return symbol >= 0 ? symbol : st->node[expr_symbol_add(st, name, EXPR_VARIABLE)].a;
}

static bool is_on(const struct shaping *s, const struct equilibrium_shape *family)
{
    for (int k = 0; k < family->factors; k++)
        if (!follows(s, family->factor[k]))
            return false;
    return true;
}

/* By branches: those on no family have finitely many zeros, which may be counted for several. */
static bool beside_by_branches(const struct linear_request *rq, const expr_id *held, int helds, const struct equilibrium_shape *family, int families, const int *symbol, long *others)
{
    SGA_ARENA(mem);
    struct equilibria_branch *branch;
    int branches = equilibria_branches(rq, held, helds, &mem, &branch);
    bool ok = branches > 0;
    for (int b = 0; b < branches && ok; b++) {
        struct shaping s = { .mem = &mem, .rq = rq, .st = rq->sys->store, .n = rq->sys->variables, .chosen = branch[b].factor, .chosens = branch[b].factors };
        bool on = false;
        for (int f = 0; f < families && !on; f++)
            on = is_on(&s, family + f);
        if (on)
            continue;
        struct poly_real_zeros z;
        ok = poly_real_zeros(s.st, branch[b].factor, branch[b].factors, symbol, s.n, rq->budget, &z) == POLY_COUNTED;
        *others += z.real;
        poly_real_zeros_clear(&z);
    }
    return ok;
}

enum poly_count equilibria_beside(const struct linear_request *rq, const expr_id *held, int helds, const struct equilibrium_shape *family, int families, long *others)
{
    struct expr_store *st = rq->sys->store;
    int n = rq->sys->variables, products = 1;
    SGA_ARENA(mem);
    expr_id *e = sga_take(&mem, ((size_t)equilibria_functions_most(rq, helds) + 2) * sizeof *e);
    int *symbol = sga_take(&mem, ((size_t)n + 2) * sizeof *symbol), count = equilibria_functions(rq, held, helds, true, e);
    enum poly_count status = POLY_COUNTED;
    *others = 0;
    for (int k = 0; k < n; k++)
        symbol[k] = rq->sys->variable[k].symbol;
    if (beside_by_branches(rq, held, helds, family, families, symbol, others))
        return POLY_COUNTED;
    *others = 0;
    symbol[n] = inverse_symbol(st);
    for (int f = 0; f < families && products <= MOST_PRODUCTS; f++)
        products *= family[f].factors;
    if (products > MOST_PRODUCTS)
        return POLY_NOT_COUNTED;
    for (int p = 0; p < products && status == POLY_COUNTED; p++) {
        expr_id h = st->symbol[symbol[n]].node;
        for (int f = 0, rest = p; f < families; rest /= family[f++].factors)
            h = expr_mul(st, h, family[f].factor[rest % family[f].factors]);
        e[count] = expr_sub(st, expr_int(st, 1), h);
        struct poly_real_zeros z;
        status = poly_real_zeros(st, e, count + 1, symbol, n + 1, rq->budget, &z);
        *others = z.real > *others ? z.real : *others;
        if (products > 1 && z.real)
            status = POLY_NOT_COUNTED;       /* one zero may be counted for several products */
        poly_real_zeros_clear(&z);
    }
    return status;
}
