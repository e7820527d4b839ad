/* Where the rank of H along W drops.
 *
 * Every way of eliminating H divides by pivots, and where the rank drops some pivot of each way vanishes: so factors
 * of the pivots that were used are places to look at, and if none of them can vanish the rank is full everywhere. A pivot
 * may vanish where the rank holds, though; points with c^T H = 0 and |c| = 1 are what is really meant, and are looked for by
 * themselves. */
#include "mech.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "facts.h"
#include "lin_dense.h"
#include "mem.h"
#include "points.h"
#include "poly.h"

enum { STARTS = 4, BITS = 128, GRAM_AT_MOST = 3, FACTORS_AT_MOST = 64 };

struct search {
    struct mech_regularity *r;
    struct mech_fibre *f;
    const struct form_mechanical *in;
    const struct sga_options *options;
    struct expr_store *st;
    struct expr_facts facts;
    expr_id *factor; int factors; size_t factor_cap;
    bool all_never_zero;
    int n, m;                 /* coordinates, conditions */
};

static struct poly_limits limits_of(const struct search *s)
{
    return (struct poly_limits){ .max_terms = 300, .max_bits = 4000, .max_degree = 40, .max_generators = 24,
                                 .budget = s->options->budget };
}

static bool never_zero(struct search *s, expr_id e)
{
    return (expr_is_const(s->st, e) && !expr_is_zero(s->st, e)) || expr_facts_of(&s->facts, s->st, e) & EXPR_NONZERO;
}

static void add_factor(struct search *s, expr_id e)
{
    if (never_zero(s, e))
        return;
    s->all_never_zero = false;
    for (int i = 0; i < s->factors; i++)
        if (s->factor[i] == e)
            return;
    SGA_RESERVE(s->factor, s->factor_cap, s->factors + 1);
    s->factor[s->factors++] = e;
}

/* Parameters left symbolic are taken as general. */
static void factors_of(struct search *s, expr_id pivot)
{
    struct poly_limits limits = limits_of(s);
    struct poly_factors f;
    if (never_zero(s, pivot))
        return;
    if (!poly_numerator_factors(s->st, pivot, &limits, &f)) {
        add_factor(s, pivot);
        return;
    }
    for (int i = 0; i < f.factors; i++)
        if (!f.factor[i].never_zero && f.factor[i].depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME))
            add_factor(s, f.factor[i].expr);
    poly_factors_clear(&f);
}

static expr_id entry(const struct search *s, int i, int j)
{
    return s->f->H[(size_t)i * (size_t)s->n + (size_t)j];
}

/* det(H H^T), the sum of the squares of all minors, by permutations: few conditions only. */
static expr_id gram_determinant(const struct search *s)
{
    struct expr_store *st = s->st;
    expr_id G[GRAM_AT_MOST][GRAM_AT_MOST];
    for (int i = 0; i < s->m; i++)
        for (int k = 0; k < s->m; k++) {
            G[i][k] = expr_int(st, 0);
            for (int j = 0; j < s->n; j++)
                G[i][k] = expr_add(st, G[i][k], expr_mul(st, entry(s, i, j), entry(s, k, j)));
        }
    if (s->m == 1)
        return G[0][0];
    expr_id det = expr_int(st, 0);
    if (s->m == 2)
        return expr_sub(st, expr_mul(st, G[0][0], G[1][1]), expr_mul(st, G[0][1], G[1][0]));
    for (int i = 0; i < 3; i++) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        expr_id minor = expr_sub(st, expr_mul(st, G[1][a], G[2][b]), expr_mul(st, G[1][b], G[2][a]));
        det = expr_add(st, det, expr_mul(st, G[0][i], minor));
    }
    return det;
}

static bool proved_full(struct search *s)
{
    struct poly_limits limits = limits_of(s);
    struct poly_factors f;
    bool full = true;
    if (s->all_never_zero && !s->f->W.dense_blocks)
        return true;
    if (s->m > GRAM_AT_MOST || !poly_numerator_factors(s->st, gram_determinant(s), &limits, &f))
        return false;
    for (int i = 0; i < f.factors; i++)
        full = full && (f.factor[i].never_zero || !(f.factor[i].depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)));
    full = full && f.sign != 0;
    poly_factors_clear(&f);
    return full;
}

