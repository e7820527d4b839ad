/* One generation: elimination of the tangency rows, what comes out as constraints, and the same
 * again where a pivot died on the smaller set. */
#include "block.h"
#include "derive.h"
#include "state.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "primitive.h"
#include "reduction.h"
#include "system.h"

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
        assert(r->source >= 0 && r->source < s->sys->rows + s->sol->constraints);
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
            if (deep && !r->ops && !expr_flow_tainted(s->flow, from->expr) && from->order < 18) {
                c.base = from->base;
                c.order = from->order + 1;
            }
        }
        primitive_candidate(s, &c);
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
    SGA_FREED unsigned char *used = rows_used(sol, s->sys->rows);
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
        *v = (struct sga_vanished){ .source = r->source, .generation = zero ? before : g, .epoch = s->epoch,
                                    .rest = !zero ? r->rhs : r->rest ? r->rest : r->rhs };
        struct candidate c = { .expr = v->rest, .source = r->source, .restriction = -1, .op = r->op, .ops = r->ops };
        state_combine(s, &c, &v->part, &v->parts);
    }
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
    return ech_blocks_stand(&s->ech, s->oracle);
}

void state_clear_waiting(struct state *s)
{
    free_rows(s->waiting, s->waitings);
    s->waiting = NULL;
    s->waitings = 0;
}

/* Rows that were left with entries, after an elimination. */
static void keep_waiting(struct state *s, struct ech_row *row, int rows)
{
    assert(!s->waitings);
    s->waiting = sga_calloc((size_t)rows + 1, sizeof *s->waiting);
    for (int i = 0; i < rows; i++)
        if (row[i].entries) {
            s->waiting[s->waitings++] = row[i];
            row[i] = (struct ech_row){ 0 };
        }
}

/* Begin the echelon form anew: all rows are pending again. */
static void forget_pivots(struct state *s)
{
    assert(ech_sane(&s->ech));
    struct sga_solution *sol = s->sol;
    sol->dead = sga_realloc(sol->dead, (size_t)(sol->deads + s->ech.pivots + 1) * sizeof *sol->dead);
    for (int q = 0; q < s->ech.pivots; q++)
        if (!expr_is_const(s->st, s->ech.pivot[q].value))
            sol->dead[sol->deads++] = (struct sga_pivot){ s->ech.pivot[q].col, s->ech.pivot[q].value,
                                                          s->ech.pivot[q].generation, s->ech.pivot[q].row.source };
    s->blocks_lost |= s->ech.blocks > 0;
    state_clear_waiting(s);
    ech_clear(&s->ech);
    ech_init(&s->ech, s->sys->variables);
    s->started = false;
    s->restarted = true;
    s->epoch++;
    while (s->sol->vanished_rows)
        free(s->sol->vanished[--s->sol->vanished_rows].part);
    expr_flow_clear(s->flow);
    expr_flow_init(s->flow, s->st);
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
        assert(!s->waitings);
    } else {
        row = sga_calloc((size_t)(s->waitings + to - from) + 1, sizeof *row);
        for (; rows < s->waitings; rows++)
            row[rows] = s->waiting[rows];
        s->waitings = 0;
        state_clear_waiting(s);
    }
    state_open_columns(s);
    for (int i = from; i < to; i++)
        state_tangency(s, i, row + rows++);
    if (ech_eliminate(&s->ech, &s->ctx, row, rows, g)) {
        state_determine(s, g);
        SGA_FREED struct candidate *cand = NULL;
        int count = harvest(s, row, rows, &cand);
        added = state_admit(s, cand, count, g);
        if (added >= 0 && !s->inconsistent)
            note_vanished(s, row, rows, before, g);
    }
    keep_waiting(s, row, rows);
    free_rows(row, rows);
    if (added >= 0 && !expr_store_ok(s->st)) {
        *s->err = *s->st->error;
        return -1;
    }
    return added;
}

/* Nothing is left to wait for. */
static int last_round(struct state *s, int to, int g)
{
    s->ctx.wait = false;
    int added = round_of(s, to, to, g);
    s->ctx.wait = s->ctx.near_pivots;
    assert(added < 0 || !s->waitings);
    return added;
}

int state_generation(struct state *s, int from, int to, int g)
{
    assert(from <= to && to <= s->sol->constraints);
    assert(g >= 1);
    int added = round_of(s, from, to, g);
    if (!added && s->waitings && !s->inconsistent)
        added = last_round(s, to, g);
    int more = added;
    while (more > 0 && !s->inconsistent) {
        int stand = pivots_stand(s);
        if (stand < 0)
            return -1;
        if (stand)
            break;
        forget_pivots(s);
        more = round_of(s, 0, to, g);
        if (!more && s->waitings && !s->inconsistent)
            more = last_round(s, to, g);
        if (more < 0)
            return -1;
        added += more;
    }
    return more < 0 ? -1 : added;
}
