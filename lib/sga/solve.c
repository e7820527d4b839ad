/* The main loop of the stabilization general algorithm. */
#include "block.h"
#include "state.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "scaling.h"

const char *sga_verdict_text(enum sga_verdict v)
{
    static const char *const text[] = { "unique", "underdetermined", "isolated", "inconsistent" };
    return text[v];
}

void sga_solution_clear(struct sga_solution *sol)
{
    for (int i = 0; i < sol->constraints; i++)
        free(sol->constraint[i].part);
    free(sol->side);
    free(sol->scale);
    free(sol->constraint);
    free(sol->dimension);
    free(sol->pivot);
    free(sol->field);
    free(sol->free_column);
    free(sol->gauge);
    free(sol->branch);
    free(sol->dead);
    free(sol->special);
    free(sol->other);
    free(sol->contradiction_part);
    for (int i = 0; i < sol->vanished_rows; i++)
        free(sol->vanished[i].part);
    free(sol->vanished);
    *sol = (struct sga_solution){ 0 };
}

int sga_stages(const struct sga_solution *sol, int *end)
{
    int stages = 0;
    for (int i = 0; i < sol->constraints; i++)
        if (i + 1 == sol->constraints || sol->constraint[i + 1].generation != sol->constraint[i].generation)
            end[stages++] = i + 1;
    return stages;
}

/* Natural sizes of the variables, where they lie far from 1. */
static int *natural_sizes(const struct sys_system *sys, const int *variable)
{
    struct scaling *w = scaling_new(sys->store, variable, sys->variables);
    int *scale = NULL;
    if (!w)
        return NULL;
    for (int i = 0; i < sys->rows; i++) {
        scaling_sum(w);
        scaling_add(w, sys->row[i].alpha, -1);
        for (int k = 0; k < sys->row[i].entries; k++)
            scaling_add(w, sys->row[i].entry[k].value, sys->row[i].entry[k].col);
    }
    for (int i = 0; i < sys->restrictions; i++) {
        scaling_sum(w);
        scaling_add(w, sys->restriction[i], -1);
    }
    scale = scaling_solve(w);
    scaling_free(w);
    return scale;
}

static void state_init(struct state *s, const struct sys_system *sys, const struct sga_options *options,
                       struct points_shadow *shadow, struct route *route, struct sga_solution *sol, struct sga_error *err)
{
    int n = sys->variables;
    struct expr_store *st = sys->store;
    *s = (struct state){ .sys = sys, .options = options, .st = st, .shadow = shadow, .sol = sol, .err = err,
                         .route = route };
    *sol = (struct sga_solution){ 0 };
    expr_flow_init(&s->flow, st);
    expr_facts_init(&s->facts);
    expr_cone_init(&s->cone);
    ech_init(&s->ech, n);
    s->parameter_symbol = sys->parameter;
    s->variable = sga_malloc((size_t)n * sizeof *s->variable);
    s->column = sga_malloc((size_t)st->symbols * sizeof *s->column);
    for (int i = 0; i < st->symbols; i++)
        s->column[i] = -1;
    for (int j = 0; j < n; j++) {
        s->variable[j] = sys->variable[j].symbol;
        s->column[s->variable[j]] = j;
    }
    s->determined = sga_calloc((size_t)n, 1);
    s->space = (struct points_space){
        .st = st, .variable = s->variable, .variables = n, .parameter = sys->parameter,
        .parameters = sys->parameters, .time = sys->time, .near = options->near,
        .near_time = options->near_time, .budget = options->budget,
    };
    s->space.scale = sol->scale = natural_sizes(sys, s->variable);
    s->ctx = (struct ech_context){ .st = st, .facts = &s->facts, .shadow = shadow, .budget = options->budget,
                                   .record = options->combinations, .err = err };
}

static void state_clear(struct state *s)
{
    expr_flow_clear(&s->flow);
    expr_facts_clear(&s->facts);
    expr_cone_clear(&s->cone);
    ech_clear(&s->ech);
    free(s->variable);
    free(s->column);
    free(s->determined);
    free(s->active);
    free(s->solved);
    free(s->con);
    free(s->assumed);
}

static struct ech_row *system_rows(struct state *s, int extra)
{
    struct ech_row *row = sga_calloc((size_t)(s->sys->rows + extra + 1), sizeof *row);
    for (int i = 0; i < s->sys->rows; i++) {
        row[i].source = i;
        row[i].rhs = s->sys->row[i].alpha;
        for (int k = 0; k < s->sys->row[i].entries; k++)
            ech_row_push(row + i, s->sys->row[i].entry[k].col, s->sys->row[i].entry[k].value);
    }
    return row;
}

