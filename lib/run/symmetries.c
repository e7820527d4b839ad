/* Symmetries of the answer: what the request asks to check and to search. */
#include "answer.h"

#include <stdlib.h>
#include <string.h>

#include "derive.h"
#include "mem.h"

/* T is a tensor where the rows of A belong to the variables in their order. */
static bool is_tensor(const struct job *j)
{
    static const char *const form[] = { "quasilinear", "linear", "hamiltonian" };
    for (size_t k = 0; k < sizeof form / sizeof *form; k++)
        if (strcmp(j->request.form, form[k]) == 0)
            return j->request.system.rows == j->request.system.variables;
    return false;
}

static bool check_all(struct job *j)
{
    const struct request_symmetries *s = &j->request.symmetries;
    j->symmetries.check = sga_calloc((size_t)s->checks + 1, sizeof *j->symmetries.check);
    for (int k = 0; k < s->checks; k++) {
        if (s->check[k].is_map)
            sym_check_map(j->symmetries.work, s->check[k].component, j->symmetries.check + k);
        else
            sym_check_field(j->symmetries.work, s->check[k].component, j->symmetries.check + k);
        if (!sga_budget_ok(&j->budget, j->err))
            return false;
    }
    return true;
}

/* omega_L = sum dq^i ^ d(dL/dv^i) as a dense matrix; NULL where there is no Lagrangian. */
static expr_id *lagrangian_form(struct job *j)
{
    enum { MOST = 60 };
    struct expr_store *st = &j->request.store;
    const struct sys_variable *x = j->request.system.variable;
    int n = j->request.system.variables, k = j->request.coordinates;
    if (j->request.lagrangian == EXPR_UNDEF || n > MOST)
        return NULL;
    expr_id *T = sga_malloc((size_t)(n * n) * sizeof *T), zero = expr_int(st, 0);
    for (int i = 0; i < n * n; i++)
        T[i] = zero;
    for (int i = 0; i < k; i++) {
        expr_id momentum = expr_diff(st, j->request.lagrangian, x[k + i].symbol);
        for (int a = 0; a < 2 * k; a++) {
            expr_id d = expr_diff(st, momentum, x[a].symbol);
            T[i * n + a] = expr_add(st, T[i * n + a], d);
            T[a * n + i] = expr_sub(st, T[a * n + i], d);
        }
    }
    return T;
}

bool answer_symmetries(struct job *j)
{
    const struct request_symmetries *s = &j->request.symmetries;
    if (!(j->request.want & REQUEST_SYMMETRIES) || j->solution.verdict == SGA_INCONSISTENT || j->request.op.open_sources)
        return true;
    double start = sga_now();
    struct sym_request request = {
        .tensor = is_tensor(j), .has_search = s->has_search,
        .search = { .degree = s->degree, .integral_degree = s->integral_degree,
                    .time = s->says_time ? s->time : j->solution.depends_on_time,
                    .function = s->function, .functions = s->functions },
    };
    expr_id *form = lagrangian_form(j);
    request.form = form;
    j->symmetries.time = request.search.time;
    j->symmetries.work = sym_new(&j->request.system, &j->solution, &j->shadow, &j->budget, request.tensor);
    bool ok = check_all(j) && sym_find(j->symmetries.work, &request, &j->symmetries.found, j->err);
    free(form);
    if (ok && !expr_store_ok(&j->request.store)) {
        *j->err = j->request.store.error;
        ok = false;
    }
    j->symmetries.has = ok;
    j->seconds.symmetries = sga_now() - start;
    return ok;
}

void answer_symmetries_clear(struct job *j)
{
    sym_clear(&j->symmetries.found);
    sym_free(j->symmetries.work);
    free(j->symmetries.check);
}
