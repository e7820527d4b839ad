/* All symmetries among the combinations of given functions times d/dx_i (and d/dt): the
 * determining equations are linear in the coefficients. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "derive.h"
#include "error.h"
#include "mem.h"
#include "modp.h"
#include "reduction.h"
#include "sym_work.h"
#include "system.h"

enum { MOST_UNKNOWNS = 1200, MOST_VARIABLES = 200 };

/* Everything that the equations ask for, as nodes. */
struct determining {
    struct sga_arena mem;
    struct sym_work *w;
    struct sym_ansatz a;
    int m, cols;               /* components; functions times components */
    expr_id *node; int nodes;
    expr_id *tangent;          /* constraints x (n + 1): differentials */
    expr_id *field;            /* (gauges + 1) x n x (n + 1): d Y^a / d x_b, X0 first */
    mp_limb_t *v;              /* n rows of cols, work */
};

static mp_limb_t at(const struct num_modp *m, expr_id e)
{
    return num_modp_value(m, e);
}

static const expr_id *vector(const struct determining *d, int y)
{
    return y ? d->w->gauge + (size_t)(y - 1) * (size_t)(d->w->n + 1) : d->w->field;
}

static void tangent_rows(struct determining *d, struct num_modp *m, struct sym_space *s)
{
    for (int i = 0; i < d->w->sol->constraints; i++) {
        for (int f = 0; f < d->a.count; f++)
            for (int c = 0; c < d->m; c++)
                d->v[f * d->m + c] = nmod_mul(at(m, d->a.f[f]), at(m, d->tangent[i * (d->w->n + 1) + c]), m->mod);
        sym_space_insert(s, d->v);
    }
}

/* rows a of v become v^a - sum_j v^{free_j} K_j^a, and go to s where a is not free */
static void modulo_gauge(struct determining *d, struct num_modp *m, struct sym_space *s)
{
    struct sym_work *w = d->w;
    size_t cols = (size_t)d->cols;
    for (int k = 0; k < w->gauges; k++) {
        const expr_id *K = w->gauge + (size_t)k * (size_t)(w->n + 1);
        const mp_limb_t *part = d->v + (size_t)w->sol->free_column[k] * cols;
        for (int a = 0; a < w->n; a++)
            if (!w->is_free[a] && at(m, K[a]))
                _nmod_vec_scalar_addmul_nmod(d->v + (size_t)a * cols, part, d->cols, nmod_neg(at(m, K[a]), m->mod), m->mod);
    }
    for (int a = 0; a < w->n; a++)
        if (!w->is_free[a])
            sym_space_insert(s, d->v + (size_t)a * cols);
}

/* The bracket with Y: f dY^a/dx_c - delta_ac Y(f), and Y(f) X0^a for the time component. */
static void bracket_rows(struct determining *d, struct num_modp *m, struct sym_space *s, int y)
{
    struct sym_work *w = d->w;
    int n = w->n;
    const expr_id *Y = vector(d, y), *dY = d->field + (size_t)y * (size_t)n * (size_t)(n + 1);
    for (int f = 0; f < d->a.count; f++) {
        mp_limb_t along = 0, value = at(m, d->a.f[f]);
        for (int b = 0; b <= n; b++)
            along = nmod_add(along, nmod_mul(at(m, Y[b]), at(m, d->a.d[f * (n + 1) + b]), m->mod), m->mod);
        for (int a = 0; a < n; a++)
            for (int c = 0; c < d->m; c++) {
                mp_limb_t e = nmod_mul(value, at(m, dY[a * (n + 1) + c]), m->mod);
                if (c == a)
                    e = nmod_sub(e, along, m->mod);
                if (c == n)
                    e = nmod_add(e, nmod_mul(along, at(m, w->field[a]), m->mod), m->mod);
                d->v[(size_t)a * (size_t)d->cols + (size_t)(f * d->m + c)] = e;
            }
    }
    modulo_gauge(d, m, s);
}

static void component_row(struct determining *d, struct num_modp *m, int c, mp_limb_t *row)
{
    memset(row, 0, (size_t)d->cols * sizeof *row);
    for (int f = 0; f < d->a.count; f++)
        row[f * d->m + c] = at(m, d->a.f[f]);
}

