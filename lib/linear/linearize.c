/* Matrices of the linearized motion, and of the linearized equations. */
#include "linearize.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "arb_ends.h"
#include "error.h"
#include "flint_ends.h"
#include "linear_coordinates.h"
#include "linear_gradients.h"
#include "linear_held.h"
#include "reduction.h"
#include "system.h"

/* The field at what looks like an equilibrium. */
static const double AT_REST = 1e-6;

struct work {
    struct sga_arena mem;
    struct linearization *l;
    const struct linear_request *rq;
    struct linear_gradients g;
    struct linear_coordinates c;
    expr_id *constraint, *dconstraint;
    const expr_id *field;      /* X, inputs held */
    expr_id *rate, *drate;     /* of it, by state */
    expr_id *doutput;
    struct sga_error *err;
};

static bool no_value(struct work *w, const char *what)
{
    return sga_fail_at(w->err, SGA_E_EXPR_UNDEFINED, "/linearization/at", "%s no derivative at this point; choose another", what);
}

/* d(z, y, u, w)/d(z, inputs), a row for each column of the gradients. */
static bool tangent(struct work *w, const struct linear_matrix *J, struct linear_matrix *phi)
{
    const struct linear_request *rq = w->rq;
    int states = w->c.states, follows = w->c.follows, d = states + rq->inputs;
    int *free = sga_take(&w->mem, ((size_t)d + 1) * sizeof *free), signals = rq->sys->variables;
    for (int k = 0; k < states; k++)
        free[k] = w->c.state[k];
    for (int k = 0; k < rq->inputs; k++)
        free[states + k] = rq->input[k].variable >= 0 ? rq->input[k].variable : signals++;
    assert(signals <= w->g.cols && states + follows <= rq->sys->variables);
    struct linear_matrix Jy, Jr, y;
    linear_matrix_columns(&Jy, J, w->c.follow, follows);
    linear_matrix_columns(&Jr, J, free, d);
    bool ok = linear_matrix_solve(&y, &Jy, &Jr);
    linear_matrix_init(phi, w->g.cols, d);
    phi->exact = y.exact;
    for (int i = 0; i < follows; i++)
        for (int k = 0; k < d; k++) {
            fmpq_neg(fmpq_mat_entry(phi->q, w->c.follow[i], k), fmpq_mat_entry(y.q, i, k));
            arb_neg(arb_mat_entry(phi->b, w->c.follow[i], k), arb_mat_entry(y.b, i, k));
        }
    for (int k = 0; k < d; k++) {
        fmpq_one(fmpq_mat_entry(phi->q, free[k], k));
        arb_one(arb_mat_entry(phi->b, free[k], k));
    }
    linear_matrix_clear(&Jy);
    linear_matrix_clear(&Jr);
    linear_matrix_clear(&y);
    return ok || sga_fail_at(w->err, SGA_E_UNDECIDED, "/linearization/at", "the coordinates could not be shown to be regular at this point; choose another");
}

/* [states | inputs] of a product with the tangent. */
static void split(const struct work *w, const struct linear_matrix *m, struct linear_matrix *left, struct linear_matrix *right)
{
    int states = w->c.states, inputs = w->rq->inputs;
    SGA_ARENA(mem);
    int *col = sga_take(&mem, ((size_t)(states + inputs) + 1) * sizeof *col);
    assert(linear_cols(m) == states + inputs);
    for (int k = 0; k < states + inputs; k++)
        col[k] = k;
    linear_matrix_clear(left);
    linear_matrix_clear(right);
    linear_matrix_columns(left, m, col, states);
    linear_matrix_columns(right, m, col + states, inputs);
}

static bool times_tangent(struct work *w, const expr_id *gradient, int rows, const struct linear_matrix *phi, struct linear_matrix *left,
                          struct linear_matrix *right)
{
    struct linear_matrix d, product;
    bool ok = linear_place_matrix(&w->l->place, gradient, rows, w->g.cols, &d);
    if (ok) {
        linear_matrix_product(&product, &d, phi);
        split(w, &product, left, right);
        linear_matrix_clear(&product);
    }
    linear_matrix_clear(&d);
    return ok;
}

