/* Which velocities are left in a sum is read off its gradient; those that earlier eliminations determined are put in, each by a step of its own. */
#include "sums.h"

#include <assert.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "derive.h"
#include "given.h"
#include "poly.h"
#include "printed_parts.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"

int derivation_differentiate(struct derivation *d, int constraint)
{
    char text[120];
    if (d->differentiated[constraint])
        return d->differentiated[constraint];
    snprintf(text, sizeof text, "differentiate (%d) along the motion", d->found[constraint]);
    struct step *p = steps_add(&d->steps, STEP_DIFFERENTIATE, d->j->solution->constraint[constraint].generation + 1, "identity", text);
    steps_use(&d->steps, p, d->found[constraint]);
    if (d->xi[constraint])
        steps_line(&d->steps, p, derivation_sheet_rate(&d->sheet, d->xi[constraint]), expr_int(&d->sheet.m.store, 0));
    return d->differentiated[constraint] = d->steps.count;
}

/* A v - alpha of a row, in the sheet. */
static expr_id row_residual(struct derivation *d, int row)
{
    const struct sys_row *r = d->j->request->system.row + row;
    struct expr_store *st = &d->sheet.m.store;
    expr_id sum = expr_neg(st, derivation_sheet_copy(&d->sheet, r->alpha));
    for (int k = 0; k < r->entries; k++)
        sum = expr_add(st, sum, expr_mul(st, derivation_sheet_copy(&d->sheet, r->entry[k].value), derivation_sheet_velocity(&d->sheet, r->entry[k].col)));
    return sum;
}

/* Marks the velocities whose coefficients in the sum are not seen to cancel. */
static void velocities_left(struct derivation *d, expr_id sum, unsigned char *left)
{
    struct expr_store *st = &d->sheet.m.store;
    int n = d->j->request->system.variables;
    SGA_ARENA(mem);
    unsigned char *active = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    memset(active + d->sheet.first, 1, (size_t)n);
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    int terms = expr_gradient(st, &cone, sum, active, &term, &cap);
    struct poly_limits limits = poly_limits_of(POLY_SHOWN, d->j->budget);
    for (int k = 0; k < terms; k++) {
        expr_id normal = term[k].value;
        if (!expr_is_const(st, normal) && poly_normal(st, normal, &limits, &normal) && expr_is_zero(st, normal))
            continue;
        assert(term[k].symbol >= d->sheet.first && term[k].symbol < d->sheet.first + n);
        left[term[k].symbol - d->sheet.first] = 1;
    }
}

/* What a sum has of one velocity, times that velocity; 0: EXPR_UNDEF. */
static expr_id coefficient(struct derivation *d, expr_id sum, int variable)
{
    struct expr_store *st = &d->sheet.m.store;
    SGA_ARENA(mem);
    unsigned char *active = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    active[d->sheet.first + variable] = 1;
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    return expr_gradient(st, &cone, sum, active, &term, &cap) == 1 ? term[0].value : EXPR_UNDEF;
}

/* A velocity that is left is what a row says that the sum has already: then it has more of that row. */
static bool takes_more(struct derivation *d, struct derivation_terms *t, expr_id *all, const struct sga_rate *rate)
{
    struct expr_store *st = &d->sheet.m.store;
    int variable, k = 0, row = rate->parts == 1 ? rate->part[0].row : -1;
    if (row < 0 || !derivation_row_is_solved(d->j, row, &variable) || variable != rate->variable)
        return false;
    while (k < t->terms && t->term[k].step != d->given[row])
        k++;
    expr_id residual = row_residual(d, row), own = coefficient(d, residual, variable), c = coefficient(d, *all, variable);
    if (k == t->terms || !own || !c)
        return false;
    expr_id more = expr_neg(st, expr_div(st, c, own));
    expr_id factor = expr_add(st, t->term[k].factor, more), next = expr_add(st, *all, expr_mul(st, more, residual));
    if (!factor || !next)
        return false;
    struct poly_limits limits = poly_limits_of(POLY_SHOWN, d->j->budget);
    poly_normal(st, factor, &limits, &factor);
    t->term[k].factor = factor;
    if (expr_is_zero(st, factor)) {
        memmove(t->term + k, t->term + k + 1, (size_t)(t->terms - k - 1) * sizeof *t->term);
        t->terms--;
    }
    *all = next;
    return true;
}

/* The rate that gives the velocity in a sum; -1: none. */
static int rate_of(const struct derivation *d, const struct derivation_sum *sum, int variable)
{
    const struct sga_solution *sol = d->j->solution;
    for (int r = (sum->before < sol->rates ? sum->before : sol->rates) - 1; r >= 0; r--)
        if (sol->rate[r].variable == variable && sol->rate[r].epoch == sum->epoch && sol->rate[r].generation < sum->generation)
            return r;
    return -1;
}

