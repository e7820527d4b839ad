/* The rules of a solution. */
#include "reduction.h"
#include "system.h"

static bool parts_sane(const struct sys_system *sys, const struct sga_part *part, int parts, int constraints)
{
    bool sane = true;
    for (int k = 0; k < parts && sane; k++)
        sane = part[k].factor > 0 && (part[k].row >= 0 ? part[k].row < sys->rows : part[k].tangency >= 0 && part[k].tangency < constraints);
    return sane;
}

static bool constraints_sane(const struct sys_system *sys, const struct sga_solution *s)
{
    bool sane = true;
    for (int i = 0; i < s->constraints && sane; i++) {
        const struct sga_constraint *c = s->constraint + i;
        sane = c->expr > 0 && c->expr < sys->store->nodes && c->generation >= (i ? s->constraint[i - 1].generation : 1)
               && c->generation <= s->generations + (s->verdict == SGA_INCONSISTENT) && c->restriction < sys->restrictions + s->specials && parts_sane(sys, c->part, c->parts, s->constraints);
    }
    return sane;
}

static bool dimensions_sane(const struct sys_system *sys, const struct sga_solution *s)
{
    bool sane = true;
    for (int k = 0; k < s->generations && sane; k++)
        sane = s->dimension[k] < (k ? s->dimension[k - 1] : sys->variables) && (s->dimension[k] >= 0 || s->verdict == SGA_INCONSISTENT);
    return sane;
}

bool sga_solution_sane(const struct sys_system *sys, const struct sga_solution *s)
{
    bool sane = s->constraints >= 0 && s->constraints <= sys->variables + (s->verdict == SGA_INCONSISTENT) && constraints_sane(sys, s)
                && dimensions_sane(sys, s);
    for (int q = 0; q < s->pivots && sane; q++)
        sane = s->pivot[q].col < sys->variables && s->pivot[q].value > 0 && s->pivot[q].value < sys->store->nodes;
    for (int k = 0; k < s->free_columns && sane; k++)
        sane = s->free_column[k] >= 0 && s->free_column[k] < sys->variables;
    for (int j = 0; j < sys->variables && sane && s->field; j++)
        sane = s->field[j] > 0 && s->field[j] < sys->store->nodes;
    return sane && (s->verdict != SGA_UNIQUE || !s->free_columns);
}

bool sga_solution_same_kind(const struct sga_solution *a, const struct sga_solution *b)
{
    if (!a->generations != !b->generations || (a->generations && a->dimension[a->generations - 1] != b->dimension[b->generations - 1]))
        return false;
    return a->verdict == b->verdict && a->constraints == b->constraints && a->free_columns == b->free_columns && !b->specials && a->sides == b->sides;
}