static void gather_rates(struct work *w)
{
    w->rate = sga_zeros(&w->mem, (size_t)w->c.states + 1, sizeof *w->rate);
    for (int k = 0; k < w->c.states; k++)
        w->rate[k] = w->field[w->c.state[k]];
    w->drate = linear_gradients_of(&w->g, &w->mem, w->rate, w->c.states);
}

/* What would need the derivative of a table that is an input. */
static bool check_rates(struct work *w)
{
    const struct linear_request *rq = w->rq;
    const char *name = linear_gradients_rate(rq, w->constraint, rq->sol->constraints);
    name = name ? name : linear_gradients_rate(rq, w->rate, w->c.states);
    name = name ? name : linear_gradients_rate(rq, rq->output, rq->outputs);
    return !name || sga_fail_at(w->err, SGA_E_IMPROPER, "/linearization/inputs", "the derivative of %.100s enters the reduced motion: there is no state form from it "
                                "alone; give that derivative as a table of its own", name);
}

static bool check_smooth(struct work *w)
{
    const struct linear_request *rq = w->rq;
    struct linear_place *p = &w->l->place;
    return (linear_place_smooth(p, w->constraint, rq->sol->constraints) && linear_place_smooth(p, w->rate, w->c.states)
            && linear_place_smooth(p, rq->output, rq->outputs))
        || sga_fail_at(w->err, SGA_E_UNDECIDED, "/linearization/at", "abs, sign, min or max changes its branch at this point, so that there is no one "
                       "linearization; choose a point on one side");
}

/* cone: work. */
static bool has_table(const struct expr_store *st, struct expr_cone *cone, expr_id e)
{
    bool has = false;
    expr_cone_of(st, cone, &e, 1);
    for (int k = 0; k < cone->count && !has; k++) {
        const struct expr_node *n = st->node + cone->list[k];
        has = n->op == EXPR_SYM && st->symbol[n->a].table;
    }
    return has;
}

/* The matrices at the place, which is known. */
static bool state_form(struct work *w)
{
    struct linearization *l = w->l;
    const struct linear_request *rq = w->rq;
    struct linear_matrix J, phi = { .exact = false };
    if (!linear_place_matrix(&l->place, w->dconstraint, rq->sol->constraints, w->g.cols, &J)) {
        linear_matrix_clear(&J);
        return no_value(w, "a constraint has");
    }
    bool ok = linear_coordinates_choose(&w->c, &w->mem, rq, &l->place, &J, w->err);
    w->field = ok ? linear_held_field(&w->mem, rq, &l->place) : NULL;
    if (ok && !w->field)
        ok = sga_fail_at(w->err, SGA_E_UNDECIDED, "/linearization/at", "the motion with the inputs held has no form at this point; choose another");
    if (ok) {
        gather_rates(w);
        ok = check_rates(w) && check_smooth(w) && tangent(w, &J, &phi);
        if (ok)
            ok = (times_tangent(w, w->drate, w->c.states, &phi, &l->A, &l->B) || no_value(w, "the reduced field has"))
              && (times_tangent(w, w->doutput, rq->outputs, &phi, &l->C, &l->D) || no_value(w, "an output has"));
        linear_matrix_clear(&phi);
    }
    linear_matrix_clear(&J);
    return ok;
}

static bool depends_on_time(struct work *w)
{
    const struct sys_system *sys = w->rq->sys;
    const struct sga_solution *sol = w->rq->sol;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    bool depends = sol->depends_on_time;
    expr_cone_init(&cone);
    for (int k = 0; k < w->c.states && !depends; k++)
        depends = expr_depends(sys->store, &cone, w->rate[k], sys->time) || has_table(sys->store, &cone, w->rate[k]);
    for (int i = 0; i < sol->constraints && !depends; i++)
        depends = has_table(sys->store, &cone, sol->constraint[i].expr);
    return depends;
}

