/* Every variable that an equation gives, without a way back to itself: values stay as their rows have them while they are looked for, and each
 * is put into the others once, in an order in which that is enough. */
#include "definition_search.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "budget.h"
#include "system.h"

/* Adds a definition to those that a search is to look at. True: the other search has met it too. */
static bool reach(const struct definition_search *s, struct definition_reach *r, const struct definition_reach *other, int definition)
{
    if (definition < 0 || r->seen[definition] == s->turn)
        return false;
    r->seen[definition] = s->turn;
    r->stack[r->depth++] = definition;
    return other->seen[definition] == s->turn;
}

/* The definitions of what the row has. */
static bool reach_parts(struct definition_search *s, int row)
{
    bool met = false;
    for (int k = s->first[row]; k < s->first[row + 1] && !met; k++)
        met = reach(s, &s->down, &s->up, s->by[s->variable[k]]);
    return met;
}

/* The definitions whose rows have v. */
static bool reach_users(struct definition_search *s, int v)
{
    bool met = false;
    for (int k = s->meet[v]; k < s->meet[v + 1] && !met; k++)
        met = reach(s, &s->up, &s->down, s->defines[s->row[k]]);
    return met;
}

/* What the row leads to and what leads to v are looked for in turn, until they meet or one of them has no more: the smaller one counts. */
bool definition_comes_back(struct definition_search *s, int row, int v)
{
    if (!s->by)
        return false;
    s->turn++;
    s->down.depth = s->up.depth = 0;
    bool back = reach_users(s, v) || reach_parts(s, row);
    while (!back && s->down.depth && s->up.depth) {
        int down = s->down.stack[--s->down.depth], up = s->up.stack[--s->up.depth];
        back = reach_parts(s, s->d->at[down].row) || reach_users(s, s->d->at[up].variable);
    }
    return back;
}

/* Which of these rows variables are in. */
static void list_rows(struct definition_search *s)
{
    int n = s->sys->variables, rows = s->sys->rows, count = s->first[rows];
    s->meet = sga_zeros(&s->mem, (size_t)n + 2, sizeof *s->meet);
    s->row = sga_take(&s->mem, ((size_t)count + 1) * sizeof *s->row);
    for (int k = 0; k < count; k++)
        s->meet[s->variable[k] + 2]++;
    for (int j = 0; j < n; j++)
        s->meet[j + 2] += s->meet[j + 1];
    for (int i = 0; i < rows; i++)
        for (int k = s->first[i]; k < s->first[i + 1]; k++)
            s->row[s->meet[s->variable[k] + 1]++] = i;
}

/* Which variables the rows without derivatives have. */
static void list_variables(struct definition_search *s)
{
    int n = s->sys->variables, rows = s->sys->rows, count = 0;
    size_t cap = 0;
    s->by = sga_take(&s->mem, ((size_t)n + 1) * sizeof *s->by);
    s->first = sga_zeros(&s->mem, (size_t)rows + 2, sizeof *s->first);
    s->defines = sga_take(&s->mem, ((size_t)rows + 1) * sizeof *s->defines);
    for (struct definition_reach *r = &s->down; r; r = r == &s->down ? &s->up : NULL) {
        r->seen = sga_zeros(&s->mem, (size_t)rows + 1, sizeof *r->seen);
        r->stack = sga_take(&s->mem, ((size_t)rows + 1) * sizeof *r->stack);
    }
    for (int j = 0; j < n; j++)
        s->by[j] = -1;
    for (int i = 0; i < rows; i++) {
        s->first[i] = count;
        s->defines[i] = -1;
        expr_cone_of(s->st, &s->cone, s->alpha + i, s->used[i] ? 0 : 1);
        for (int k = 0; k < s->cone.count; k++) {
            int symbol = expr_op_of(s->st, s->cone.list[k]) == EXPR_SYM ? s->st->node[s->cone.list[k]].a : -1;
            if (symbol < 0 || s->column[symbol] < 0)
                continue;
            SGA_RESERVE_IN(&s->mem, s->variable, cap, count + 1);
            s->variable[count++] = s->column[symbol];
        }
    }
    s->first[rows] = count;
    list_rows(s);
}

/* One more, its value as its row has it. */
static void note(struct definition_search *s, struct definition now)
{
    assert(s->by[now.variable] < 0 && !s->used[now.row]);
    struct definitions *d = s->d;
    SGA_RESERVE_IN(&d->mem, d->at, d->cap, d->count + 1);
    s->by[now.variable] = s->defines[now.row] = d->count;
    d->at[d->count++] = now;
    s->used[now.row] = 1;
    s->moves[now.variable] = 1;
}

/* One that this one uses and that is not final; -1: none. next: where to look on, by definition. */
static int open_part(struct definition_search *s, int at, const unsigned char *final, int *next)
{
    while (next[at] < s->first[s->d->at[at].row + 1]) {
        int q = s->by[s->variable[next[at]++]];
        if (q >= 0 && q != at && !final[q])
            return q;
    }
    return -1;
}

/* Values free of all that is defined, each after those that it uses. */
static void resolve(struct definition_search *s)
{
    struct definitions *d = s->d;
    SGA_ARENA(mem);
    unsigned char *final = sga_zeros(&mem, (size_t)d->count + 1, 1);
    int *next = sga_take(&mem, ((size_t)d->count + 1) * sizeof *next), *stack = s->down.stack;
    for (int i = 0; i < d->count; i++)
        next[i] = s->first[d->at[i].row];
    for (int i = 0; i < d->count; i++) {
        int depth = 0;
        stack[depth++] = i;
        while (depth) {
            int at = stack[depth - 1], part = final[at] ? -1 : open_part(s, at, final, next);
            if (part >= 0) {
                assert(depth < d->count);
                stack[depth++] = part;
                continue;
            }
            depth--;
            if (final[at])
                continue;
            expr_substitute(s->st, &d->at[at].value, 1, s->map);
            s->map[s->sys->variable[d->at[at].variable].symbol] = d->at[at].value;
            final[at] = 1;
        }
    }
}

void definition_all(struct definition_search *s)
{
    list_variables(s);
    for (int i = 0; i < s->sys->rows && sga_budget_ok(s->budget, NULL) && expr_store_ok(s->st); i++) {
        struct definition now = { 0 };
        if (!s->used[i] && definition_by(s, i, &now))
            note(s, now);
    }
    resolve(s);
}
