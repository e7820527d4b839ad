/* The role of each equation, and for those that follow from others the combination, read
 * back from the elimination and checked before it is told. */
#include "structure_work.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "ball.h"
#include "derive.h"
#include "echelon.h"
#include "error.h"
#include "facts.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "poly.h"
#include "reduction.h"
#include "structure.h"
#include "system.h"

int structure_zero_everywhere(struct structure_work *w, expr_id e)
{
    if (expr_is_zero(w->sys->store, e))
        return 1;
    if (!w->space_state) {
        struct points_space space = w->oracle->space;
        space.constraint = NULL;
        space.constraints = 0;
        space.near = NULL;
        space.before = NULL;
        w->space_state = points_oracle_sample(&w->space, &space) == POINTS_OK ? 1 : -1;
    }
    if (w->space_state < 0)
        return -1;
    struct points_decision d = points_oracle_zero(&w->space, e);
    return d.truth == POINTS_UNKNOWN ? -1 : d.truth == POINTS_ZERO;
}

static int zero_on_final(struct structure_work *w, expr_id e)
{
    if (expr_is_zero(w->sys->store, e))
        return 1;
    struct points_decision d = points_oracle_zero(w->oracle, e);
    return d.truth == POINTS_UNKNOWN ? -1 : d.truth == POINTS_ZERO;
}

/* Sums by equation. */
struct weights {
    expr_id *of;               /* by row of the system, EXPR_UNDEF for 0 */
    int *list, count;
};

static void add(struct structure_work *w, struct weights *s, int row, expr_id factor)
{
    if (!s->of[row])
        s->list[s->count++] = row;
    s->of[row] = s->of[row] ? expr_add(w->sys->store, s->of[row], factor) : factor;
}

/* Add factor times the parts; false where a derivative of a constraint takes part. */
static bool add_parts(struct structure_work *w, struct weights *s, const struct sga_part *part, int parts, expr_id factor)
{
    for (int k = 0; k < parts; k++)
        if (part[k].row < 0)
            return false;
    for (int k = 0; k < parts; k++)
        add(w, s, part[k].row, expr_mul(w->sys->store, factor, part[k].factor));
    return true;
}

/* A constraint that is, as it arose, a combination of equations: no regular function took its place. */
static bool from_equations(const struct structure_work *w, const struct sga_constraint *c)
{
    return c->origin == SGA_FROM_ROWS && !c->replaced && c->source >= 0 && c->source < w->sys->rows && c->parts;
}

/* The factor with which a constraint is in the rest: their quotient, where it has a value
 * on Pf and is right everywhere. */
static bool quotient(struct structure_work *w, expr_id rest, expr_id c, expr_id *factor)
{
    struct expr_store *st = w->sys->store;
    struct poly_limits limits = poly_limits_of(POLY_MODEST, w->budget);
    expr_id q;
    if (!poly_normal(st, expr_div(st, rest, c), &limits, &q) || !expr_store_ok(st))
        return false;
    num_ball_extend(&w->oracle->real[0].ball);
    if (!arb_is_finite(num_ball_value(&w->oracle->real[0].ball, q)))
        return false;
    *factor = q;
    return structure_zero_everywhere(w, expr_sub(st, rest, expr_mul(st, q, c))) == 1;
}

/* The constraints' differentials in echelon form over all of the space, each row with the
 * function itself as its right side: what reduces to 0 = 0 is a combination of them. */
struct functions {
    struct echelon ech;
    struct expr_facts facts;
    struct ech_context ctx;
    struct sga_error err;
    bool ready, failed;
};

static void gradient_row(struct structure_work *w, expr_id e, int source, struct ech_row *row)
{
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    int n = expr_gradient(w->sys->store, &w->cone, e, w->active, &term, &cap);
    *row = (struct ech_row){ .rhs = e, .source = source };
    for (int k = 0; k < n; k++)
        ech_row_push(row, w->column[term[k].symbol], term[k].value);
}

static void prepare(struct structure_work *w, struct functions *f)
{
    int count = 0, c = w->sol->constraints;
    SGA_FREED struct ech_row *row = sga_calloc((size_t)c + 1, sizeof *row);
    f->ready = true;
    ech_init(&f->ech, w->sys->variables);
    expr_facts_init(&f->facts);
    f->ctx = (struct ech_context){ .st = w->sys->store, .facts = &f->facts, .oracle = &w->space, .budget = w->budget,
                                   .record = true, .err = &f->err };
    for (int i = 0; i < c; i++)
        if (from_equations(w, w->sol->constraint + i))
            gradient_row(w, w->sol->constraint[i].expr, i, row + count++);
    f->failed = structure_zero_everywhere(w, expr_int(w->sys->store, 1)) < 0
                || !ech_eliminate(&f->ech, &f->ctx, row, count, 0);
    for (int i = 0; i < count; i++)
        ech_row_clear(row + i);
}

