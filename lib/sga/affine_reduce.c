/* The generations of an affine system, over the rationals. */
#include "affine.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "mem.h"
#include "oracle.h"
#include "reduction.h"
#include "system.h"

const struct affine_row *affine_source(const struct affine_run *r, int source)
{
    int rows = r->s->sys->rows;
    return source < rows ? r->a->row + source : &r->constraint[source - rows]->tangency;
}

static void add_part(struct affine_candidate *c, int source, const fmpz_t factor, const fmpq_t scale, bool minus)
{
    fmpq *w = c->weight + c->parts;
    fmpq_init(w);
    fmpq_mul_fmpz(w, scale, factor);
    if (minus)
        fmpq_neg(w, w);
    c->source[c->parts++] = source;
}

/* The row `source` is a combination of pivot rows: what is left of it on the right. 1, or 0 with err or a bad prime. */
static bool dependent_row(struct affine_run *r, int source, struct exact_sum *sum, struct affine_candidate *c)
{
    SGA_ENDS(exact_combination_clear) struct exact_combination k;
    const struct affine_row *own = affine_source(r, source);
    enum exact_found found = exact_combine(&r->velocities, &own->a, true, &k, r->s->options->budget, r->s->err);
    r->bad_prime |= found == EXACT_NO;
    *c = (struct affine_candidate){ .from = source, .restriction = -1 };
    if (found == EXACT_YES) {
        c->source = sga_malloc(((size_t)k.count + 1) * sizeof *c->source);
        c->weight = sga_malloc(((size_t)k.count + 1) * sizeof *c->weight);
        add_part(c, source, k.den, &own->scale, false);
        exact_sum_subtract(sum, &own->b, k.den);
        for (int q = 0; q < k.count; q++) {
            int row = r->velocities.pivot[k.pivot[q]].row;
            exact_sum_add(sum, &affine_source(r, row)->b, k.factor + q);
            add_part(c, row, k.factor + q, &affine_source(r, row)->scale, true);
        }
        exact_sum_take(sum, &c->function);
    }
    return found == EXACT_YES;
}

/* The rows from `first` on enter the elimination; what it leaves of some is admitted as generation g. */
static int generation(struct affine_run *r, int first, int count, int g)
{
    SGA_ARENA(mem);
    struct affine_candidate *c = sga_zeros(&mem, (size_t)count + 1, sizeof *c);
    const struct exact_row **row = sga_take(&mem, ((size_t)count + 1) * sizeof *row);
    SGA_ENDS(exact_sum_clear) struct exact_sum sum;
    int n = 0;
    for (int i = 0; i < count; i++)
        row[i] = &affine_source(r, first + i)->a;
    bool ok = exact_echelon_add(&r->velocities, row, count, r->s->options->budget, r->s->err);
    exact_sum_init(&sum, r->a->n + r->a->atoms);
    for (int i = first; i < first + count && ok; i++)
        if (r->velocities.pivot_of_row[i] < 0)
            ok = dependent_row(r, i, &sum, c + n++);
    int added = ok ? affine_admit(r, c, n, g) : -1;
    for (int i = 0; i < n; i++)
        affine_candidate_clear(c + i);
    return added;
}

static int restrictions(struct affine_run *r)
{
    int n = r->s->sys->restrictions;
    SGA_FREED struct affine_candidate *c = sga_calloc((size_t)n + 1, sizeof *c);
    for (int i = 0; i < n; i++) {
        c[i] = (struct affine_candidate){ .from = -1, .restriction = i };
        exact_row_copy(r->a->restriction + i, r->a->n + r->a->atoms, &c[i].function);
    }
    int added = affine_admit(r, c, n, 1);
    for (int i = 0; i < n; i++)
        affine_candidate_clear(c + i);
    return added;
}

static bool generations(struct affine_run *r)
{
    struct state *s = r->s;
    int added = restrictions(r);
    if (added < 0)
        return false;
    s->sol->empty_restriction = s->inconsistent;
    if (s->inconsistent)
        return true;
    int more = generation(r, 0, s->sys->rows, 1), done = 0;
    if (more >= 0 && s->sol->vanished_rows && !affine_explain(r))
        return false;
    for (added = more < 0 ? -1 : added + more; added > 0 && !s->inconsistent; ) {
        if (!state_dimension(s))
            return false;
        int from = done;
        done = r->constraints;
        added = generation(r, s->sys->rows + from, done - from, s->sol->generations + 1);
    }
    assert(r->constraints <= r->a->n);
    return added >= 0;
}

static void keep_pivots(struct affine_run *r)
{
    assert(r->velocities.pivots <= r->a->n);
    struct sga_solution *sol = r->s->sol;
    int rows = r->s->sys->rows;
    sol->pivot = sga_malloc(((size_t)r->velocities.pivots + 1) * sizeof *sol->pivot);
    for (int q = 0; q < r->velocities.pivots; q++) {
        const struct exact_pivot *p = r->velocities.pivot + q;
        int g = p->row < rows ? 1 : sol->constraint[p->row - rows].generation + 1;
        sol->pivot[sol->pivots++] = (struct sga_pivot){ p->col, expr_int(r->s->st, 1), g, p->row };
    }
    r->s->oracle->count[POINTS_EXACT] += r->velocities.givens + r->constraints;
}

static void run_clear(struct affine_run *r)
{
    exact_echelon_clear(&r->velocities);
    exact_echelon_clear(&r->set);
    exact_basis_clear(&r->basis);
    for (int i = 0; i < r->constraints; i++) {
        exact_row_clear(&r->constraint[i]->function);
        exact_row_clear(&r->constraint[i]->tangency.a);
        exact_row_clear(&r->constraint[i]->tangency.b);
        fmpq_clear(&r->constraint[i]->tangency.scale);
        free(r->constraint[i]);
    }
    free(r->constraint);
}

bool affine_reduce(struct state *s, struct affine *a)
{
    bool ok = false;
    for (int which = 0; ; which++) {
        SGA_ENDS(run_clear) struct affine_run r = { .s = s, .a = a };
        exact_echelon_init(&r.velocities, a->n, which);
        exact_echelon_init(&r.set, a->n, which);
        exact_basis_init(&r.basis, a->n);
        ok = generations(&r);
        if (ok && !s->inconsistent)
            ok = affine_fields(&r) && affine_final_points(&r);
        if (ok)
            keep_pivots(&r);
        bool again = !ok && r.bad_prime;
        assert(!ok || r.constraints == s->sol->constraints);
        if (!again)
            return ok;
        state_forget(s);
    }
}