/* How far the field is from 0: 0 where it is known to be, INFINITY where it is far. */
static double speed(struct work *w)
{
    struct linear_matrix v;
    double worst = 0;
    bool ok = linear_place_matrix(&w->l->place, w->rate, w->c.states, 1, &v);
    for (int k = 0; k < w->c.states && ok; k++) {
        bool zero = v.exact ? fmpq_is_zero(fmpq_mat_entry(v.q, k, 0)) : arb_is_zero(arb_mat_entry(v.b, k, 0));
        if (!zero)
            worst = fmax(worst, fmax(fabs(linear_matrix_double(&v, k, 0)), 1e-300));
    }
    linear_matrix_clear(&v);
    return ok ? worst : INFINITY;
}

/* The functions that hold at an equilibrium near x: no motion, inputs as they are. */
static int rest(struct work *w, const double *x, expr_id **zero)
{
    struct expr_store *st = w->rq->sys->store;
    int count = 0;
    *zero = sga_take(&w->mem, (size_t)(w->c.states + w->rq->inputs + 1) * sizeof **zero);
    for (int k = 0; k < w->c.states; k++)
        (*zero)[count++] = w->rate[k];
    for (int k = 0; k < w->rq->inputs; k++) {
        SGA_ENDS(fmpq_end) fmpq_t q = { { 0, 1 } };
        int j = w->rq->input[k].variable;
        if (j < 0)
            continue;
        SGA_ENDS(arf_end) arf_t value = { 0 };
        arf_set_d(value, x[j]);
        arf_get_fmpq(q, value);
        (*zero)[count++] = expr_sub(st, st->symbol[w->rq->sys->variable[j].symbol].node, expr_fmpq(st, q));
    }
    return count;
}

/* A start that is at rest to many digits is taken for the equilibrium that is proved to be there. */
static bool settle(struct work *w, const struct linear_guess *guess)
{
    struct linearization *l = w->l;
    double v = speed(w);
    if (guess->zeros && l->place.basis != LINEAR_NUMERIC) {
        l->equilibrium = 1;
        return true;
    }
    l->equilibrium = depends_on_time(w) ? -1 : v == 0 ? 1 : v > AT_REST ? 0 : -1;
    if (l->equilibrium >= 0 || depends_on_time(w))
        return true;
    struct linear_guess at = *guess;
    struct linear_place place;
    expr_id *zero;
    at.x = l->place.x;
    at.zeros = rest(w, at.x, &zero);
    at.zero = zero;
    if (linear_place_find(&place, w->rq->sys, w->rq->sol, &at) && place.basis != LINEAR_NUMERIC) {
        linear_place_clear(&l->place);
        l->place = place;
        l->equilibrium = 1;
        return state_form(w);
    }
    linear_place_clear(&place);
    return true;
}

/* Rows A x' - alpha = 0, then restrictions, as functions of x; v = X in the products. */
static void gather_rows(struct work *w, expr_id *entry, expr_id *gradient)
{
    const struct sys_system *sys = w->rq->sys;
    struct expr_store *st = sys->store;
    int n = sys->variables, cols = w->g.cols;
    for (int i = 0; i < sys->rows; i++) {
        const struct sys_row *r = sys->row + i;
        expr_id *to = gradient + (size_t)i * (size_t)cols;
        memcpy(to, linear_gradients_of(&w->g, &w->mem, &r->alpha, 1), (size_t)cols * sizeof *to);
        for (int k = 0; k < r->entries; k++) {
            entry[(size_t)i * (size_t)n + (size_t)r->entry[k].col] = r->entry[k].value;
            if (expr_is_const(st, r->entry[k].value))
                continue;
            const expr_id *d = linear_gradients_of(&w->g, &w->mem, &r->entry[k].value, 1);
            for (int j = 0; j < cols; j++)
                if (d[j]) {
                    expr_id product = expr_mul(st, d[j], w->field[r->entry[k].col]);
                    to[j] = to[j] ? expr_sub(st, to[j], product) : expr_neg(st, product);
                }
        }
    }
    if (sys->restrictions)
        memcpy(gradient + (size_t)sys->rows * (size_t)cols, linear_gradients_of(&w->g, &w->mem, sys->restriction, sys->restrictions),
               (size_t)sys->restrictions * (size_t)cols * sizeof *gradient);
}

