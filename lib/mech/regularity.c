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
    bool simple;              /* M is positive definite, seen at once */
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

/* Positive numbers (parameters are taken as positive) on the diagonal: then M is positive definite, and only
 * H can fail. */
static bool masses_simple(struct search *s)
{
    bool simple = true;
    for (size_t k = 0; k < s->in->masses && simple; k++) {
        const struct form_entry *e = s->in->mass + k;
        unsigned flags = expr_facts_of(&s->facts, s->st, e->value);
        if (e->row != e->col)
            simple = expr_is_zero(s->st, e->value);
        else if (expr_is_const(s->st, e->value))
            simple = fmpq_sgn(expr_const_value(s->st, e->value)) > 0;
        else
            simple = expr_op_of(s->st, e->value) == EXPR_SYM && !(flags & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME));
    }
    return simple;
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

/* The pivots belong to the functions that the reduction took; an irregular one was replaced. */
static bool pivots_are_of_H(const struct search *s)
{
    bool plain = true;
    for (int i = 0; i < s->f->W.constraints; i++)
        plain = plain && !s->f->W.constraint[i].replaced;
    return plain || !s->f->own;
}

/* Where a condition has no derivative a proof by its differential says nothing. */
static bool has_kinks(const struct search *s)
{
    struct expr_cone cone;
    bool kinks = false;
    expr_cone_init(&cone);
    expr_cone_of(s->st, &cone, s->f->condition, s->m);
    for (int i = 0; i < cone.count && !kinks; i++) {
        enum expr_op op = expr_op_of(s->st, cone.list[i]);
        kinks = op == EXPR_ABS || op == EXPR_SIGN || op == EXPR_MIN || op == EXPR_MAX || op == EXPR_CBRT;
    }
    expr_cone_clear(&cone);
    return kinks;
}

static bool proved_full(struct search *s)
{
    struct poly_limits limits = limits_of(s);
    struct poly_factors f;
    bool full = true;
    if (!s->simple || s->f->W.branches || has_kinks(s))
        return false;
    if (s->all_never_zero && !s->f->W.dense_blocks && pivots_are_of_H(s))
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
        double b = arf_get_d(arb_midref(num_ball_value(ball, s->f->rate[i])), ARF_RND_NEAR);
        for (int j = 0; j < n; j++) {
            double v = arf_get_d(arb_midref(num_ball_value(ball, entry(s, i, j))), ARF_RND_NEAR);
            H[(size_t)i * (size_t)n + (size_t)j] = wide[(size_t)i * (size_t)(n + 1) + (size_t)j] = v;
        }
        wide[(size_t)i * (size_t)(n + 1) + (size_t)n] = -b;
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

/* M and H as one matrix, for its rank at a point: full is n + m. */
static int whole_rank_at(const struct search *s, struct num_ball *ball, double tolerance)
{
    int n = s->n, size = n + s->m;
    double *K = sga_calloc((size_t)size * (size_t)size + 1, sizeof *K);
    num_ball_extend(ball);
    for (size_t k = 0; k < s->in->masses; k++)
        K[(size_t)s->in->mass[k].row * (size_t)size + (size_t)s->in->mass[k].col]
            += arf_get_d(arb_midref(num_ball_value(ball, s->in->mass[k].value)), ARF_RND_NEAR);
    for (int i = 0; i < s->m; i++)
        for (int j = 0; j < n; j++)
            K[(size_t)(n + i) * (size_t)size + (size_t)j] = K[(size_t)j * (size_t)size + (size_t)(n + i)]
                = arf_get_d(arb_midref(num_ball_value(ball, entry(s, i, j))), ARF_RND_NEAR);
    int rank = rank_of(K, size, size, tolerance);
    free(K);
    return rank;
}

static double value_of(struct num_ball *ball, expr_id e)
{
    return fabs(arf_get_d(arb_midref(num_ball_value(ball, e)), ARF_RND_NEAR));
}

/* The symbols of a place that Newton's steps came near; false where it does not lie on the set,
 * each function being measured by the largest part that it is made of. */
static bool place(const struct search *s, const struct points_space *space, const struct points_point *p, struct num_ball *ball)
{
    bool on = true;
    num_ball_init(ball, s->st, BITS);
    for (int i = 0; i < space->variables; i++) {
        num_ball_set_d(ball, space->variable[i], p->x[i]);
        on = on && fabs(p->x[i]) < 1e6;
    }
    for (int i = 0; i < space->parameters; i++)
        num_ball_set_d(ball, space->parameter[i], p->parameter[i]);
    num_ball_set_d(ball, space->time, p->t);
    num_ball_extend(ball);
    struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < space->constraints && on; i++) {
        double size = 0;
        expr_cone_of(s->st, &cone, space->constraint + i, 1);
        for (int k = 0; k < cone.count; k++)
            size = fmax(size, value_of(ball, cone.list[k]));
        on = value_of(ball, space->constraint[i]) <= fmax(1e-8 * size, 1e-12);
    }
    expr_cone_clear(&cone);
    return on;
}