/* Rows that ended without entries and with a right side that is not zero become
 * candidates for generation g. */
static int harvest(struct state *s, struct ech_row *row, int rows, struct candidate **cand)
{
    int count = 0;
    *cand = sga_malloc((size_t)(rows + 1) * sizeof **cand);
    for (int i = 0; i < rows; i++) {
        struct ech_row *r = row + i;
        if (!r->rhs || r->entries)
            continue;
        if (expr_is_zero(s->st, r->rhs))
            continue;
        struct candidate c = { .expr = r->rhs, .base = r->rhs, .origin = SGA_FROM_ROWS, .source = r->source, .restriction = -1,
                               .op = r->op, .ops = r->ops };
        if (r->source >= s->sys->rows) {
            const struct sga_constraint *from = s->sol->constraint + (r->source - s->sys->rows);
            c.expr = c.base = expr_neg(s->st, r->rhs);
            /* the first few derivatives are taken one by one: their texts are nicer */
            bool deep = from->generation > 3;
            if (deep && !r->ops && !expr_flow_tainted(&s->flow, from->expr) && from->order < 18) {
                c.base = from->base;
                c.order = from->order + 1;
            }
        }
        (*cand)[count++] = c;
    }
    return count;
}

static void free_rows(struct ech_row *row, int rows)
{
    for (int i = 0; i < rows; i++)
        ech_row_clear(row + i);
    free(row);
}

/* By source: 1 where some constraint rests on the row, as its origin or in its combination. */
static unsigned char *rows_used(const struct sga_solution *sol, int rows)
{
    unsigned char *used = sga_calloc((size_t)(rows + sol->constraints) + 1, 1);
    for (int i = 0; i < sol->constraints; i++) {
        const struct sga_constraint *c = sol->constraint + i;
        if (c->source >= 0)
            used[c->source] = 1;
        for (int k = 0; k < c->parts; k++)
            if (c->part[k].row >= 0)
                used[c->part[k].row] = 1;
    }
    return used;
}

/* Rows that ended without entries and gave no constraint, after the candidates of
 * generation g were admitted; the elimination was done on P_before. Those that earlier eliminations used are no consequences:
 * where a pivot died in between, rows may have changed their places. */
static void note_vanished(struct state *s, const struct ech_row *row, int rows, int before, int g)
{
    struct sga_solution *sol = s->sol;
    unsigned char *used = rows_used(sol, s->sys->rows);
    for (int i = 0; i < rows; i++) {
        const struct ech_row *r = row + i;
        bool own = r->source < s->sys->rows;
        if (!r->rhs || r->entries || (!own && !s->options->rows))
            continue;
        if (used[r->source] || (own && s->restarted && (s->blocks_lost || !s->options->combinations)))
            continue;
        sol->redundant_rows += own;
        if (!s->options->rows)
            continue;
        bool zero = expr_is_zero(s->st, r->rhs);
        SGA_RESERVE(sol->vanished, s->vanished_cap, sol->vanished_rows + 1);
        struct sga_vanished *v = sol->vanished + sol->vanished_rows++;
        *v = (struct sga_vanished){ .source = r->source, .generation = zero ? before : g,
                                    .rest = !zero ? r->rhs : r->rest ? r->rest : r->rhs };
        struct candidate c = { .expr = v->rest, .source = r->source, .restriction = -1, .op = r->op, .ops = r->ops };
        state_combine(s, &c, &v->part, &v->parts);
    }
    free(used);
}

/* Every pivot so far, asked again at the points of the smaller set: 1 all stand, 0 one
 * died, -1 undecided. */
static int pivots_stand(struct state *s)
{
    for (int q = 0; q < s->ech.pivots; q++) {
        int z = ech_zero(&s->ctx, s->ech.pivot[q].value);
        if (z)
            return z < 0 ? -1 : 0;
    }
    return ech_blocks_stand(&s->ech, s->shadow);
}