/* Columns of the given equations: variables that are no inputs, and inputs. */
static void port_columns(struct work *w, int *input)
{
    const struct linear_request *rq = w->rq;
    struct linearization *l = w->l;
    int signals = rq->sys->variables;
    l->variable = sga_take(&l->mem, ((size_t)rq->sys->variables + 1) * sizeof *l->variable);
    for (int j = 0; j < rq->sys->variables; j++) {
        bool is_input = false;
        for (int k = 0; k < rq->inputs; k++)
            is_input |= rq->input[k].variable == j;
        if (!is_input)
            l->variable[l->variables++] = j;
    }
    for (int k = 0; k < rq->inputs; k++)
        input[k] = rq->input[k].variable >= 0 ? rq->input[k].variable : signals++;
}

static void take_columns(struct linear_matrix *out, const struct linear_matrix *m, const int *col, int cols)
{
    linear_matrix_clear(out);
    linear_matrix_columns(out, m, col, cols);
}

/* F: columns of E for inputs that are variables, 0 for tables, whose derivatives are none of x'. */
static void take_rates(struct linearization *l, const struct linear_request *rq, const struct linear_matrix *E)
{
    linear_matrix_clear(&l->F);
    linear_matrix_init(&l->F, linear_rows(E), rq->inputs);
    l->F.exact = E->exact;
    for (int k = 0; k < rq->inputs; k++)
        for (int i = 0; i < linear_rows(E) && rq->input[k].variable >= 0; i++) {
            fmpq_set(fmpq_mat_entry(l->F.q, i, k), fmpq_mat_entry(E->q, i, rq->input[k].variable));
            arb_set(arb_mat_entry(l->F.b, i, k), arb_mat_entry(E->b, i, rq->input[k].variable));
            l->rates |= !arb_is_zero(arb_mat_entry(l->F.b, i, k));
        }
}

static bool descriptor_form(struct work *w)
{
    const struct linear_request *rq = w->rq;
    struct linearization *l = w->l;
    int n = rq->sys->variables, cols = w->g.cols;
    l->rows = rq->sys->rows + rq->sys->restrictions;
    expr_id *entry = sga_zeros(&w->mem, (size_t)l->rows * (size_t)n + 1, sizeof *entry);
    expr_id *gradient = sga_zeros(&w->mem, (size_t)l->rows * (size_t)cols + 1, sizeof *gradient);
    int *input = sga_take(&w->mem, ((size_t)rq->inputs + 1) * sizeof *input);
    gather_rows(w, entry, gradient);
    port_columns(w, input);
    struct linear_matrix E, F, out;
    bool ok = linear_place_matrix(&l->place, entry, l->rows, n, &E);
    ok = linear_place_matrix(&l->place, gradient, l->rows, cols, &F) && ok;
    ok = linear_place_matrix(&l->place, w->doutput, rq->outputs, cols, &out) && ok;
    take_columns(&l->E, &E, l->variable, l->variables);
    take_rates(l, rq, &E);
    take_columns(&l->DA, &F, l->variable, l->variables);
    take_columns(&l->DB, &F, input, rq->inputs);
    take_columns(&l->DC, &out, l->variable, l->variables);
    take_columns(&l->DD, &out, input, rq->inputs);
    linear_matrix_clear(&E);
    linear_matrix_clear(&F);
    linear_matrix_clear(&out);
    return ok || no_value(w, "an equation has");
}