/* rest = sum of factor[i] * constraint i, identically. */
static bool express(struct structure_work *w, struct functions *f, expr_id rest, expr_id *factor)
{
    struct expr_store *st = w->sys->store;
    SGA_ENDS(ech_row_clear) struct ech_row row = { 0 };
    if (!f->ready)
        prepare(w, f);
    if (f->failed)
        return false;
    gradient_row(w, rest, -1, &row);
    SGA_FREED expr_id *weight = sga_calloc((size_t)f->ech.pivots + 1, sizeof *weight);
    int before = f->ech.pivots;
    f->err = (struct sga_error){ 0 };
    bool ok = ech_eliminate(&f->ech, &f->ctx, &row, 1, 0);
    if (f->ech.pivots > before || !ok)       /* it is no combination, and has become a pivot: begin anew next time */
        f->failed = true;
    ok = ok && f->ech.pivots == before && expr_is_zero(st, row.rhs);
    for (int k = 0; k < row.ops && ok; k++) {
        expr_id *v = weight + row.op[k].pivot;
        *v = *v ? expr_add(st, *v, row.op[k].factor) : row.op[k].factor;
    }
    for (int q = before - 1; q >= 0 && ok; q--) {
        const struct ech_row *r = &f->ech.pivot[q].row;
        if (!weight[q])
            continue;
        factor[r->source] = factor[r->source] ? expr_add(st, factor[r->source], weight[q]) : weight[q];
        for (int k = 0; k < r->ops; k++) {
            expr_id t = expr_mul(st, weight[q], r->op[k].factor);
            expr_id *v = weight + r->op[k].pivot;
            *v = *v ? expr_sub(st, *v, t) : expr_neg(st, t);
        }
    }
    return ok;
}

static void functions_clear(struct functions *f)
{
    if (f->ready) {
        ech_clear(&f->ech);
        expr_facts_clear(&f->facts);
    }
}

/* What is left of a combination is itself one of constraints: take those away too. */
static bool take_rest(struct structure_work *w, struct functions *f, struct weights *s, expr_id rest)
{
    struct expr_store *st = w->sys->store;
    int c = w->sol->constraints;
    bool done = false;
    if (structure_zero_everywhere(w, rest) == 1)
        return true;
    for (int i = 0; i < c && c <= 60 && !done; i++) {
        expr_id q;
        if (from_equations(w, w->sol->constraint + i) && quotient(w, rest, w->sol->constraint[i].expr, &q))
            done = add_parts(w, s, w->sol->constraint[i].part, w->sol->constraint[i].parts, expr_neg(st, q));
    }
    if (done)
        return true;
    SGA_FREED expr_id *factor = sga_calloc((size_t)c + 1, sizeof *factor);
    done = express(w, f, rest, factor);
    if (f->failed) {
        functions_clear(f);
        *f = (struct functions){ 0 };
    }
    for (int i = 0; i < c && done; i++)
        if (factor[i])
            done = add_parts(w, s, w->sol->constraint[i].part, w->sol->constraint[i].parts, expr_neg(st, factor[i]));
    return done;
}

/* Every column and the right side of the sum, by the given question. */
static bool sums_vanish(struct structure_work *w, const struct sga_part *part, int parts,
                        int (*zero)(struct structure_work *, expr_id))
{
    struct expr_store *st = w->sys->store;
    int n = w->sys->variables, count = 0;
    SGA_ARENA(mem);
    expr_id *sum = sga_zeros(&mem, (size_t)n + 1, sizeof *sum), alpha = expr_int(st, 0);
    int *list = sga_take(&mem, ((size_t)n + 1) * sizeof *list);
    bool ok = true;
    for (int k = 0; k < parts; k++) {
        const struct sys_row *r = w->sys->row + part[k].row;
        alpha = expr_add(st, alpha, expr_mul(st, part[k].factor, r->alpha));
        for (int q = 0; q < r->entries; q++) {
            int col = r->entry[q].col;
            expr_id t = expr_mul(st, part[k].factor, r->entry[q].value);
            if (!sum[col])
                list[count++] = col;
            sum[col] = sum[col] ? expr_add(st, sum[col], t) : t;
        }
    }
    for (int k = 0; k < count && ok; k++)
        ok = zero(w, sum[list[k]]) == 1;
    ok = ok && zero(w, alpha) == 1;
    return ok;
}

