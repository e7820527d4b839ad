/* [D_i, D_j] as combinations of the fields found, on Pf: coefficients from values modulo a
 * prime, each confirmed by the oracle. */
#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "modp.h"
#include "modpoint.h"
#include "seeds.h"
#include "warnings.h"
#include "sym_work.h"

enum { POINTS_AGAIN = 2, FAILURES = 40 };

/* Full bracket of two fields, time component too. */
static void bracket(struct sym_work *w, const expr_id *D, const expr_id *E, expr_id *out)
{
    for (int a = 0; a <= w->n; a++)
        out[a] = expr_sub(w->st, sym_derive(w, D, E[a]), sym_derive(w, E, D[a]));
}

/* One row for each component at each point: values of the fields, then of the brackets. */
static bool sample(struct sym_work *w, const struct sym_result *r, const expr_id *brackets, struct sym_space *s)
{
    uint64_t random = SGA_SEED_SYM_COMMUTATORS;
    int steady = 0, failures = 0, n = w->n + 1, cols = r->fields + r->commutators;
    SGA_FREED mp_limb_t *v = sga_malloc(((size_t)cols + 1) * sizeof *v);
    while (steady < POINTS_AGAIN && failures < FAILURES && sga_budget_ok(w->budget, NULL)) {
        struct points_modpoint at;
        if (!sym_modpoint(w, 0, &random, &at)) {
            failures++;
            continue;
        }
        num_modp_extend(at.value);
        if (!s->row)
            sym_space_init(s, cols, at.value->mod);
        int before = s->rank;
        bool bad = false;
        for (int a = 0; a < n && !bad; a++) {
            for (int k = 0; k < cols; k++) {
                expr_id e = k < r->fields ? r->field[k].component[a] : brackets[(k - r->fields) * n + a];
                bad |= num_modp_bad(at.value, e);
                v[k] = num_modp_value(at.value, e);
            }
            if (!bad)
                sym_space_insert(s, v);
        }
        failures += bad;
        steady = bad || s->rank != before ? 0 : steady + 1;
        points_modpoint_clear(&at);
    }
    return steady >= POINTS_AGAIN;
}

struct values {
    const struct sym_work *w;
    const struct sym_result *r;
    const expr_id *brackets;
};

static bool table(void *ctx, int most, struct sym_table *t)
{
    const struct values *v = ctx;
    int n = v->w->n + 1, cols = v->r->fields + v->r->commutators;
    t->equations = n;
    if ((double)n * (double)cols > most)
        return false;
    t->equation = sga_malloc((size_t)(n * cols) * sizeof *t->equation);
    for (int a = 0; a < n; a++)
        for (int k = 0; k < cols; k++)
            t->equation[a * cols + k] = k < v->r->fields ? v->r->field[k].component[a] : v->brackets[(k - v->r->fields) * n + a];
    return true;
}

/* The same rows from real points, where there are none modulo a prime. */
static bool sample_real(struct sym_work *w, const struct sym_result *r, const expr_id *brackets, struct sym_space *s)
{
    struct values v = { w, r, brackets };
    struct sym_problem p = { .cols = r->fields + r->commutators, .table = table, .ctx = &v };
    struct sym_spaces spaces;
    struct sym_evidence evidence = { 0 };
    struct sga_error err = { 0 };
    bool enough;
    sym_space_clear(s);
    if (!sym_real_spaces(w, &p, &spaces, &evidence, &enough, &err))
        return false;
    *s = spaces.equation;
    sym_space_clear(&spaces.trivial);
    sym_space_clear(&spaces.gauge);
    return enough;
}

static bool rational(mp_limb_t residue, mp_limb_t prime, fmpq_t q)
{
    SGA_ENDS(fmpz_end) fmpz_t a, m;
    fmpz_init_set_ui(a, residue);
    fmpz_init_set_ui(m, prime);
    return fmpq_reconstruct_fmpz(q, a, m);
}

/* The coefficients of pair c, where its column follows from the fields' columns. */
static void expand(struct sym_work *w, struct sym_result *r, const struct sym_space *s, int c, const expr_id *value)
{
    struct sym_commutator *p = r->commutator + c;
    int n = w->n + 1;
    SGA_ENDS(fmpq_end) fmpq_t q = { { 0, 1 } };
    p->factor = sga_malloc(((size_t)r->fields + 1) * sizeof *p->factor);
    p->closed = true;
    for (int k = 0; k < r->fields && p->closed; k++) {
        p->closed = s->row[k] && rational(s->row[k][r->fields + c], s->mod.n, q);
        p->factor[k] = expr_fmpq(w->st, q);
    }
    for (int a = 0; a < n && p->closed; a++) {
        expr_id rest = value[a];
        for (int k = 0; k < r->fields; k++)
            rest = expr_sub(w->st, rest, expr_mul(w->st, p->factor[k], r->field[k].component[a]));
        p->closed = sym_zero(w, rest) == SYM_TRUE;
    }
}

bool sym_commutators(struct sym_work *w, struct sym_result *r, struct sga_error *err)
{
    int m = r->fields, n = w->n + 1;
    if (m > SGA_MOST_COMMUTING)
        sga_limit_met(w->budget, SGA_LIMIT_COMMUTING);
    if (m < 2 || m > SGA_MOST_COMMUTING)
        return true;
    size_t pairs = (size_t)m * (size_t)(m - 1) / 2;
    SGA_ENDS(sym_space_clear) struct sym_space s = { 0 };
    SGA_FREED expr_id *value = sga_malloc(pairs * (size_t)n * sizeof *value);
    r->commutator = sga_calloc(pairs, sizeof *r->commutator);
    for (int i = 0; i < m; i++)
        for (int j = i + 1; j < m; j++) {
            bracket(w, r->field[i].component, r->field[j].component, value + r->commutators * n);
            r->commutator[r->commutators++] = (struct sym_commutator){ .left = i, .right = j };
        }
    if (expr_store_ok(w->st) && (r->of_fields.reals ? sample_real(w, r, value, &s) : sample(w, r, value, &s))) {
        sym_space_finish(&s);
        for (int c = 0; c < r->commutators && sga_budget_ok(w->budget, NULL); c++)
            expand(w, r, &s, c, value + c * n);
    }
    assert(r->commutators <= m * (m - 1) / 2);
    return sga_budget_ok(w->budget, err);
}