/* What is looked for on a set. */
enum aim { RANK_OF_H, RANK_OF_WHOLE, ANY_POINT };

/* Looks for a point of the set at which the rank is less than it should be. */
static bool drops_on(struct search *s, const struct points_space *space, double spread, uint64_t *random, const int *end, int stages,
                     enum aim aim)
{
    struct points_point p;
    enum points_status status = points_find_staged(space, end, stages, spread, random, BITS, &p);
    struct num_ball ball = { 0 }, *at = NULL;
    double tolerance = status == POINTS_OK ? 1e-10 : 1e-5;
    if (status == POINTS_OK) {
        num_ball_forget(&p.ball);
        at = &p.ball;
    } else if (status == POINTS_IRREGULAR && place(s, space, &p, &ball)) {
        at = &ball;
    }
    int rank = s->m, augmented = s->m;
    if (at)
        ranks_at(s, at, tolerance, &rank, &augmented);
    bool found = at && (rank < s->m || aim == ANY_POINT
                        || (aim == RANK_OF_WHOLE && whole_rank_at(s, at, tolerance) < s->n + s->m));
    bool certified = status == POINTS_OK && p.certified;
    if (found && (!s->r->point || (certified && !s->r->certified))) {
        free(s->r->point);
        keep_point(s, &p, certified, rank, augmented);
    }
    if (at == &ball || status == POINTS_IRREGULAR)
        num_ball_clear(&ball);
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
    int own = s->factors < FACTORS_AT_MOST ? s->factors : FACTORS_AT_MOST, all = own + s->f->W.branches;
    for (int k = 0; k < all && c < 2 * s->n; k++) {
        con[c] = k < own ? s->factor[k] : s->f->W.branch[k - own].expr;    /* W is no manifold where branches meet */
        space.constraints = end[stages] = c + 1;
        if (drops_on(s, &space, space.near ? 0.2 : 1, &random, end, stages + 1, k < own ? RANK_OF_H : ANY_POINT)) {
            s->r->where = sga_realloc(s->r->where, (size_t)(s->r->wheres + 1) * sizeof *s->r->where);
            s->r->where[s->r->wheres++] = con[c];
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

/* c^T H = 0; or, where the masses may fail too, M v = H^T c and H v = 0. The symbols of c
 * and v come last among the variables. Returns how many equations. */
static int kernel_equations(const struct search *s, const int *unit, expr_id *con)
{
    struct expr_store *st = s->st;
    int added = 0;
    for (int j = 0; j < s->n; j++) {
        expr_id sum = expr_int(st, 0);
        for (int i = 0; i < s->m; i++)
            sum = expr_sub(st, sum, expr_mul(st, st->symbol[unit[i]].node, entry(s, i, j)));
        for (size_t k = 0; k < s->in->masses && !s->simple; k++)
            if (s->in->mass[k].row == j)
                sum = expr_add(st, sum, expr_mul(st, s->in->mass[k].value, st->symbol[unit[s->m + s->in->mass[k].col]].node));
        if (!expr_is_zero(st, sum))
            con[added++] = sum;
    }
    for (int i = 0; i < s->m && !s->simple; i++) {
        con[added] = expr_int(st, 0);
        for (int j = 0; j < s->n; j++)
            con[added] = expr_add(st, con[added], expr_mul(st, entry(s, i, j), st->symbol[unit[s->m + j]].node));
        added++;
    }
    return added;
}

static void search_kernels(struct search *s)
{
    struct expr_store *st = s->st;
    int n = s->n, units = s->m + (s->simple ? 0 : n), c = s->f->W.constraints, stages;
    int *variable = sga_calloc((size_t)(2 * n + units) + 1, sizeof *variable);
    int *end = sga_calloc((size_t)s->f->W.generations + 2, sizeof *end);
    expr_id *con = sga_calloc((size_t)(c + n + s->m) + 2, sizeof *con), norm = expr_int(st, -1);
    double *near = sga_calloc((size_t)(2 * n + units) + 1, sizeof *near);
    struct points_space space;
    uint64_t random = 11;
    extend(s, &space, variable, con, near, end, &stages);
    for (int i = 0; i < units; i++) {
        variable[2 * n + i] = add_unit(s, i);
        norm = expr_add(st, norm, expr_powi(st, st->symbol[variable[2 * n + i]].node, 2));
    }
    int total = c + kernel_equations(s, variable + 2 * n, con + c);
    con[total++] = norm;
    space.variables = 2 * n + units;
    space.constraints = end[stages] = total;
    bool found = space.constraints > space.variables;      /* nothing to look for: W itself is points */
    for (int k = 0; k < STARTS && !found; k++) {
        if (k >= STARTS / 2)
            space.near = NULL;
        found = drops_on(s, &space, space.near ? 0.2 * (k + 1) : 1 + k, &random, end, stages + 1,
                         s->simple ? RANK_OF_H : RANK_OF_WHOLE);
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
    expr_facts_init(&s.facts);
    s.simple = masses_simple(&s);
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
