/* Free initial values: Pf is locally the graph of a map from the free ones to the others
 * where the constraints' differential with respect to the others is regular. The others
 * are taken greedily, column by column in the order of preference (the greedy basis of a
 * matroid is the best one), by elimination in doubles; a proof in balls decides. */
#include "structure_work.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "differentials.h"
#include "kinds.h"
#include "mem.h"
#include "regular_columns.h"
#include "structure.h"
#include "system.h"

enum { FEW = 200 };       /* constraints: beyond, a proof by a singular value costs less than an elimination in balls */

/* What is solved for first: multipliers and other variables whose derivative no equation asks for, then velocities,
 * coordinates last; of each those that a form added before those that the user named, then the last by name, so that the
 * choice is the same in every order of the variables. */
static int *preference(const struct sys_system *sys)
{
    SGA_ARENA(mem);
    int n = sys->variables, count = 0, *by_name = sga_take(&mem, ((size_t)n + 1) * sizeof *by_name);
    unsigned char *kind = sga_zeros(&mem, (size_t)n + 1, 1);
    int *order = sga_malloc(((size_t)n + 1) * sizeof *order);
    sys_kinds(sys, kind);
    sys_by_name(sys, by_name);
    for (int class = 0; class < 6; class++)
        for (int i = n - 1; i >= 0; i--) {
            int j = by_name[i], late = kind[j] == SYS_COORDINATE ? 2 : kind[j] == SYS_VELOCITY;
            bool own = strcmp(sys->variable[j].role, "variable") == 0 || strcmp(sys->variable[j].role, "coordinate") == 0;
            if (class == 2 * late + own)
                order[count++] = j;
        }
    return order;
}

/* Sparse columns of the differentials, rows scaled to 1. */
struct columns {
    int *first, *row;
    double *value;
};

static void gather(struct sga_arena *mem, struct columns *a, const struct points_jacobian *j, int n)
{
    int c = j->space->constraints, total = 0;
    a->first = sga_zeros(mem, (size_t)n + 2, sizeof *a->first);
    for (int i = 0; i < c; i++)
        for (int k = 0; k < j->cols[i]; k++, total++)
            a->first[j->col[i][k] + 2]++;
    a->row = sga_take(mem, ((size_t)total + 1) * sizeof *a->row);
    a->value = sga_take(mem, ((size_t)total + 1) * sizeof *a->value);
    for (int k = 2; k <= n + 1; k++)
        a->first[k] += a->first[k - 1];
    for (int i = 0; i < c; i++) {
        slong e = -(WORD_MAX / 4);
        for (int k = 0; k < j->cols[i]; k++)
            if (!arf_is_zero(arb_midref(j->entry[i] + k)) && arb_is_finite(j->entry[i] + k)) {
                slong x = num_ball_log2(arb_midref(j->entry[i] + k));
                e = x > e ? x : e;
            }
        for (int k = 0; k < j->cols[i]; k++) {
            SGA_ENDS(arf_end) arf_t t = { 0 };
            arf_mul_2exp_si(t, arb_midref(j->entry[i] + k), -e);
            int at = a->first[j->col[i][k] + 1]++;
            a->row[at] = i;
            a->value[at] = arb_is_finite(j->entry[i] + k) ? arf_get_d(t, ARF_RND_NEAR) : 0;
        }
    }
}

/* One step of the elimination: the column, cleared by the earlier steps, over its pivot. */
struct step {
    int row, *at, count;
    double *factor;
};

/* Steps whose pivot rows the column meets, in order: a binary heap of step numbers. */
static void heap_push(int *heap, int *count, int v)
{
    int i = (*count)++;
    for (; i && heap[(i - 1) / 2] > v; i = (i - 1) / 2)
        heap[i] = heap[(i - 1) / 2];
    heap[i] = v;
}

static int heap_pop(int *heap, int *count)
{
    int top = heap[0], v = heap[--*count], i = 0;
    for (;;) {
        int k = 2 * i + 1;
        if (k + 1 < *count && heap[k + 1] < heap[k])
            k++;
        if (k >= *count || heap[k] >= v)
            break;
        heap[i] = heap[k];
        i = k;
    }
    heap[i] = v;
    return top;
}

