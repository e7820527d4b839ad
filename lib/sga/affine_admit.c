/* Which candidates become constraints of an affine system. */
#include "affine.h"

#include <assert.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "oracle.h"
#include "reduction.h"
#include "system.h"

/* Where so many constraints stand together they are taken as they come, with sparse pivots for all at once. */
enum { ONE_BY_ONE = 300 };

void affine_candidate_clear(struct affine_candidate *c)
{
    exact_row_clear(&c->function);
    for (int k = 0; k < c->parts; k++)
        fmpq_clear(c->weight + k);
    free(c->source);
    free(c->weight);
    *c = (struct affine_candidate){ 0 };
}

static void weigh(struct affine_candidate *c, const fmpq_t factor)
{
    for (int k = 0; k < c->parts; k++)
        fmpq_mul(c->weight + k, c->weight + k, factor);
}

static void primitive(struct affine_candidate *c)
{
    SGA_ENDS(fmpq_end) fmpq_t factor = { { 0, 1 } };
    fmpq_one(factor);
    exact_primitive(&c->function, factor);
    weigh(c, factor);
}

/* den * function - sum of factor * constraint, which agrees with den * function on these. */
static void less_constraints(struct affine_run *r, const struct affine_candidate *c, const struct exact_combination *k, struct exact_row *out)
{
    SGA_ENDS(exact_sum_clear) struct exact_sum sum;
    exact_sum_init(&sum, r->a->n + r->a->atoms);
    exact_sum_add(&sum, &c->function, k->den);
    SGA_ENDS(fmpz_end) fmpz_t f = { 0 };
    for (int q = 0; q < k->count; q++) {
        const struct affine_constraint *of = r->constraint[r->set.pivot[k->pivot[q]].row];
        fmpz_mul(f, k->factor + q, fmpq_numref(&of->tangency.scale));     /* the rows of `set` are the tangencies' */
        exact_sum_subtract(&sum, &of->function, f);
    }
    exact_sum_take(&sum, out);
}

/* `by` = factor times the function on the constraints so far takes its place; it is moved from. */
static void replace_function(struct affine_candidate *c, struct exact_row *by, const fmpq_t factor)
{
    exact_row_clear(&c->function);
    c->function = *by;
    *by = (struct exact_row){ 0 };
    weigh(c, factor);
}

static void to_parts(struct affine_run *r, const struct affine_candidate *c, bool minus, struct sga_part **part, int *parts)
{
    int rows = r->s->sys->rows;
    *part = sga_malloc(((size_t)c->parts + 1) * sizeof **part);
    *parts = 0;
    for (int k = 0; k < c->parts; k++) {
        expr_id f = expr_fmpq(r->s->st, c->weight + k);
        (*part)[(*parts)++] = (struct sga_part){ .row = c->source[k] < rows ? c->source[k] : -1,
            .tangency = c->source[k] < rows ? -1 : c->source[k] - rows, .factor = minus ? expr_neg(r->s->st, f) : f };
    }
}

/* What comes from a row of the system is a sum of right sides alpha, what comes from a tangency one of derivatives
 * d xi / dt: as for systems that are not affine (generation.c). */
static bool is_right_side(const struct affine_run *r, const struct affine_candidate *c)
{
    return c->from < r->s->sys->rows;
}

/* Its tangency: d xi x' = -d_t xi. */
static void make_tangency(struct affine_run *r, struct affine_constraint *k)
{
    SGA_ENDS(fmpz_end) fmpz_t den = { 0 };
    exact_row_copy(&k->function, r->a->n, &k->tangency.a);
    affine_rate(r->a, &k->function, &k->tangency.b, den);
    for (int q = 0; q < k->tangency.a.entries; q++)
        fmpz_mul(k->tangency.a.value + q, k->tangency.a.value + q, den);
    for (int q = 0; q < k->tangency.b.entries; q++)
        fmpz_neg(k->tangency.b.value + q, k->tangency.b.value + q);
    fmpq_init(&k->tangency.scale);
    fmpq_set_fmpz(&k->tangency.scale, den);
}

/* c becomes a constraint of generation g; it is moved from. */
static struct affine_constraint *keep(struct affine_run *r, struct affine_candidate *c, int g)
{
    struct state *s = r->s;
    struct affine_constraint *k = sga_calloc(1, sizeof *k);
    k->function = c->function;
    c->function = (struct exact_row){ 0 };
    make_tangency(r, k);
    SGA_RESERVE(r->constraint, r->constraint_cap, r->constraints + 1);
    r->constraint[r->constraints++] = k;
    struct sga_constraint new = { .expr = affine_expression(r->a, &k->function), .generation = g, .source = c->from,
        .origin = c->from < 0 ? SGA_FROM_RESTRICTION : SGA_FROM_ROWS, .restriction = c->restriction };
    new.base = new.expr;
    if (s->options->combinations)
        to_parts(r, c, is_right_side(r, c), &new.part, &new.parts);
    state_push(s, &new);
    return k;
}