static int rank_of(const double *a, int rows, int cols, double tolerance)
{
    struct lin_dense dense = { .rows = rows, .cols = cols, .a = a };
    int small = rows < cols ? rows : cols, rank = 0;
    double *sv = sga_calloc((size_t)small + 1, sizeof *sv);
    if (lin_singular_values(&dense, sv))
        while (rank < small && sv[rank] > tolerance * (sv[0] > 1 ? sv[0] : 1))
            rank++;
    free(sv);
    return rank;
}

/* Ranks of H and of [H, -rate] at the symbols of a ball. */
static void ranks_at(const struct search *s, struct num_ball *ball, double tolerance, int *rank, int *augmented)
{
    int n = s->n, m = s->m;
    double *H = sga_calloc((size_t)m * (size_t)n + 1, sizeof *H), *wide = sga_calloc((size_t)m * (size_t)(n + 1) + 1, sizeof *wide);
    num_ball_extend(ball);
    for (int i = 0; i < m; i++) {
        double b = arf_get_d(arb_midref(num_ball_value(ball, s->f->rate[i])), ARF_RND_NEAR), big = fabs(b);
        for (int j = 0; j < n; j++) {
            double v = arf_get_d(arb_midref(num_ball_value(ball, entry(s, i, j))), ARF_RND_NEAR);
            H[(size_t)i * (size_t)n + (size_t)j] = wide[(size_t)i * (size_t)(n + 1) + (size_t)j] = v;
            big = fmax(big, fabs(v));
        }
        wide[(size_t)i * (size_t)(n + 1) + (size_t)n] = -b;
        for (int j = 0; j <= n && big > 0; j++)
            wide[(size_t)i * (size_t)(n + 1) + (size_t)j] /= big;
    }
    *rank = rank_of(H, m, n, tolerance);
    *augmented = rank_of(wide, m, n + 1, tolerance);
    free(H);
    free(wide);
}

static void keep_point(struct search *s, const struct points_point *p, bool certified, int rank, int augmented)
{
    struct mech_regularity *r = s->r;
    r->point = sga_malloc((size_t)(2 * s->n + 1) * sizeof *r->point);
    memcpy(r->point, p->x, (size_t)(2 * s->n) * sizeof *r->point);
    r->t = p->t;
    r->certified = certified;
    r->rank = rank;
    r->augmented = augmented;
    r->full = certified ? MECH_DROPS : MECH_DROP_SUSPECTED;
}

/* Looks for a point of the set at which the rank is less than m. */
static bool drops_on(struct search *s, const struct points_space *space, double spread, uint64_t *random, const int *end, int stages)
{
    struct points_point p;
    enum points_status status = points_find_staged(space, end, stages, spread, random, BITS, &p);
    int rank = s->m, augmented = s->m;
    if (status == POINTS_OK) {
        num_ball_forget(&p.ball);
        ranks_at(s, &p.ball, 1e-10, &rank, &augmented);
    } else if (status == POINTS_IRREGULAR) {
        struct num_ball ball;
        num_ball_init(&ball, s->st, BITS);
        for (int i = 0; i < space->variables; i++)
            num_ball_set_d(&ball, space->variable[i], p.x[i]);
        for (int i = 0; i < space->parameters; i++)
            num_ball_set_d(&ball, space->parameter[i], p.parameter[i]);
        num_ball_set_d(&ball, space->time, p.t);
        ranks_at(s, &ball, 1e-5, &rank, &augmented);
        num_ball_clear(&ball);
    }
    bool found = rank < s->m;
    if (found && (!s->r->point || (status == POINTS_OK && p.certified && !s->r->certified))) {
        free(s->r->point);
        keep_point(s, &p, status == POINTS_OK && p.certified, rank, augmented);
    }
    points_point_clear(&p);
    return found;
}

/* The set W with more functions and more variables. */
static void extend(const struct search *s, struct points_space *space, int *variable, expr_id *con, double *near, int *end, int *stages)
{
    const struct sys_system *k = &s->f->kinematics;
    int c = s->f->W.constraints;
    for (int i = 0; i < 2 * s->n; i++)
        variable[i] = k->variable[i].symbol;
    for (int i = 0; i < c; i++)
        con[i] = s->f->W.constraint[i].expr;
    if (s->options->near)
        memcpy(near, s->options->near, (size_t)(2 * s->n) * sizeof *near);
    *stages = sga_stages(&s->f->W, end);
    *space = (struct points_space){
        .st = s->st, .variable = variable, .variables = 2 * s->n, .parameter = k->parameter, .parameters = k->parameters,
        .time = k->time, .constraint = con, .constraints = c, .near = s->options->near ? near : NULL,
        .near_time = s->options->near_time, .budget = s->options->budget,
    };
}