static void simplify(struct structure_work *w, struct sga_part *part, int *parts)
{
    struct poly_limits limits = poly_limits_of(POLY_GLANCE, w->budget);
    int kept = 0;
    for (int k = 0; k < *parts; k++) {
        poly_normal(w->sys->store, part[k].factor, &limits, &part[k].factor);
        if (!expr_is_zero(w->sys->store, part[k].factor))
            part[kept++] = part[k];
    }
    *parts = kept;
}

static void combine(struct structure_work *w, struct functions *f, struct sga_arena *mem, struct structure_equation *e)
{
    const struct sga_vanished *v = w->sol->vanished + e->vanished;
    size_t rows = (size_t)w->sys->rows + 1;
    SGA_ARENA(own);
    struct weights s = { sga_zeros(&own, rows, sizeof *s.of), sga_take(&own, rows * sizeof *s.list), 0 };
    bool whole = add_parts(w, &s, v->part, v->parts, expr_int(w->sys->store, 1));
    if (whole) {
        take_rest(w, f, &s, v->rest);
        e->part = sga_take(mem, ((size_t)s.count + 1) * sizeof *e->part);
        for (int k = 0; k < s.count; k++)
            e->part[e->parts++] = (struct sga_part){ .row = s.list[k], .tangency = -1, .factor = s.of[s.list[k]] };
        simplify(w, e->part, &e->parts);
        e->everywhere = sums_vanish(w, e->part, e->parts, structure_zero_everywhere);
        if (!e->everywhere && !sums_vanish(w, e->part, e->parts, zero_on_final)) {
            e->part = NULL;      /* dense blocks keep no record of what they did */
            e->parts = 0;
        }
    }
    e->holds_on = e->everywhere ? 0 : v->generation;
}

/* The derivative of constraint j gives nothing new: its rest may be a multiple of another
 * constraint that is an equation of the request by itself, which then follows from j and
 * the equations that gave the velocities. Told only where all of these do without it. */
static void derivative_implies(struct structure_work *w, struct structure *out, const struct sga_vanished *v)
{
    int j = v->source - w->sys->rows, c = w->sol->constraints;
    if (w->sol->constraint[j].generation != 1 || structure_zero_everywhere(w, v->rest) == 1 || c > 60)
        return;
    for (int i = 0; i < c; i++) {
        const struct sga_constraint *k = w->sol->constraint + i;
        expr_id q;
        bool ok = i != j && from_equations(w, k) && k->generation == 1 && quotient(w, v->rest, k->expr, &q)
                  && zero_on_final(w, q) == 0;
        for (int a = 0; a < v->parts && ok; a++)
            ok = v->part[a].row != k->source && (v->part[a].row >= 0 || v->part[a].tangency == j);
        for (int b = 0; b < c && ok; b++)
            for (int a = 0; a < w->sol->constraint[b].parts && ok && b != i; a++)
                ok = w->sol->constraint[b].part[a].row != k->source;
        if (ok)
            out->equation[k->source].derivative_of = j;
    }
}

void structure_equations(struct structure_work *w, struct structure *out)
{
    int rows = w->sys->rows, c = w->sol->constraints;
    SGA_ENDS(functions_clear) struct functions f = { 0 };
    out->equations = rows + c;
    out->equation = sga_zeros(&out->mem, (size_t)(rows + c) + 1, sizeof *out->equation);
    for (int i = 0; i < rows + c; i++)
        out->equation[i] = (struct structure_equation){ .source = i, .role = STRUCTURE_USED, .variable = -1,
                                                        .constraint = -1, .vanished = -1, .derivative_of = -1 };
    for (int k = 0; k < w->sol->vanished_rows; k++) {
        struct structure_equation *e = out->equation + w->sol->vanished[k].source;
        e->role = STRUCTURE_CONSEQUENCE;
        e->vanished = k;
    }
    for (int k = c - 1; k >= 0; k--) {
        int source = w->sol->constraint[k].source;
        if (source < 0)
            continue;
        out->equation[source].role = STRUCTURE_CONSTRAINT;
        out->equation[source].constraint = k;
    }
    for (int q = 0; q < w->sol->pivots; q++) {
        const struct sga_pivot *p = w->sol->pivot + q;
        if (p->col < 0)
            continue;
        out->equation[p->source].role = STRUCTURE_DERIVATIVE;
        out->equation[p->source].variable = p->col;
    }
    for (int i = 0; i < rows; i++)
        if (out->equation[i].role == STRUCTURE_CONSEQUENCE)
            combine(w, &f, &out->mem, out->equation + i);
    for (int k = 0; k < w->sol->vanished_rows; k++)
        if (w->sol->vanished[k].source >= rows)
            derivative_implies(w, out, w->sol->vanished + k);
}