/* Decides whether the function of time alone (and parameters) is 0: 1, 0, or -1 with err. */
static int is_zero(struct affine_run *r, const struct exact_row *f, expr_id *e)
{
    *e = affine_expression(r->a, f);
    if (!f->entries || (f->entries == 1 && f->col[0] == r->a->n)) {
        r->s->oracle->count[POINTS_EXACT]++;
        return !f->entries;
    }
    if (!r->sampled && !affine_sample(r->s, 0))
        return -1;
    r->sampled = true;
    return ech_zero(&r->s->ctx, *e);
}

/* c, whose weights are made such that its own row counts once: what is left of that row on the right. */
static expr_id once(struct affine_run *r, struct affine_candidate *c)
{
    SGA_ENDS(fmpq_end) fmpq_t own = { { 0, 1 } };
    SGA_ENDS(fmpz_end) fmpz_t den = { 0 };
    fmpq_neg(own, c->weight);
    for (int k = c->parts - 1; k >= 0; k--)
        fmpq_div(c->weight + k, c->weight + k, c->weight);
    fmpz_set(den, fmpq_numref(own));
    for (int k = 0; k < c->function.entries; k++)
        fmpz_mul(c->function.value + k, c->function.value + k, fmpq_denref(own));
    return affine_expression_from(r->a, &c->function, 0, den);
}

static void note_vanished(struct affine_run *r, struct affine_candidate *c, int before, int g)
{
    struct state *s = r->s;
    struct sga_solution *sol = s->sol;
    if (c->from < 0 || (c->from >= s->sys->rows && !s->options->rows))
        return;
    sol->redundant_rows += c->from < s->sys->rows;
    if (!s->options->rows)
        return;
    SGA_RESERVE(sol->vanished, s->vanished_cap, sol->vanished_rows + 1);
    struct sga_vanished *v = sol->vanished + sol->vanished_rows++;
    *v = (struct sga_vanished){ .source = c->from, .generation = c->function.entries ? g : before };
    v->rest = once(r, c);
    to_parts(r, c, false, &v->part, &v->parts);
}

/* On the constraints so far c comes to a function of time, rest = factor * c: nothing new, or a contradiction. */
static bool settle(struct affine_run *r, struct affine_candidate *c, struct exact_row *rest, const fmpq_t factor, bool used, int before, int g)
{
    struct state *s = r->s;
    expr_id e;
    int z = is_zero(r, rest, &e);
    if (z == 1) {
        note_vanished(r, c, before, g);
    } else if (z == 0) {
        replace_function(c, rest, factor);
        s->inconsistent = true;
        s->sol->contradiction = c->from < 0 ? s->sys->restriction[c->restriction] : e;
        snprintf(s->sol->contradiction_why, sizeof s->sol->contradiction_why, "%s%s", used ? "with the earlier constraints used up, " : "",
                 state_hopeless(s, e));
        to_parts(r, c, is_right_side(r, c), &s->sol->contradiction_part, &s->sol->contradiction_parts);
    }
    return z >= 0;
}

/* The candidate on the constraints so far: without the pivot variables of the basis, or, where they are many, a function of
 * time if it is one. *constant says so. False: stopped. */
static bool on_set(struct affine_run *r, const struct affine_candidate *c, struct exact_row *out, fmpq_t factor, bool *constant, bool *used)
{
    SGA_ENDS(exact_row_clear) struct exact_row linear = { 0 };
    SGA_ENDS(exact_combination_clear) struct exact_combination k = { 0 };
    enum exact_found found = EXACT_YES;
    if (!r->many) {
        exact_basis_reduce(&r->basis, &c->function, r->a->n + r->a->atoms, out, factor, used);
        *constant = !out->entries || out->col[0] >= r->a->n;
        return true;
    }
    exact_row_copy(&c->function, r->a->n, &linear);
    found = exact_combine(&r->set, &linear, true, &k, r->s->options->budget, r->s->err);
    *constant = found == EXACT_YES;
    *used = *constant && k.count;
    if (*constant) {
        less_constraints(r, c, &k, out);
        fmpq_set_fmpz(factor, k.den);
        exact_primitive(out, factor);
    }
    return found != EXACT_STOPPED;
}

/* A new constraint enters what the next ones are reduced by. */
static bool enter(struct affine_run *r, const struct affine_constraint *k, const struct exact_row *reduced)
{
    const struct exact_row *row = &k->tangency.a;
    if (!r->many) {
        exact_basis_add(&r->basis, reduced, r->a->n + r->a->atoms);
        return true;
    }
    assert(r->set.givens == r->constraints - 1);
    if (!exact_echelon_add(&r->set, &row, 1, r->s->options->budget, r->s->err))
        return false;
    r->bad_prime |= r->set.pivot_of_row[r->constraints - 1] < 0;
    return !r->bad_prime;
}

