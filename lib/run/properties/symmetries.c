/* Symmetries of the answer: what the request asks to check and to search. */
#include "run_job.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "error.h"
#include "form.h"
#include "job_symmetries.h"
#include "mem.h"
#include "oracle.h"
#include "properties.h"
#include "reduction.h"
#include "request.h"
#include "stage_clock.h"
#include "sym.h"
#include "system.h"
#include "warnings.h"

/* T is a tensor where the rows of A belong to the variables in their order. */
static bool is_tensor(const struct job *j)
{
    static const char *const form[] = { "quasilinear", "linear", "hamiltonian" };
    for (size_t k = 0; k < sizeof form / sizeof *form; k++)
        if (strcmp(j->request->form, form[k]) == 0)
            return j->request->system.rows == j->request->system.variables;
    return false;
}

static bool check_all(struct job *j)
{
    const struct request_symmetries *s = &j->request->symmetries;
    j->symmetries->check = sga_zeros(&j->mem, (size_t)s->checks + 1, sizeof *j->symmetries->check);
    for (int k = 0; k < s->checks; k++) {
        if (s->check[k].is_map)
            sym_check_map(j->symmetries->work, s->check[k].component, j->symmetries->check + k);
        else
            sym_check_field(j->symmetries->work, s->check[k].component, j->symmetries->check + k);
        if (!job_goes_on(j))
            return false;
    }
    return true;
}

enum { MOST_DENSE = SGA_MOST_TENSOR };

/* omega_L = sum dq^i ^ d(dL/dv^i) as a dense matrix. */
static void lagrangian_form(struct job *j, expr_id *T)
{
    struct expr_store *st = &j->request->store;
    const struct sys_variable *x = j->request->system.variable;
    int n = j->request->system.variables, k = j->request->coordinates;
    for (int i = 0; i < k; i++) {
        expr_id momentum = expr_diff(st, j->request->lagrangian, x[k + i].symbol);
        for (int a = 0; a < 2 * k; a++) {
            expr_id d = expr_diff(st, momentum, x[a].symbol);
            T[i * n + a] = expr_add(st, T[i * n + a], d);
            T[a * n + i] = expr_sub(st, T[a * n + i], d);
        }
    }
}

/* T = Omega^T of the form hamiltonian before it is pulled back. */
static void hamiltonian_form(struct job *j, expr_id *T)
{
    struct expr_store *st = &j->request->store;
    const struct form_hamiltonian *h = j->request->hamiltonian;
    int n = j->request->system.variables;
    assert(h->omega || n % 2 == 0);       /* pairs of coordinate and momentum */
    for (int i = 0; i < n / 2 && !h->omega; i++) {
        T[(i + n / 2) * n + i] = expr_int(st, 1);
        T[i * n + i + n / 2] = expr_int(st, -1);
    }
    for (size_t k = 0; h->omega && k < h->omega->entries; k++) {
        const struct form_entry *e = h->omega->entry + k;
        T[e->col * n + e->row] = expr_add(st, T[e->col * n + e->row], e->value);
    }
}

/* The 2-form where it is closed and not A itself; NULL: there is none, or n is too large. */
static expr_id *two_form(struct job *j)
{
    int n = j->request->system.variables;
    bool lagrangian = j->request->lagrangian != EXPR_UNDEF, closed = !j->two_form.checked || j->two_form.closed == 1;
    if (!(lagrangian || (j->primary && closed)))
        return NULL;
    if (n > MOST_DENSE) {
        sga_limit_met(j->budget, SGA_LIMIT_TENSOR);
        return NULL;
    }
    expr_id *T = sga_malloc((size_t)(n * n) * sizeof *T), zero = expr_int(&j->request->store, 0);
    for (int i = 0; i < n * n; i++)
        T[i] = zero;
    if (lagrangian)
        lagrangian_form(j, T);
    else
        hamiltonian_form(j, T);
    return T;
}

static bool vanishes(void *ctx, expr_id e)
{
    return points_oracle_zero(ctx, e).truth == POINTS_ZERO;
}

/* Vectors tangent to Pf, which 2-forms are pulled back along; NULL without constraints. */
static expr_id *tangent_vectors(struct job *j, int *count)
{
    struct expr_store *st = &j->request->store;
    int n = j->request->system.variables, c = j->solution->constraints;
    if (!c || n > MOST_DENSE || !j->oracle->reals)     /* larger ones: two_form() has said so */
        return NULL;
    struct form_zero zero = { vanishes, j->oracle };
    SGA_ARENA(mem);
    expr_id *jacobian = sga_take(&mem, (size_t)(c * n) * sizeof *jacobian);
    for (int i = 0; i < c * n; i++)
        jacobian[i] = expr_diff(st, j->solution->constraint[i / n].expr, j->request->system.variable[i % n].symbol);
    expr_id *vector = form_kernel(st, jacobian, c, n, &zero, count);
    return vector;
}

bool answer_symmetries(struct job *j)
{
    const struct request_symmetries *s = &j->request->symmetries;
    j->symmetries = sga_zeros(&j->mem, 1, sizeof *j->symmetries);      /* empty where nothing can be said */
    if (!(j->request->want & REQUEST_SYMMETRIES) || j->solution->verdict == SGA_INCONSISTENT || j->request->op.open_sources)
        return true;
    stage_begin(j->clock, STAGE_SYMMETRIES);
    struct sym_request request = {
        .tensor = is_tensor(j), .has_search = s->has_search,
        .search = { .degree = s->degree, .integral_degree = s->integral_degree,
                    .time = s->says_time ? s->time : j->solution->depends_on_time,
                    .function = s->function, .functions = s->functions },
    };
    expr_id *form = two_form(j), *vector = NULL;
    request.form = form;
    if (s->has_search && (form || request.tensor))
        request.vector = vector = tangent_vectors(j, &request.vectors);
    assert(!request.vectors || request.vector);
    j->symmetries->time = request.search.time;
    j->symmetries->work = sym_new(&j->request->system, j->solution, j->oracle, j->budget, request.tensor);
    bool ok = check_all(j) && sym_find(j->symmetries->work, &request, &j->symmetries->found, j->err);
    free(form);
    free(vector);
    if (ok && !expr_store_ok(&j->request->store)) {
        *j->err = *j->request->store.error;
        ok = false;
    }
    j->symmetries->has = ok;
    return ok;
}

void answer_symmetries_clear(struct job *j)
{
    if (!j->symmetries)
        return;
    sym_clear(&j->symmetries->found);
    sym_free(j->symmetries->work);
    j->symmetries = NULL;
}