/* dz' = A dz + B du + b du' is that of z - b u without du'. */
static bool shift(struct work *w)
{
    struct linearization *l = w->l;
    struct linear_matrix product;
    linear_matrix_clear(&l->shift);
    if (!linear_held_shift(w->rq, &l->place, w->c.state, w->c.states, &l->shift))
        return no_value(w, "a gauge field has");
    l->shifted = true;
    if (!l->motion_constant && l->equilibrium != 1)
        return sga_fail_at(w->err, SGA_E_IMPROPER, "/linearization/inputs", "%.100s moves with the derivative of an input, and the point is not shown to be an "
                           "equilibrium: linearize at one, or take what moves as an input", w->rq->sys->store->symbol[w->rq->sys->variable[w->c.moving].symbol].name);
    linear_matrix_product(&product, &l->A, &l->shift);
    linear_matrix_add(&l->B, &product, false);
    linear_matrix_clear(&product);
    linear_matrix_product(&product, &l->C, &l->shift);
    linear_matrix_add(&l->D, &product, false);
    linear_matrix_clear(&product);
    return true;
}

static void begin(struct work *w)
{
    const struct linear_request *rq = w->rq;
    int c = rq->sol->constraints;
    linear_gradients_init(&w->g, &w->mem, rq);
    w->constraint = sga_take(&w->mem, ((size_t)c + 1) * sizeof *w->constraint);
    for (int i = 0; i < c; i++)
        w->constraint[i] = rq->sol->constraint[i].expr;
    w->dconstraint = linear_gradients_of(&w->g, &w->mem, w->constraint, c);
    w->doutput = linear_gradients_of(&w->g, &w->mem, rq->output, rq->outputs);
}

static void keep_states(struct work *w)
{
    struct linearization *l = w->l;
    l->states = w->c.states;
    l->state = sga_take(&l->mem, ((size_t)l->states + 1) * sizeof *l->state);
    l->rate = sga_take(&l->mem, ((size_t)l->states + 1) * sizeof *l->rate);
    for (int k = 0; k < l->states; k++) {
        l->state[k] = w->c.state[k];
        l->rate[k] = w->rate[k];
    }
}

static void tell_constant(struct work *w)
{
    struct linearization *l = w->l;
    const struct linear_request *rq = w->rq;
    l->motion_constant = linear_gradients_constant(&w->g, w->constraint, rq->sol->constraints, w->dconstraint)
                         && linear_gradients_constant(&w->g, w->rate, w->c.states, w->drate);
    l->constant = l->motion_constant && linear_gradients_constant(&w->g, rq->output, rq->outputs, w->doutput);
    l->everywhere = l->constant && linear_gradients_given(&w->g, rq);
}

static bool run(struct work *w, const struct linear_guess *guess)
{
    struct linearization *l = w->l;
    const struct linear_request *rq = w->rq;
    begin(w);
    if (!linear_place_find(&l->place, rq->sys, rq->sol, guess))
        return sga_fail_at(w->err, SGA_E_UNDECIDED, "/linearization/at", "no point of the final set was found where the start was computed; choose another");
    if (!state_form(w) || !settle(w, guess) || !descriptor_form(w))
        return false;
    tell_constant(w);
    if (w->c.moving >= 0 && !shift(w))
        return false;
    keep_states(w);
    assert(l->states + rq->sol->constraints + (rq->sys->variables - l->variables) == rq->sys->variables);
    return expr_store_ok(rq->sys->store) || sga_fail(w->err, rq->sys->store->error->code, "%s", rq->sys->store->error->detail);
}

static void empty(struct linearization *l)
{
    struct linear_matrix *const all[] = { &l->A, &l->B, &l->C, &l->D, &l->E, &l->F, &l->DA, &l->DB, &l->DC, &l->DD, &l->shift };
    *l = (struct linearization){ .equilibrium = -1 };
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        linear_matrix_init(all[k], 0, 0);
}