static void push(struct derivation *d, struct derivation_terms *t, int number)
{
    for (int k = 0; k < t->uses; k++)
        if (t->use[k] == number)
            return;
    size_t cap = (size_t)t->uses;     /* grown by one: lists are short */
    SGA_RESERVE_IN(&d->mem, t->use, cap, t->uses + 1);
    t->use[t->uses++] = number;
}

/* Terms, and which rates are put in (by rate, marked). */
static struct derivation_terms expand(struct derivation *d, const struct derivation_sum *sum, unsigned char *wanted)
{
    struct expr_store *st = &d->sheet.m.store;
    struct derivation_terms t = { .term = sga_zeros(&d->mem, (size_t)sum->parts + 1, sizeof *t.term) };
    expr_id all = expr_int(st, 0);
    SGA_ARENA(mem);
    int n = d->j->request->system.variables;
    unsigned char *left = sga_zeros(&mem, (size_t)n + 1, 1);
    for (int k = 0; k < sum->parts; k++) {
        const struct sga_part *part = sum->part + k;
        int number = part->row >= 0 ? d->given[part->row] : derivation_differentiate(d, part->tangency);
        expr_id e = part->row >= 0 ? row_residual(d, part->row) : d->xi[part->tangency] ? derivation_sheet_rate(&d->sheet, d->xi[part->tangency]) : EXPR_UNDEF;
        expr_id f = derivation_sheet_copy(&d->sheet, printed_factor(d->j, part, sum->minus, sum->divisor));
        t.term[t.terms++] = (struct step_term){ number, f };
        if (all)
            all = e && f ? expr_add(st, all, expr_mul(st, f, e)) : EXPR_UNDEF;
    }
    t.sum = all;
    if (!all) {
        t.open = true;
        return t;
    }
    velocities_left(d, all, left);
    for (int i = 0; i < n; i++) {
        int r = left[i] ? rate_of(d, sum, i) : -1;
        if (r >= 0 && takes_more(d, &t, &all, d->j->solution->rate + r)) {
            t.sum = all;
            continue;
        }
        if (r >= 0)
            wanted[r] = 1;
        t.open |= left[i] && r < 0;
    }
    return t;
}

/* What the sum of a rate's row puts in has to come before it; a row that is solved as it stands needs no step. */
static struct derivation_sum sum_of_rate(const struct sga_rate *r, int index)
{
    return (struct derivation_sum){ .part = r->part, .parts = r->parts, .generation = r->generation + 1, .epoch = r->epoch, .before = index };
}

/* Everything that may settle velocities which stay: rows with velocities, and tangencies of generations well before. */
static void use_all(struct derivation *d, struct derivation_terms *t, int generation)
{
    const struct sys_system *sys = &d->j->request->system;
    const struct sga_solution *sol = d->j->solution;
    for (int i = 0; i < sys->rows; i++)
        if (sys->row[i].entries)
            push(d, t, d->given[i]);
    for (int i = 0; i < sol->constraints && sol->constraint[i].generation < generation - 1; i++)
        if (d->found[i])
            push(d, t, derivation_differentiate(d, i));
}

static void use_rates(struct derivation *d, struct derivation_terms *t, const unsigned char *wanted, int below)
{
    t->rate = sga_zeros(&d->mem, (size_t)below + 1, sizeof *t->rate);
    for (int r = 0; r < below; r++)
        if (wanted[r]) {
            push(d, t, d->solved[r]);
            t->rate[t->rates++] = r;
            t->velocities = true;
        }
}

bool derivation_sum_is(struct derivation *d, const struct derivation_terms *t, expr_id leaves)
{
    struct expr_store *st = &d->sheet.m.store;
    const struct sga_solution *sol = d->j->solution;
    struct poly_limits limits = poly_limits_of(POLY_MODEST, d->j->budget);
    if (!t->sum || !leaves || t->open)
        return false;
    expr_id rest = expr_sub(st, t->sum, leaves);
    SGA_ARENA(mem);
    expr_id *map = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *map);
    for (int k = 0; k < t->rates; k++)
        map[d->sheet.first + sol->rate[t->rate[k]].variable] = derivation_sheet_copy(&d->sheet, sol->rate[t->rate[k]].value);
    expr_substitute(st, &rest, 1, map);
    return expr_is_zero(st, rest) || (rest && poly_normal(st, rest, &limits, &rest) && expr_is_zero(st, rest));
}

void derivation_on_constraints(struct derivation *d, struct step *p, int i)
{
    p->basis = "on_constraints";
    for (int k = 0; k < i; k++)
        if (d->found[k])
            steps_use(&d->steps, p, d->found[k]);
}

