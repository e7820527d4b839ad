/* The linear equations of a search at real points of Pf, where none modulo a prime were found.
 *
 * The rows are kept in echelon form to PRECISION bits, and their entries guessed as rational numbers: what is a
 * space of rational equations has rational entries there. The guess goes on modulo a prime as the sampled rows would, and
 * what comes out is checked like every other candidate. */
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "budget.h"
#include "flint_ends.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "reduction.h"
#include "seeds.h"
#include "sym_work.h"

enum { PRECISION = 384, GOOD = 200, ZERO = 100, STEADY = 3, FAILURES = 20, MOST_BITS = 40, MOST_ENTRIES = 60000 };

/* Rows by pivot column: 1 there, 0 before. */
struct echelon {
    int cols, rank;
    arb_ptr *row;
};

static void echelon_init(struct echelon *e, int cols)
{
    *e = (struct echelon){ .cols = cols, .row = sga_calloc((size_t)cols + 1, sizeof *e->row) };
}

static void echelon_clear(struct echelon *e)
{
    for (int j = 0; j < e->cols; j++)
        if (e->row[j])
            _arb_vec_clear(e->row[j], e->cols);
    free(e->row);
}

static bool tiny(const arb_t x)
{
    return arf_cmpabs_2exp_si(arb_midref(x), -ZERO) < 0;
}

/* v -= v[j] row_j; radii are dropped: what they would say is not used. */
static void subtract(const struct echelon *e, arb_ptr v, int j)
{
    SGA_ENDS(arb_end) arb_t f = { 0 };
    arb_set(f, v + j);
    for (int k = j; k < e->cols; k++) {
        arb_submul(v + k, f, e->row[j] + k, PRECISION);
        mag_zero(arb_radref(v + k));
    }
    arb_zero(v + j);
}

/* Takes v (of largest entry 1) where it is independent. */
static void insert(struct echelon *e, arb_ptr v)
{
    for (int j = 0; j < e->cols; j++) {
        if (tiny(v + j)) {
            arb_zero(v + j);
            continue;
        }
        if (e->row[j]) {
            subtract(e, v, j);
            continue;
        }
        e->row[j] = _arb_vec_init(e->cols);
        for (int k = j; k < e->cols; k++) {
            arb_div(e->row[j] + k, v + k, v + j, PRECISION);
            mag_zero(arb_radref(e->row[j] + k));
        }
        e->rank++;
        return;
    }
}

static void finish(struct echelon *e)
{
    for (int j = e->cols - 1; j >= 0; j--)
        for (int k = j + 1; k < e->cols && e->row[j]; k++)
            if (e->row[k] && !tiny(e->row[j] + k))
                subtract(e, e->row[j], k);
}

/* The simplest fraction that near, where it is simple. */
static bool rational(fmpq_t q, const arb_t x)
{
    SGA_ENDS(fmpq_end) fmpq_t low = { { 0, 1 } }, high = { { 0, 1 } }, eps = { { 0, 1 } };
    fmpq_set_si(eps, 1, 1);
    fmpq_div_2exp(eps, eps, ZERO);
    arf_get_fmpq(low, arb_midref(x));
    fmpq_add(high, low, eps);
    fmpq_sub(low, low, eps);
    fmpq_simplest_between(q, low, high);
    return fmpz_bits(fmpq_numref(q)) + fmpz_bits(fmpq_denref(q)) <= MOST_BITS;
}

/* The rows modulo the prime of s. */
static bool reduce(const struct echelon *e, struct sym_space *s)
{
    SGA_FREED mp_limb_t *v = sga_malloc(((size_t)e->cols + 1) * sizeof *v);
    SGA_ENDS(fmpq_end) fmpq_t q = { { 0, 1 } };
    bool ok = true;
    for (int j = 0; j < e->cols && ok; j++) {
        for (int k = 0; k < e->cols && e->row[j] && ok; k++) {
            ok = rational(q, e->row[j] + k);
            if (ok)
                v[k] = nmod_div(fmpz_fdiv_ui(fmpq_numref(q), s->mod.n), fmpz_fdiv_ui(fmpq_denref(q), s->mod.n), s->mod);
        }
        if (e->row[j] && ok)
            sym_space_insert(s, v);
    }
    return ok;
}

/* One row of values, less those of another row, scaled; false where one is not known well enough. */
static bool values(struct num_ball *ball, const expr_id *e, arb_srcptr less, int cols, arb_ptr v)
{
    slong largest = -ARF_PREC_EXACT;
    for (int k = 0; k < cols; k++) {
        arb_srcptr x = num_ball_value(ball, e[k]);
        if (!arb_is_finite(x) || mag_cmp_2exp_si(arb_radref(x), -GOOD) > 0)
            return false;
        arb_set(v + k, x);
        mag_zero(arb_radref(v + k));
        if (less)
            arb_sub(v + k, v + k, less + k, PRECISION);
        if (!tiny(v + k) && fmpz_get_si(ARF_EXPREF(arb_midref(v + k))) > largest)
            largest = fmpz_get_si(ARF_EXPREF(arb_midref(v + k)));
    }
    for (int k = 0; k < cols && largest > -ARF_PREC_EXACT; k++)
        arb_mul_2exp_si(v + k, v + k, -largest);
    return true;
}