static void rows(void *ctx, struct num_modp *m, struct sym_spaces *s)
{
    struct determining *d = ctx;
    int n = d->w->n;
    tangent_rows(d, m, &s->equation);
    for (int y = 0; y <= d->w->gauges; y++)
        bracket_rows(d, m, &s->equation, y);
    for (int c = 0; c < d->m; c++) {       /* the field vanishes on Pf */
        component_row(d, m, c, d->v);
        sym_space_insert(&s->trivial, d->v);
    }
    if (!d->w->gauges)
        return;
    for (int c = 0; c < n; c++)            /* the field lies in K on Pf */
        component_row(d, m, c, d->v + (size_t)c * (size_t)d->cols);
    modulo_gauge(d, m, &s->gauge);
    if (d->m > n) {
        component_row(d, m, n, d->v);
        sym_space_insert(&s->gauge, d->v);
    }
}

/* By unknown: what its field d/dx_c times f does to the constraints, X0 and the gauge fields. */
static bool table(void *ctx, int most, struct sym_table *t)
{
    struct determining *d = ctx;
    struct sym_work *w = d->w;
    size_t n = (size_t)w->n, cols = (size_t)d->cols;
    t->equations = w->sol->constraints + (w->gauges + 1) * w->n;
    t->trivials = d->m;
    t->gauges = w->gauges ? d->m : 0;
    if ((double)(t->equations + t->trivials + t->gauges) * (double)cols > most)
        return false;
    SGA_ARENA(mem);
    expr_id zero = expr_int(w->st, 0), *D = sga_take(&mem, (n + 1) * sizeof *D), *v = sga_take(&mem, (n + 1) * sizeof *v);
    t->equation = sga_malloc(((size_t)t->equations * cols + 1) * sizeof *t->equation);
    t->trivial = sga_malloc(((size_t)t->trivials * cols + 1) * sizeof *t->trivial);
    t->gauge = sga_malloc(((size_t)t->gauges * cols + 1) * sizeof *t->gauge);
    for (size_t k = 0; k < cols; k++) {
        size_t row = 0;
        for (size_t a = 0; a <= n; a++)
            D[a] = zero;
        D[k % (size_t)d->m] = d->a.f[k / (size_t)d->m];
        for (int i = 0; i < w->sol->constraints; i++)
            t->equation[row++ * cols + k] = sym_derive(w, D, w->constraint[i]);
        for (int y = 0; y <= w->gauges; y++) {
            sym_bracket(w, D, vector(d, y), v);
            sym_modulo_gauge(w, w->gauge, v);
            for (size_t a = 0; a < n; a++)
                t->equation[row++ * cols + k] = v[a];
        }
        for (size_t a = 0; a < (size_t)d->m; a++)
            t->trivial[a * cols + k] = D[a];
        if (t->gauges)
            sym_modulo_gauge(w, w->gauge, D);
        for (size_t a = 0; a < (size_t)t->gauges; a++)
            t->gauge[a * cols + k] = D[a];
    }
    return true;
}

static void add_node(struct determining *d, expr_id e)
{
    d->node[d->nodes++] = e;
}

/* The derivatives as nodes, and the list of all that is asked for. */
static void prepare(struct determining *d)
{
    struct sym_work *w = d->w;
    size_t n = (size_t)w->n, c = (size_t)w->sol->constraints, g = (size_t)w->gauges + 1, f = (size_t)d->a.count;
    d->tangent = sga_take(&d->mem, (c * (n + 1) + 1) * sizeof *d->tangent);
    d->field = sga_take(&d->mem, (g * n * (n + 1) + 1) * sizeof *d->field);
    d->node = sga_take(&d->mem, (c * (n + 1) + g * (n + 1) * (n + 1) + f * (n + 2) + 1) * sizeof *d->node);
    d->v = sga_take(&d->mem, (n + 1) * (size_t)d->cols * sizeof *d->v);
    for (size_t b = 0; b <= n; b++) {
        int symbol = b < n ? w->variable[b] : w->sys->time;
        for (size_t i = 0; i < c; i++)
            add_node(d, d->tangent[i * (n + 1) + b] = expr_diff(w->st, w->constraint[i], symbol));
        for (size_t y = 0; y < g; y++)
            for (size_t a = 0; a < n; a++)
                add_node(d, d->field[(y * n + a) * (n + 1) + b] = expr_diff(w->st, vector(d, (int)y)[a], symbol));
    }
    for (size_t y = 0; y < g; y++)
        for (size_t a = 0; a <= n; a++)
            add_node(d, vector(d, (int)y)[a]);
    for (size_t k = 0; k < f * (n + 1); k++)
        add_node(d, d->a.d[k]);
    for (size_t k = 0; k < f; k++)
        add_node(d, d->a.f[k]);
}