/* Begin the echelon form anew: all rows are pending again. */
static void forget_pivots(struct state *s)
{
    struct sga_solution *sol = s->sol;
    sol->dead = sga_realloc(sol->dead, (size_t)(sol->deads + s->ech.pivots + 1) * sizeof *sol->dead);
    for (int q = 0; q < s->ech.pivots; q++)
        if (!expr_is_const(s->st, s->ech.pivot[q].value))
            sol->dead[sol->deads++] = (struct sga_pivot){ s->ech.pivot[q].col, s->ech.pivot[q].value,
                                                          s->ech.pivot[q].generation, s->ech.pivot[q].row.source };
    s->blocks_lost |= s->ech.blocks > 0;
    ech_clear(&s->ech);
    ech_init(&s->ech, s->sys->variables);
    s->started = false;
    s->restarted = true;
    while (s->sol->vanished_rows)
        free(s->sol->vanished[--s->sol->vanished_rows].part);
    expr_flow_clear(&s->flow);
    expr_flow_init(&s->flow, s->st);
    memset(s->determined, 0, (size_t)s->sys->variables);
    for (int i = 0; i < s->sol->constraints; i++) {
        s->sol->constraint[i].base = s->sol->constraint[i].expr;
        s->sol->constraint[i].order = 0;
    }
}

/* One elimination of the tangency rows of constraints from..to-1, with the system's rows
 * before them where the echelon form is empty; what comes out is admitted as generation g.
 * Returns how many constraints were added, or -1. */
static int round_of(struct state *s, int from, int to, int g)
{
    int rows = 0, added = -1, last = s->sol->constraints;
    int before = last ? s->sol->constraint[last - 1].generation : 0;
    struct ech_row *row;
    if (!s->started) {
        row = system_rows(s, to - from);
        rows = s->sys->rows;
        s->sol->redundant_rows = 0;
        s->started = true;
    } else {
        row = sga_calloc((size_t)(to - from) + 1, sizeof *row);
    }
    for (int i = from; i < to; i++)
        state_tangency(s, i, row + rows++);
    if (ech_eliminate(&s->ech, &s->ctx, row, rows, g)) {
        state_determine(s);
        struct candidate *cand;
        int count = harvest(s, row, rows, &cand);
        added = state_admit(s, cand, count, g);
        if (added >= 0 && !s->inconsistent)
            note_vanished(s, row, rows, before, g);
        free(cand);
    }
    free_rows(row, rows);
    if (added >= 0 && !expr_store_ok(s->st)) {
        *s->err = s->st->error;
        return -1;
    }
    return added;
}

/* P_g from the rows of the system and the tangency to the first `to` constraints (those
 * before `from` are in the echelon form already). On the smaller set a pivot may vanish:
 * then the same rows say more there, and that belongs to the same P_g. */
static int generation(struct state *s, int from, int to, int g)
{
    int added = round_of(s, from, to, g), more = added;
    while (more > 0 && !s->inconsistent) {
        int stand = pivots_stand(s);
        if (stand < 0)
            return -1;
        if (stand)
            break;
        forget_pivots(s);
        more = round_of(s, 0, to, g);
        if (more < 0)
            return -1;
        added += more;
    }
    return more < 0 ? -1 : added;
}

static void note_dimension(struct state *s)
{
    struct sga_solution *sol = s->sol;
    sol->dimension = sga_realloc(sol->dimension, (size_t)(sol->generations + 1) * sizeof *sol->dimension);
    sol->dimension[sol->generations++] = s->sys->variables - sol->constraints;
}

static bool depends_on_time(struct state *s)
{
    unsigned f = 0;
    for (int i = 0; i < s->sys->rows; i++) {
        f |= expr_facts_of(&s->facts, s->st, s->sys->row[i].alpha);
        for (int k = 0; k < s->sys->row[i].entries; k++)
            f |= expr_facts_of(&s->facts, s->st, s->sys->row[i].entry[k].value);
    }
    for (int i = 0; i < s->sol->constraints; i++)
        f |= expr_facts_of(&s->facts, s->st, s->con[i]);
    return f & EXPR_HAS_TIME;
}

/* Whether everything in the system has a value at the present points. */
static bool in_domain(struct state *s)
{
    for (int k = 0; k < s->shadow->reals; k++) {
        struct num_ball *b = &s->shadow->real[k].ball;
        num_ball_extend(b);
        for (int i = 0; i < s->sys->rows; i++) {
            const struct sys_row *r = s->sys->row + i;
            bool ok = arb_is_finite(num_ball_value(b, r->alpha));
            for (int q = 0; q < r->entries && ok; q++)
                ok = arb_is_finite(num_ball_value(b, r->entry[q].value));
            if (!ok)
                return false;
        }
        for (int i = 0; i < s->sys->restrictions; i++)
            if (!arb_is_finite(num_ball_value(b, s->sys->restriction[i])))
                return false;
    }
    return true;
}

enum { DOMAIN_TRIES = 64 };