struct real {
    const struct sym_table *t;
    int cols;
    struct echelon equation, trivial, gauge;
    arb_ptr v, first;
    int points;
};

static bool add_rows(struct real *r, struct num_ball *ball, const expr_id *e, int rows, struct echelon *to, arb_srcptr less)
{
    for (int i = 0; i < rows; i++) {
        if (!values(ball, e + (size_t)i * (size_t)r->cols, less, r->cols, r->v))
            return false;
        insert(to, r->v);
    }
    return true;
}

static bool add_point(struct real *r, struct num_ball *ball)
{
    num_ball_extend(ball);
    if (!r->points && r->t->differences && !values(ball, r->t->trivial, NULL, r->cols, r->first))
        return false;
    if (!r->points)              /* values() scales: the first point's are wanted as they are */
        for (int k = 0; k < r->cols && r->t->differences; k++)
            arb_set(r->first + k, num_ball_value(ball, r->t->trivial[k]));
    bool ok = add_rows(r, ball, r->t->equation, r->t->equations, &r->equation, NULL)
           && add_rows(r, ball, r->t->trivial, r->t->trivials, &r->trivial, r->t->differences ? r->first : NULL)
           && add_rows(r, ball, r->t->gauge, r->t->gauges, &r->gauge, NULL);
    r->points += ok;
    return ok;
}

/* Points until the ranks stay. False where the budget ends. */
static bool sample(struct sym_work *w, struct real *r, bool *enough, struct sga_error *err)
{
    uint64_t random = SGA_SEED_SYM_REAL;
    int steady = 0, failures = 0;
    SGA_FREED int *end = sga_calloc((size_t)w->sol->generations + 2, sizeof *end);
    int stages = sga_stages(w->sol, w->sol->constraints, end);
    struct points_space space = w->oracle->space;
    while (steady < STEADY && failures < FAILURES) {
        int before = r->equation.rank + r->trivial.rank + r->gauge.rank;
        SGA_ENDS(points_point_clear) struct points_point p = { 0 };
        if (!sga_budget_ok(w->budget, err))
            return false;
        enum points_status status = points_find_staged(&space, end, stages, space.near ? 0.3 : 1, &random, PRECISION, &p);
        if (status == POINTS_OK && p.certified && add_point(r, &p.ball))
            steady = r->equation.rank + r->trivial.rank + r->gauge.rank == before ? steady + 1 : 0;
        else
            failures++;
    }
    *enough = steady >= STEADY;
    return true;
}

bool sym_real_spaces(struct sym_work *w, const struct sym_problem *p, struct sym_spaces *s, struct sym_evidence *evidence,
                     bool *enough, struct sga_error *err)
{
    SGA_ENDS(sym_table_clear) struct sym_table t = { 0 };
    struct real r = { .t = &t, .cols = p->cols };
    nmod_t mod;
    nmod_init(&mod, n_nextprime(UWORD(1) << 59, 1));
    *enough = false;
    *s = (struct sym_spaces){ 0 };
    if (!p->table || !p->table(p->ctx, MOST_ENTRIES, &t) || !expr_store_ok(w->st))
        return true;
    echelon_init(&r.equation, p->cols);
    echelon_init(&r.trivial, p->cols);
    echelon_init(&r.gauge, p->cols);
    r.v = _arb_vec_init(p->cols);
    r.first = _arb_vec_init(p->cols);
    bool ok = sample(w, &r, enough, err);
    if (ok && *enough) {
        sym_space_init(&s->equation, p->cols, mod);
        sym_space_init(&s->trivial, p->cols, mod);
        sym_space_init(&s->gauge, p->cols, mod);
        finish(&r.equation);
        finish(&r.trivial);
        finish(&r.gauge);
        *enough = reduce(&r.equation, &s->equation) && reduce(&r.trivial, &s->trivial) && reduce(&r.gauge, &s->gauge);
        evidence->irrational = !*enough;
        evidence->reals = s->points = r.points;
    }
    echelon_clear(&r.equation);
    echelon_clear(&r.trivial);
    echelon_clear(&r.gauge);
    _arb_vec_clear(r.v, p->cols);
    _arb_vec_clear(r.first, p->cols);
    return ok;
}

void sym_table_clear(struct sym_table *t)
{
    free(t->equation);
    free(t->trivial);
    free(t->gauge);
    *t = (struct sym_table){ 0 };
}