/* D - theta X0 in K. */
static enum sym_truth along_motion(struct sym_work *w, const expr_id *D)
{
    size_t n = (size_t)w->n;
    expr_id defect;
    SGA_FREED expr_id *v = sga_malloc((n + 1) * sizeof *v);
    for (size_t a = 0; a < n; a++)
        v[a] = expr_sub(w->st, D[a], expr_mul(w->st, D[n], w->field[a]));
    sym_modulo_gauge(w, w->gauge, v);
    return sym_all_zero(w, v, w->n, &defect);
}

/* A candidate becomes a field of the result where the check confirms it. */
static void confirm(struct determining *d, const struct sym_solutions *s, int k, struct sym_result *out)
{
    struct sym_work *w = d->w;
    struct sym_check check;
    expr_id *D = sga_malloc(((size_t)w->n + 1) * sizeof *D);
    for (int c = 0; c <= w->n; c++) {
        D[c] = expr_int(w->st, 0);
        for (int f = 0; f < d->a.count && c < d->m; f++) {
            const fmpq *q = s->value + (slong)k * s->cols + f * d->m + c;
            if (!fmpq_is_zero(q))
                D[c] = expr_add(w->st, D[c], expr_mul(w->st, expr_fmpq(w->st, q), d->a.f[f]));
        }
    }
    sym_check_field(w, D, &check);
    bool gauge = k < s->distinguished;
    if (check.symmetry != SYM_TRUE || check.gauge != (gauge ? SYM_TRUE : SYM_FALSE)) {
        out->of_fields.dropped++;
        free(D);
        return;
    }
    out->field[out->fields++] = (struct sym_field){ D, gauge, along_motion(w, D) };
}

bool sym_search_fields(struct sym_work *w, const struct sym_search *s, struct sym_result *out, struct sga_error *err)
{
    struct determining d = { .w = w, .m = w->n + s->time };
    struct sym_solutions found;
    if (w->n > MOST_VARIABLES)
        return sga_fail_at(err, SGA_E_LIMIT_VARIABLES, "/symmetries/search", "the system has %d variables; symmetries are searched for "
                           "up to %d", w->n, MOST_VARIABLES);
    if (!sym_ansatz_init(w, s, s->degree, MOST_UNKNOWNS / d.m, &d.a))
        return sga_fail_at(err, SGA_E_LIMIT_VARIABLES, "/symmetries/search", "fields of degree %d with %d components have more "
                           "than %d unknown coefficients; search a smaller degree", s->degree, d.m, MOST_UNKNOWNS);
    d.cols = d.a.count * d.m;
    prepare(&d);
    struct sym_problem p = { .cols = d.cols, .split = w->gauges > 0, .node = d.node, .nodes = d.nodes, .rows = rows, .table = table, .ctx = &d };
    bool ok = expr_store_ok(w->st) && sym_solve(w, &p, &found, &out->of_fields, err);
    if (ok) {
        out->field = sga_calloc((size_t)found.count + 1, sizeof *out->field);
        for (int k = 0; k < found.count && (ok = sga_budget_ok(w->budget, err)); k++)
            confirm(&d, &found, k, out);
        sym_solutions_clear(&found);
    }
    sym_ansatz_clear(&d.a);
    sga_arena_end(&d.mem);
    return ok;
}
