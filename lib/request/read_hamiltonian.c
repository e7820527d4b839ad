/* The form `hamiltonian`: the function, the 2-form (canonical if left out), restrictions. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "form.h"
#include "reader.h"

static bool check_antisymmetric(struct reader *rd, const struct read_matrix *m)
{
    struct form_matrix w = { .rows = m->rows, .cols = m->cols, .entry = m->entry, .entries = m->entries };
    size_t k = form_not_antisymmetric(&rd->r->store, &w);
    if (k == m->entries)
        return true;
    const struct form_entry *e = m->entry + k;
    at_member(rd, "omega");
    return at_fail(rd, SGA_E_SHAPE, "omega is not antisymmetric: its entries (%d, %d) and (%d, %d) do not add up to 0",
                   e->row, e->col, e->col, e->row);
}

/* Is `momentum` the usual name of that of `position`: p1 of q1, px or p_x of x? */
static bool named_after(const char *momentum, const char *position)
{
    if (*momentum != 'p')
        return false;
    return (*position == 'q' && strcmp(momentum + 1, position + 1) == 0) || strcmp(momentum + 1, position) == 0
           || (momentum[1] == '_' && strcmp(momentum + 2, position) == 0);
}

/* Places count, so names that say otherwise are most likely a mistake. */
static bool check_places(struct reader *rd, const int *variable, int n)
{
    enum { MOST = 400 };
    const struct expr_symbol *symbol = rd->r->store.symbol;
    for (int i = 0; i < n && n <= MOST; i++)
        for (int k = 0; k < n; k++) {
            const char *p = symbol[variable[k]].name, *q = symbol[variable[i]].name;
            if (k == i + n / 2 || !named_after(p, q))
                continue;
            at_member(rd, "variables");
            return at_fail(rd, SGA_E_SHAPE, "without omega the first half of the variables are positions, and the second half their momenta in "
                           "the same order: %.60s at place %d is not that of %.60s at place %d (from 0); order them so, rename them, or give omega",
                           p, k, q, i);
        }
    return true;
}

static bool read_two_form(struct reader *rd, const json_t *system, struct read_matrix *m, const int *variable, int n)
{
    m->rows = m->cols = n;
    if (json_object_get(system, "omega"))
        return read_matrix(rd, system, m) && check_antisymmetric(rd, m);
    if (n % 2 == 0)
        return check_places(rd, variable, n);
    at_member(rd, "variables");
    return at_fail(rd, SGA_E_SHAPE, "without omega the variables are q1, ..., qk, p1, ..., pk; there are %d", n);
}

static bool read_function(struct reader *rd, const json_t *system, expr_id *e)
{
    const json_t *v = need_member(rd, system, "hamiltonian");
    if (!v)
        return false;
    size_t mark = at_member(rd, "hamiltonian");
    *e = read_listed(rd, v, NULL);
    if (*e)
        at_back(rd, mark);
    return *e != EXPR_UNDEF;
}

/* The pull-back works on dense matrices of expressions. */
enum { MAX_DENSE = 1000000 };

static bool check_size(struct reader *rd, int variables, int restrictions)
{
    if (restrictions <= 0 || (long)variables * (variables + restrictions) <= MAX_DENSE)
        return true;
    at_member(rd, "restrict");
    return at_fail(rd, SGA_E_LIMIT_VARIABLES, "%d functions of %d variables: the limit of variables * (variables + functions) is %d",
                   restrictions, variables, MAX_DENSE);
}

/* What the form keeps. */
static struct form_hamiltonian *keep(struct sga_arena *mem, const struct form_hamiltonian *f, const struct form_matrix *omega)
{
    assert(f->variables > 0 && (!omega || (omega->rows == f->variables && omega->cols == f->variables)));
    struct form_hamiltonian *h = sga_take(mem, sizeof *h);
    *h = *f;
    if (omega) {
        struct form_matrix *m = sga_take(mem, sizeof *m);
        *m = *omega;
        m->entry = read_matrix_kept(mem, omega->entry, omega->entries);
        h->omega = m;
    }
    return h;
}

bool read_hamiltonian(struct reader *rd, const json_t *system)
{
    struct form_hamiltonian f = { 0 };
    struct read_matrix omega = { .name = "omega", .per_row = "variables", .per_col = "variables" };
    expr_id *restriction = NULL;
    int *variable = read_variables(rd, system, "variables", &f.variables);
    bool ok = variable && read_function(rd, system, &f.hamiltonian) && read_two_form(rd, system, &omega, variable, f.variables)
        && read_expression_list(rd, system, "restrict", &restriction, &f.restrictions)
        && check_size(rd, f.variables, f.restrictions);
    if (!ok)
        return false;
    struct form_matrix m = { .rows = f.variables, .cols = f.variables, .entry = omega.entry, .entries = omega.entries };
    f.variable = variable;
    f.restriction = restriction;
    f.restrictions = f.restrictions > 0 ? f.restrictions : 0;
    rd->r->hamiltonian = keep(&rd->r->mem, &f, json_object_get(system, "omega") ? &m : NULL);
    form_hamiltonian_space(&rd->r->system, rd->r->hamiltonian);
    if (!f.restrictions)
        form_hamiltonian_rows(&rd->r->system, rd->r->hamiltonian, NULL);
    return true;
}