static void search_factors(struct search *s)
{
    int c = s->f->W.constraints, stages;
    int *variable = sga_calloc((size_t)(2 * s->n) + 1, sizeof *variable);
    int *end = sga_calloc((size_t)s->f->W.generations + 2, sizeof *end);
    expr_id *con = sga_calloc((size_t)c + 2, sizeof *con);
    double *near = sga_calloc((size_t)(2 * s->n) + 1, sizeof *near);
    struct points_space space;
    uint64_t random = 7;
    extend(s, &space, variable, con, near, end, &stages);
    if (c < 2 * s->n)
        for (int k = 0; k < s->factors && k < FACTORS_AT_MOST; k++) {
            con[c] = s->factor[k];
            space.constraints = end[stages] = c + 1;
            if (drops_on(s, &space, space.near ? 0.2 : 1, &random, end, stages + 1)) {
                s->r->where = sga_realloc(s->r->where, (size_t)(s->r->wheres + 1) * sizeof *s->r->where);
                s->r->where[s->r->wheres++] = s->factor[k];
            }
        }
    free(variable);
    free(end);
    free(con);
    free(near);
}

/* c_1, ..., c_m under names that no request can have. */
static int add_unit(struct search *s, int i)
{
    char name[32];
    snprintf(name, sizeof name, "%d*", i + 1);
    expr_symbol_add(s->st, name, EXPR_VARIABLE);
    return expr_symbol_find(s->st, name, strlen(name));
}

static void search_kernels(struct search *s)
{
    struct expr_store *st = s->st;
    int n = s->n, m = s->m, c = s->f->W.constraints, stages, added = 0;
    int *variable = sga_calloc((size_t)(2 * n + m) + 1, sizeof *variable);
    int *end = sga_calloc((size_t)s->f->W.generations + 2, sizeof *end);
    expr_id *con = sga_calloc((size_t)(c + n) + 2, sizeof *con), norm = expr_int(st, -1);
    double *near = sga_calloc((size_t)(2 * n + m) + 1, sizeof *near);
    struct points_space space;
    uint64_t random = 11;
    extend(s, &space, variable, con, near, end, &stages);
    for (int i = 0; i < m; i++) {
        variable[2 * n + i] = add_unit(s, i);
        norm = expr_add(st, norm, expr_powi(st, st->symbol[variable[2 * n + i]].node, 2));
    }
    for (int j = 0; j < n; j++) {
        expr_id sum = expr_int(st, 0);
        for (int i = 0; i < m; i++)
            sum = expr_add(st, sum, expr_mul(st, st->symbol[variable[2 * n + i]].node, entry(s, i, j)));
        if (!expr_is_zero(st, sum))
            con[c + added++] = sum;
    }
    con[c + added++] = norm;
    space.variables = 2 * n + m;
    space.constraints = end[stages] = c + added;
    bool found = space.constraints > space.variables;      /* nothing to look for: W itself is points */
    for (int k = 0; k < STARTS && !found; k++) {
        if (k >= STARTS / 2)
            space.near = NULL;
        found = drops_on(s, &space, space.near ? 0.2 * (k + 1) : 1 + k, &random, end, stages + 1);
    }
    free(variable);
    free(end);
    free(con);
    free(near);
}

void mech_regularity_find(struct mech_regularity *r, struct mech_fibre *f, const struct form_mechanical *in,
                          const struct sga_options *options)
{
    struct search s = { .r = r, .f = f, .in = in, .options = options, .st = f->kinematics.store, .all_never_zero = true,
                        .n = in->coordinates, .m = f->conditions };
    *r = (struct mech_regularity){ .full = MECH_FULL_PROVED };
    if (!s.m)
        return;
    expr_facts_init(&s.facts);
    for (int q = 0; q < f->W.pivots; q++)
        factors_of(&s, f->W.pivot[q].value);
    if (!proved_full(&s)) {
        r->full = MECH_FULL_SEARCHED;
        search_factors(&s);
        if (!r->point)
            search_kernels(&s);
    }
    expr_facts_clear(&s.facts);
    free(s.factor);
}

void mech_regularity_clear(struct mech_regularity *r)
{
    free(r->point);
    free(r->where);
    *r = (struct mech_regularity){ 0 };
}
