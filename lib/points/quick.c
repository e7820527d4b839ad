/* A tape of the constraints and its Jacobian. */
#include "quick.h"

#include <math.h>
#include <string.h>

#include "error.h"
#include "jacobian.h"
#include "mem.h"
#include "points_space.h"
#include "tape.h"

/* Entries of a row whose largest is outside of this are left to balls: squares of them, and parts of them, are doubles yet. */
static const double SMALLEST = 1e-140, LARGEST = 1e140;

/* Where each entry stands in its row; false where a row has a column there that it has not here. */
static bool find_places(struct points_quick *q, const struct points_jacobian *j)
{
    SGA_ARENA(mem);
    int n = j->space->variables;
    int *at = sga_take(&mem, ((size_t)n + 1) * sizeof *at), *row = sga_take(&mem, ((size_t)n + 1) * sizeof *row);
    for (int v = 0; v < n; v++)
        row[v] = -1;
    for (int i = 0; i < j->space->constraints; i++) {
        for (int k = 0; k < j->cols[i]; k++) {
            row[j->col[i][k]] = i;
            at[j->col[i][k]] = k;
        }
        for (int k = q->slopes->start[i]; k < q->slopes->start[i + 1]; k++) {
            int v = q->slopes->col[k];
            if (v >= n || row[v] != i)
                return false;
            q->place[k] = at[v];
        }
    }
    return true;
}

void points_quick_init(struct points_quick *q, const struct points_jacobian *j)
{
    const struct points_space *s = j->space;
    int n = s->variables, inputs = n + s->parameters + (s->time >= 0);
    *q = (struct points_quick){ .tape = NULL };
    SGA_ARENA(mem);
    int *input = sga_take(&mem, ((size_t)inputs + 1) * sizeof *input), *column = sga_take(&mem, ((size_t)n + 1) * sizeof *column);
    for (int v = 0; v < n; v++) {
        input[v] = s->variable[v];
        column[v] = v;
    }
    for (int i = 0; i < s->parameters; i++)
        input[n + i] = s->parameter[i];
    if (s->time >= 0)
        input[n + s->parameters] = s->time;
    struct sga_error err = { 0 };
    if (!(q->tape = num_tape_new(s->st, s->constraint, s->constraints, input, inputs, &err)))
        return;
    q->slopes = num_jacobian_new(q->tape, column, n);
    q->in = sga_zeros(&q->mem, (size_t)inputs + 1, sizeof *q->in);
    q->value = sga_take(&q->mem, ((size_t)s->constraints + 1) * sizeof *q->value);
    q->entry = sga_take(&q->mem, ((size_t)q->slopes->nnz + 1) * sizeof *q->entry);
    q->place = sga_take(&q->mem, ((size_t)q->slopes->nnz + 1) * sizeof *q->place);
    if (!find_places(q, j))
        points_quick_clear(q);
}

void points_quick_clear(struct points_quick *q)
{
    num_jacobian_free(q->slopes);
    num_tape_free(q->tape);
    sga_arena_end(&q->mem);
    *q = (struct points_quick){ .tape = NULL };
}

bool points_quick_at(struct points_quick *q, const struct points_jacobian *j, const struct points_point *p, double **row)
{
    const struct points_space *s = j->space;
    if (!q->tape)
        return false;
    memcpy(q->in, p->x, (size_t)s->variables * sizeof *q->in);
    if (s->parameters)
        memcpy(q->in + s->variables, p->parameter, (size_t)s->parameters * sizeof *q->in);
    if (s->time >= 0)
        q->in[s->variables + s->parameters] = p->t;
    if (!num_jacobian_eval(q->slopes, q->in, q->value, q->entry))
        return false;
    for (int i = 0; i < s->constraints; i++) {
        double most = 0;
        for (int k = q->slopes->start[i]; k < q->slopes->start[i + 1]; k++)
            most = fabs(q->entry[k]) > most ? fabs(q->entry[k]) : most;
        if (!(most > SMALLEST && most < LARGEST))
            return false;
    }
    for (int i = 0; i < s->constraints; i++) {
        for (int k = 0; k < j->cols[i]; k++)
            row[i][k] = 0;
        for (int k = q->slopes->start[i]; k < q->slopes->start[i + 1]; k++)
            row[i][q->place[k]] = q->entry[k];
    }
    return true;
}