/* One candidate after those before it. 1 added, 0 not (or a contradiction), -1 failed or a bad prime. */
static int admit_one(struct affine_run *r, struct affine_candidate *c, int before, int g)
{
    SGA_ENDS(exact_row_clear) struct exact_row rest = { 0 };
    SGA_ENDS(fmpq_end) fmpq_t factor = { { 0, 1 } };
    bool constant, used;
    int added = -1;
    primitive(c);
    if (on_set(r, c, &rest, factor, &constant, &used) && constant) {
        added = settle(r, c, &rest, factor, used, before, g) ? 0 : -1;
    } else if (r->s->err->code == SGA_E_OK) {
        SGA_ENDS(exact_row_clear) struct exact_row reduced = { 0 };
        exact_row_copy(&rest, INT_MAX, &reduced);
        if (!r->many && used && exact_row_bits(&rest) <= exact_row_bits(&c->function))
            replace_function(c, &rest, factor);
        added = enter(r, keep(r, c, g), &reduced) ? 1 : -1;
    }
    return added;
}

/* Many candidates: which are independent is found for all of them at once, with pivots chosen for all together: the set has them afterwards, as
 * `linear`. Those that are come first in `c`. */
static bool independent_first(struct affine_run *r, struct affine_candidate *c, int count, struct exact_row *linear, int *independent)
{
    SGA_ARENA(mem);
    const struct exact_row **row = sga_take(&mem, ((size_t)count + 1) * sizeof *row);
    int first = r->constraints;
    assert(r->many && r->set.givens == first);
    for (int i = 0; i < count; i++) {
        primitive(c + i);
        exact_row_copy(&c[i].function, r->a->n, linear + i);
        row[i] = linear + i;
    }
    bool ok = exact_echelon_add(&r->set, row, count, r->s->options->budget, r->s->err);
    struct affine_candidate *sorted = sga_take(&mem, ((size_t)count + 1) * sizeof *sorted);
    int n = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < count && ok; i++)
            if ((r->set.pivot_of_row[first + i] < 0) == pass)
                sorted[n++] = c[i];
        *independent = pass ? *independent : n;
    }
    if (ok)
        memcpy(c, sorted, (size_t)count * sizeof *c);
    return ok;
}

static bool same_row(const struct exact_row *a, const struct exact_row *b)
{
    bool same = a->entries == b->entries;
    for (int k = 0; k < a->entries && same; k++)
        same = a->col[k] == b->col[k] && fmpz_equal(a->value + k, b->value + k);
    return same;
}

/* Those that were found independent become constraints. linear: the rows that the set has for all candidates; where these are not the rows of the
 * constraints (some were dependent, or have fractions of time), they leave it. */
static int admit_together(struct affine_run *r, struct affine_candidate *c, int count, int g, const struct exact_row *linear)
{
    SGA_FREED const struct exact_row **row = sga_malloc(((size_t)count + 1) * sizeof *row);
    int first = r->constraints, added = -1;
    bool same = r->set.givens == first + count;
    for (int i = 0; i < count; i++) {
        row[i] = &keep(r, c + i, g)->tangency.a;
        same = same && same_row(row[i], linear + i);
    }
    for (int i = 0; i < count && same; i++)
        r->set.given[first + i] = row[i];
    if (!same)
        exact_echelon_cut(&r->set, first);
    if (same || exact_echelon_add(&r->set, row, count, r->s->options->budget, r->s->err))
        added = count;
    for (int i = first; i < r->constraints && added >= 0; i++)
        r->bad_prime |= r->set.pivot_of_row[i] < 0;
    return r->bad_prime ? -1 : added;
}

/* From here on constraints are many. */
static bool become_many(struct affine_run *r)
{
    SGA_FREED const struct exact_row **row = sga_malloc(((size_t)r->constraints + 1) * sizeof *row);
    for (int i = 0; i < r->constraints; i++)
        row[i] = &r->constraint[i]->tangency.a;
    bool ok = r->many || exact_echelon_add(&r->set, row, r->constraints, r->s->options->budget, r->s->err);
    for (int i = 0; i < r->constraints && ok && !r->many; i++)
        r->bad_prime |= r->set.pivot_of_row[i] < 0;
    r->many = true;
    assert(!ok || r->set.givens >= r->constraints);
    return ok && !r->bad_prime;
}

int affine_admit(struct affine_run *r, struct affine_candidate *c, int count, int g)
{
    assert(r->constraints == r->s->sol->constraints);
    assert(g >= 1 && count >= 0);
    int together = 0, sum = 0;
    int before = r->constraints ? r->s->sol->constraint[r->constraints - 1].generation : 0;
    if (r->constraints + count > ONE_BY_ONE) {
        if (!become_many(r))
            return -1;
        SGA_FREED struct exact_row *linear = sga_calloc((size_t)count + 1, sizeof *linear);
        bool ok = independent_first(r, c, count, linear, &together);
        sum = ok ? admit_together(r, c, together, g, linear) : -1;
        for (int i = 0; i < count; i++)
            exact_row_clear(linear + i);
        if (!ok)
            return -1;
    }
    for (int i = together; i < count && sum >= 0 && !r->s->inconsistent; i++) {
        int added = admit_one(r, c + i, before, g);
        sum = added < 0 ? -1 : sum + added;
    }
    return sum;
}