/* Whether the sum vanishes identically with the velocity's value put in too. */
static bool rate_is_identity(struct derivation *d, const struct derivation_terms *t, int variable, expr_id value)
{
    struct expr_store *st = &d->sheet.m.store;
    struct derivation_terms own = *t;
    SGA_ARENA(mem);
    expr_id *map = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *map);
    map[d->sheet.first + variable] = value;
    if (own.sum)
        expr_substitute(st, &own.sum, 1, map);
    return derivation_sum_is(d, &own, expr_int(st, 0));
}

/* The steps of rates in the order in which they were found. */
static void solve_rates(struct derivation *d, unsigned char *wanted)
{
    const struct sga_solution *sol = d->j->solution;
    SGA_ARENA(mem);
    struct derivation_terms *terms = sga_zeros(&mem, (size_t)sol->rates + 1, sizeof *terms);
    unsigned char **inner = sga_zeros(&mem, (size_t)sol->rates + 1, sizeof *inner);
    for (int r = sol->rates - 1; r >= 0; r--) {
        int variable;
        if (!wanted[r] || d->solved[r])
            continue;
        const struct sga_rate *rate = sol->rate + r;
        if (rate->parts == 1 && rate->part[0].row >= 0 && derivation_row_is_solved(d->j, rate->part[0].row, &variable) && variable == rate->variable) {
            d->solved[r] = d->given[rate->part[0].row];
            continue;
        }
        struct derivation_sum sum = sum_of_rate(rate, r);
        inner[r] = sga_zeros(&mem, (size_t)sol->rates + 1, 1);
        terms[r] = expand(d, &sum, inner[r]);
        for (int k = 0; k < r; k++)
            wanted[k] |= inner[r][k];
    }
    for (int r = 0; r < sol->rates; r++) {
        if (!inner[r])
            continue;
        const struct sga_rate *rate = sol->rate + r;
        struct derivation_terms *t = terms + r;
        use_rates(d, t, inner[r], r);
        SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
        sga_buf_printf(&text, "solve for the velocity of %s: ", answer_variable_name(d->j, rate->variable));
        derivation_terms_text(d, t, &text);
        struct step *p = steps_add(&d->steps, STEP_SOLVE, rate->generation, "identity", text.data);
        expr_id value = derivation_sheet_copy(&d->sheet, printed_normal(d->j, rate->value));
        derivation_use_terms(d, p, t);
        steps_line(&d->steps, p, derivation_sheet_velocity(&d->sheet, rate->variable), value);
        if (!rate_is_identity(d, t, rate->variable, value))
            derivation_on_constraints(d, p, sol->constraints);
        d->solved[r] = d->steps.count;
    }
}

struct derivation_terms derivation_sum_terms(struct derivation *d, const struct derivation_sum *sum)
{
    const struct sga_solution *sol = d->j->solution;
    SGA_ARENA(mem);
    unsigned char *wanted = sga_zeros(&mem, (size_t)sol->rates + 1, 1), *own = sga_zeros(&mem, (size_t)sol->rates + 1, 1);
    struct derivation_terms t = expand(d, sum, own);
    memcpy(wanted, own, (size_t)sol->rates);
    solve_rates(d, wanted);
    use_rates(d, &t, own, sol->rates);
    if (t.open)
        use_all(d, &t, sum->generation);
    return t;
}

void derivation_use_terms(struct derivation *d, struct step *p, const struct derivation_terms *t)
{
    for (int k = 0; k < t->terms; k++)
        steps_term(&d->steps, p, t->term[k].step, t->term[k].factor);
    for (int k = 0; k < t->uses; k++)
        steps_use(&d->steps, p, t->use[k]);
}

void derivation_terms_text(struct derivation *d, const struct derivation_terms *t, struct sga_buf *out)
{
    struct expr_store *st = &d->sheet.m.store;
    for (int k = 0; k < t->terms; k++) {
        SGA_ENDS(sga_buf_free) struct sga_buf f = { 0 };
        expr_id e = t->term[k].factor;
        sga_buf_puts(out, k ? " + " : "");
        if (!e || !derivation_sheet_text(&d->sheet, e, &f))
            sga_buf_puts(out, "a long factor times ");
        else if (!expr_is_one(st, e))
            sga_buf_printf(out, "%s%s%s*", strpbrk(f.data, "+-") ? "(" : "", f.data, strpbrk(f.data, "+-") ? ")" : "");
        sga_buf_printf(out, "(%d)", t->term[k].step);
    }
    for (int k = 0, first = 1; k < t->uses && t->velocities; k++, first = 0)
        sga_buf_printf(out, "%s(%d)", first ? ", with velocities from " : ", ", t->use[k]);
    if (t->open)
        sga_buf_puts(out, "; velocities that are left cancel by the equations used");
}