static bool fits(const struct linear_request *rq, struct sga_error *err)
{
    return rq->sys->variables <= LINEAR_MOST
        || sga_fail(err, SGA_E_LIMIT_VARIABLES, "the system has %d variables; it is linearized up to %d", rq->sys->variables, LINEAR_MOST);
}

/* Entries, right sides and restrictions, with their gradients: affine right sides, and entries that are numbers. */
static bool given(struct work *w, bool *constant)
{
    const struct linear_request *rq = w->rq;
    const struct sys_system *sys = rq->sys;
    SGA_ARENA(mem);
    expr_id *right = sga_take(&mem, ((size_t)sys->rows + (size_t)sys->restrictions + 1) * sizeof *right);
    int count = sys->rows + sys->restrictions;
    bool numbers = true;
    for (int i = 0; i < sys->rows; i++) {
        right[i] = sys->row[i].alpha;
        for (int k = 0; k < sys->row[i].entries; k++)
            numbers = numbers && expr_is_const(sys->store, sys->row[i].entry[k].value);
    }
    if (sys->restrictions)
        memcpy(right + sys->rows, sys->restriction, (size_t)sys->restrictions * sizeof *right);
    linear_gradients_init(&w->g, &w->mem, rq);
    w->doutput = linear_gradients_of(&w->g, &w->mem, rq->output, rq->outputs);
    *constant = numbers && linear_gradients_affine(&w->g, right, count, linear_gradients_of(&w->g, &w->mem, right, count))
                && linear_gradients_affine(&w->g, rq->output, rq->outputs, w->doutput) && !linear_gradients_rate(rq, right, count)
                && !linear_gradients_rate(rq, rq->output, rq->outputs);
    w->l->place.st = sys->store;
    w->l->motion_constant = w->l->constant = w->l->everywhere = *constant;
    return !*constant || descriptor_form(w);
}

bool linear_given(struct linearization *l, const struct linear_request *rq, bool *constant, struct sga_error *err)
{
    struct work w = { .l = l, .rq = rq, .err = err };
    empty(l);
    bool ok = fits(rq, err) && given(&w, constant);
    sga_arena_end(&w.mem);
    return ok;
}

static bool rates(struct work *w, const struct linear_guess *guess, bool *of_time)
{
    const struct linear_request *rq = w->rq;
    begin(w);
    if (!linear_place_find(&w->l->place, rq->sys, rq->sol, guess))
        return sga_fail_at(w->err, SGA_E_UNDECIDED, "/system", "no point of the final set was found again");
    if (!state_form(w))
        return false;
    tell_constant(w);
    *of_time = depends_on_time(w);
    keep_states(w);
    return expr_store_ok(rq->sys->store) || sga_fail(w->err, rq->sys->store->error->code, "%s", rq->sys->store->error->detail);
}

bool linear_rates(struct linearization *l, const struct linear_request *rq, const struct linear_guess *guess, bool *of_time, struct sga_error *err)
{
    struct work w = { .l = l, .rq = rq, .err = err };
    empty(l);
    bool ok = fits(rq, err) && rates(&w, guess, of_time);
    sga_arena_end(&w.mem);
    return ok;
}

bool linearize(struct linearization *l, const struct linear_request *rq, const struct linear_guess *guess, struct sga_error *err)
{
    struct work w = { .l = l, .rq = rq, .err = err };
    empty(l);
    bool ok = fits(rq, err) && run(&w, guess);
    sga_arena_end(&w.mem);
    return ok;
}

void linearization_clear(struct linearization *l)
{
    struct linear_matrix *const all[] = { &l->A, &l->B, &l->C, &l->D, &l->E, &l->F, &l->DA, &l->DB, &l->DC, &l->DD, &l->shift };
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        linear_matrix_clear(all[k]);
    linear_place_clear(&l->place);
    sga_arena_end(&l->mem);
    *l = (struct linearization){ .states = 0 };
}