/* variable[i] for constraint i, and the constraints in the order of the steps: greedy by
 * `order`. Returns how many were found. */
static int choose(const struct columns *a, const int *order, int n, int c, int *variable, int *sequence)
{
    SGA_ARENA(mem);
    struct step *step = sga_zeros(&mem, (size_t)c + 1, sizeof *step);
    int *step_of = sga_take(&mem, ((size_t)c + 1) * sizeof *step_of), *list = sga_take(&mem, ((size_t)c + 1) * sizeof *list);
    int *heap = sga_take(&mem, ((size_t)c + 1) * sizeof *heap);
    double *work = sga_zeros(&mem, (size_t)c + 1, sizeof *work);
    unsigned char *mark = sga_zeros(&mem, (size_t)c + 1, 1);
    int found = 0;
    for (int i = 0; i < c; i++)
        step_of[i] = variable[i] = -1;
    for (int q = 0; q < n && found < c; q++) {
        int j = order[q], count = 0, heaped = 0, best = -1;
        double size = 0;
        for (int k = a->first[j]; k < a->first[j + 1]; k++) {
            int i = a->row[k];
            work[i] = a->value[k];
            size = fmax(size, fabs(work[i]));
            mark[i] = 1;
            list[count++] = i;
            if (step_of[i] >= 0)
                heap_push(heap, &heaped, step_of[i]);
        }
        while (heaped) {
            const struct step *s = step + heap_pop(heap, &heaped);
            double f = work[s->row];
            for (int k = 0; k < s->count && f != 0; k++) {
                int i = s->at[k];
                if (!mark[i]) {
                    mark[i] = 1;
                    work[i] = 0;
                    list[count++] = i;
                    if (step_of[i] >= 0)
                        heap_push(heap, &heaped, step_of[i]);
                }
                work[i] -= f * s->factor[k];
            }
        }
        for (int k = 0; k < count; k++)
            if (step_of[list[k]] < 0 && (best < 0 || fabs(work[list[k]]) > fabs(work[best])))
                best = list[k];
        if (best >= 0 && fabs(work[best]) > 1e-10 * size && work[best] != 0) {
            struct step *s = step + found;
            s->row = best;
            s->at = sga_take(&mem, (size_t)count * sizeof *s->at);
            s->factor = sga_take(&mem, (size_t)count * sizeof *s->factor);
            for (int k = 0; k < count; k++)
                if (list[k] != best && step_of[list[k]] < 0 && work[list[k]] != 0) {
                    s->at[s->count] = list[k];
                    s->factor[s->count++] = work[list[k]] / work[best];
                }
            sequence[found] = best;
            step_of[best] = found++;
            variable[best] = j;
        }
        for (int k = 0; k < count; k++)
            mark[list[k]] = 0;
    }
    return found;
}

/* The same elimination of the chosen columns in balls, with the pivots in the order that
 * was found: where every pivot excludes 0 their matrix is regular at the point. */