static bool start(struct state *s, int *added)
{
    enum points_status status = state_sample(s);
    for (int k = 0; k < DOMAIN_TRIES && status == POINTS_OK && !in_domain(s); k++) {
        points_shadow_forget(s->shadow);
        status = state_sample(s);
    }
    if (status == POINTS_STOPPED)
        return sga_budget_ok(s->options->budget, s->err);
    if (status != POINTS_OK)
        return sga_fail(s->err, SGA_E_INTERNAL, "no point of the whole space could be made");
    int n = s->sys->restrictions;
    struct candidate *cand = sga_calloc((size_t)n + 1, sizeof *cand);
    for (int i = 0; i < n; i++)
        cand[i] = (struct candidate){ .expr = s->sys->restriction[i], .base = s->sys->restriction[i],
                                      .origin = SGA_FROM_RESTRICTION, .source = -1, .restriction = i };
    *added = n ? state_admit(s, cand, n, 1) : 0;
    free(cand);
    return *added >= 0;
}

static bool run(struct state *s)
{
    int limit = s->options->budget && s->options->budget->max_generations ? s->options->budget->max_generations : 1000;
    int added = 0, more, done = 0;
    if (!start(s, &added))
        return false;
    if (s->inconsistent) {
        s->sol->empty_restriction = true;
        return true;
    }
    more = generation(s, 0, 0, 1);      /* compatibility on the zero set of the restriction */
    if (more < 0)
        return false;
    for (added += more; added && !s->inconsistent; ) {
        note_dimension(s);
        if (s->sol->generations >= limit)
            return sga_fail(s->err, SGA_E_LIMIT_GENERATIONS,
                            "after %d generations new constraints still appear; the limit is limits.generations", limit);
        int from = done;
        done = s->sol->constraints;
        added = generation(s, from, done, s->sol->generations + 1);
        if (added < 0)
            return false;
    }
    if (!s->inconsistent)
        state_fields(s);
    return true;
}

/* A contradiction that rests on one side of a surface says nothing of the other. */
static bool contradiction_on_side(struct state *s)
{
    const struct points_side *side = s->shadow->side;
    char *text = state_text(s, side->function);
    sga_fail(s->err, SGA_E_SPLIT, "where %s %s 0 the equations contradict each other; what holds on the other side was not "
             "looked at; give trajectory.initial there, or write the system for the side that is meant", text, side->sign > 0 ? ">" : "<");
    free(text);
    return false;
}

static void conclude(struct state *s)
{
    struct sga_solution *sol = s->sol;
    if (s->inconsistent) {
        sol->verdict = SGA_INCONSISTENT;
    } else {
        sol->depends_on_time = depends_on_time(s);
        bool point = sol->constraints == s->sys->variables;
        sol->verdict = sol->free_columns ? SGA_UNDERDETERMINED
                       : point && !sol->depends_on_time ? SGA_ISOLATED : SGA_UNIQUE;
    }
    sol->dense_blocks = s->ech.blocks;
    sol->sides = s->shadow->sides;
    if (sol->sides)
        sol->side = memcpy(sga_malloc((size_t)sol->sides * sizeof *sol->side), s->shadow->side, (size_t)sol->sides * sizeof *sol->side);
    sol->pivot = sga_malloc((size_t)(s->ech.pivots + s->assumptions + 1) * sizeof *sol->pivot);
    for (int q = 0; q < s->ech.pivots; q++)
        sol->pivot[sol->pivots++] = (struct sga_pivot){ s->ech.pivot[q].col, s->ech.pivot[q].value,
                                                        s->ech.pivot[q].generation, s->ech.pivot[q].row.source };
    for (int q = 0; q < s->assumptions; q++)
        sol->pivot[sol->pivots++] = (struct sga_pivot){ -1, s->assumed[q], 0, -1 };
}

bool state_solve(const struct sys_system *system, const struct sga_options *options, struct points_shadow *shadow,
                 struct route *route, struct sga_solution *solution, struct sga_error *err)
{
    struct state s;
    state_init(&s, system, options, shadow, route, solution, err);
    shadow->sides = 0;
    bool ok = run(&s);
    if (ok && !expr_store_ok(s.st)) {
        *err = s.st->error;
        ok = false;
    }
    if (ok && s.inconsistent && shadow->sides)
        ok = contradiction_on_side(&s);
    if (ok)
        conclude(&s);
    else if (!err->stage[0])
        memcpy(err->stage, "sga", 4);
    state_clear(&s);
    return ok;
}