static bool proved(const struct points_jacobian *j, int n, slong prec, const int *variable, const int *sequence)
{
    assert(j->space->constraints <= n);
    int c = j->space->constraints;
    SGA_ARENA(mem);
    struct ball_step { int row, count, *at; arb_ptr factor; } *step = sga_zeros(&mem, (size_t)c + 1, sizeof *step);
    int *place = sga_take(&mem, ((size_t)n + 1) * sizeof *place), *step_of = sga_take(&mem, ((size_t)c + 1) * sizeof *step_of);
    int *list = sga_take(&mem, ((size_t)c + 1) * sizeof *list), *heap = sga_take(&mem, ((size_t)c + 1) * sizeof *heap);
    int *first = sga_zeros(&mem, (size_t)c + 2, sizeof *first), *row, *entry, total = 0;
    unsigned char *mark = sga_zeros(&mem, (size_t)c + 1, 1);
    arb_ptr work = arbs_take(&mem, c);
    bool ok = true;
    for (int i = 0; i < n; i++)
        place[i] = -1;
    for (int k = 0; k < c; k++) {            /* by step: its row of the matrix, its column */
        place[variable[sequence[k]]] = k;
        step_of[sequence[k]] = k;
    }
    for (int i = 0; i < c; i++)
        for (int k = 0; k < j->cols[i]; k++)
            if (place[j->col[i][k]] >= 0) {
                first[place[j->col[i][k]] + 1]++;
                total++;
            }
    for (int k = 0; k < c; k++)
        first[k + 1] += first[k];
    row = sga_take(&mem, ((size_t)total + 1) * sizeof *row);
    entry = sga_take(&mem, ((size_t)total + 1) * sizeof *entry);
    int *fill = memcpy(sga_take(&mem, ((size_t)c + 1) * sizeof *fill), first, ((size_t)c + 1) * sizeof *fill);
    for (int i = 0; i < c; i++)
        for (int k = 0; k < j->cols[i]; k++) {
            int q = place[j->col[i][k]];
            if (q >= 0) {
                row[fill[q]] = i;
                entry[fill[q]++] = k;
            }
        }
    for (int q = 0; q < c && ok; q++) {
        int count = 0, heaped = 0;
        for (int k = first[q]; k < first[q + 1]; k++) {
            int i = row[k];
            arb_set(work + i, j->entry[i] + entry[k]);
            mark[i] = 1;
            list[count++] = i;
            if (step_of[i] < q)
                heap_push(heap, &heaped, step_of[i]);
        }
        while (heaped) {
            const struct ball_step *s = step + heap_pop(heap, &heaped);
            for (int k = 0; k < s->count; k++) {
                int i = s->at[k];
                if (!mark[i]) {
                    mark[i] = 1;
                    arb_zero(work + i);
                    list[count++] = i;
                    if (step_of[i] < q)
                        heap_push(heap, &heaped, step_of[i]);
                }
                arb_submul(work + i, work + s->row, s->factor + k, prec);
            }
        }
        struct ball_step *s = step + q;
        s->row = sequence[q];
        ok = mark[s->row] && arb_is_finite(work + s->row) && !arb_contains_zero(work + s->row);
        s->at = sga_take(&mem, ((size_t)count + 1) * sizeof *s->at);
        s->factor = arbs_take(&mem, count);
        for (int k = 0; k < count; k++) {
            if (ok && step_of[list[k]] > q) {
                arb_div(s->factor + s->count, work + list[k], work + s->row, prec);
                s->at[s->count++] = list[k];
            }
        }
        for (int k = 0; k < count; k++)
            mark[list[k]] = 0;
    }
    return ok;
}

void structure_initial(struct structure_work *w, struct structure *out)
{
    int n = w->sys->variables, c = w->sol->constraints;
    SGA_FREED unsigned char *taken = sga_calloc((size_t)n + 1, 1);
    out->free_initial = sga_take(&out->mem, ((size_t)n + 1) * sizeof *out->free_initial);
    out->solved_for = sga_take(&out->mem, ((size_t)c + 1) * sizeof *out->solved_for);
    out->has_initial = c == 0;
    if (c) {
        SGA_FREED int *order = preference(w->sys), *sequence = sga_malloc(((size_t)c + 1) * sizeof *sequence);
        for (int k = 0; k < w->oracle->reals && !out->has_initial; k++) {
            struct points_point *p = w->oracle->real + k;
            struct columns a;
            if (!p->certified)
                continue;
            SGA_ARENA(mem);
            SGA_ENDS(points_jacobian_clear) struct points_jacobian j;
            points_jacobian_init(&j, &w->oracle->space);
            points_jacobian_values(&j, &p->ball);
            points_jacobian_entries(&j, &p->ball);
            gather(&mem, &a, &j, n);
            out->has_initial = choose(&a, order, n, c, out->solved_for, sequence) == c
                               && ((c > FEW && points_columns_regular(&j, p, out->solved_for)) || proved(&j, n, p->ball.prec, out->solved_for, sequence));
        }
    }
    for (int i = 0; i < c && out->has_initial; i++)
        taken[out->solved_for[i]] = 1;
    for (int j = 0; j < n && out->has_initial; j++)
        if (!taken[j])
            out->free_initial[out->frees++] = j;
}
