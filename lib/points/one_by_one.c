/* Constraints met one after the other. */
#include "one_by_one.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "arb_ends.h"
#include "differentials.h"
#include "mem.h"
#include "points_space.h"

enum { STEPS = 40 };
/* Of a constraint over its slope, in units of the largest variable: met. Steps of this many times the largest variable are shortened. */
static const double MET = 1e-13, FAR = 4;

/* Constraints by how many new variables they have, the last one put there first; those that have fewer now are put again. */
struct queue {
    struct points_jacobian *j;
    int *left;                     /* by constraint; 0: done, or nothing to move */
    int *next, *of; int held;      /* places: the one below, and whose */
    int *top; int tops, least;     /* by number of variables: the place on top or -1 */
    int *in, *in_start;            /* by variable: the constraints that contain it */
    unsigned char *known;          /* by variable */
};

static void put(struct queue *q, int i)
{
    int k = q->left[i];
    if (!k)
        return;
    q->of[q->held] = i;
    q->next[q->held] = q->top[k];
    q->top[k] = q->held++;
    q->least = k < q->least ? k : q->least;
}

static void queue_all(struct queue *q, struct points_jacobian *j, struct sga_arena *mem)
{
    int c = j->space->constraints, n = j->space->variables, total = 0;
    *q = (struct queue){ .j = j, .left = sga_zeros(mem, (size_t)c + 1, sizeof *q->left), .known = sga_zeros(mem, (size_t)n + 1, 1),
                         .in_start = sga_zeros(mem, (size_t)n + 1, sizeof *q->in_start) };
    for (int i = 0; i < c; i++) {
        q->left[i] = j->cols[i];
        total += j->cols[i];
        q->tops = j->cols[i] > q->tops ? j->cols[i] : q->tops;
        for (int k = 0; k < j->cols[i]; k++)
            q->in_start[j->col[i][k]]++;
    }
    for (int v = 0; v < n; v++)        /* where the places of v end; they are filled from there down */
        q->in_start[v + 1] += q->in_start[v];
    q->in = sga_take(mem, ((size_t)total + 1) * sizeof *q->in);
    q->next = sga_take(mem, ((size_t)total + (size_t)c + 1) * sizeof *q->next);
    q->of = sga_take(mem, ((size_t)total + (size_t)c + 1) * sizeof *q->of);
    q->top = sga_take(mem, ((size_t)q->tops + 2) * sizeof *q->top);
    for (int k = 0; k <= q->tops + 1; k++)
        q->top[k] = -1;
    q->least = q->tops + 1;
    for (int i = c - 1; i >= 0; i--) {
        put(q, i);
        for (int k = 0; k < j->cols[i]; k++)
            q->in[--q->in_start[j->col[i][k]]] = i;
    }
}

/* The next constraint, or -1. */
static int take(struct queue *q)
{
    while (q->least <= q->tops) {
        int place = q->top[q->least];
        if (place < 0) {
            q->least++;
            continue;
        }
        q->top[q->least] = q->next[place];
        if (q->left[q->of[place]] == q->least)
            return q->of[place];
    }
    return -1;
}

static void now_known(struct queue *q, int v)
{
    q->known[v] = 1;
    for (int e = q->in_start[v]; e < q->in_start[v + 1]; e++) {
        q->left[q->in[e]]--;
        put(q, q->in[e]);
    }
}

/* Steps of least norm of the new variables of constraint i. */
static void meet(struct queue *q, int i, struct points_point *p)
{
    struct points_jacobian *j = q->j;
    const struct points_space *s = j->space;
    const int *scale = p->scaled ? s->scale : NULL;
    for (int step = 0; step < STEPS; step++) {
        num_ball_list(&p->ball, j->cone[i], j->cone_len[i]);
        arb_srcptr value = num_ball_value(&p->ball, s->constraint[i]);
        double f = arb_is_finite(value) ? arf_get_d(arb_midref(value), ARF_RND_NEAR) : NAN, slope = 0, size = 1;
        points_jacobian_row(j, &p->ball, i);
        for (int k = 0; k < j->cols[i]; k++) {
            int v = j->col[i][k];
            double g = q->known[v] ? 0 : ldexp(arf_get_d(arb_midref(j->grad + v), ARF_RND_NEAR), scale ? scale[v] : 0);
            slope = hypot(slope, g);
            size = fmax(size, ldexp(fabs(p->x[v]), scale ? -scale[v] : 0));
        }
        double length = f / slope;
        if (!isfinite(length) || fabs(length) < MET * size)
            return;
        length = fmax(fmin(length, FAR * size), -FAR * size);
        for (int k = 0; k < j->cols[i]; k++) {
            int v = j->col[i][k], e = scale ? scale[v] : 0;
            if (q->known[v])
                continue;
            p->x[v] -= ldexp(length * ldexp(arf_get_d(arb_midref(j->grad + v), ARF_RND_NEAR), e) / slope, e);
            num_ball_set_d(&p->ball, s->variable[v], p->x[v]);
        }
    }
}

void points_one_by_one(struct points_jacobian *j, struct points_point *p)
{
    assert(p->variables == j->space->variables);
    SGA_ARENA(mem);
    struct queue q;
    queue_all(&q, j, &mem);
    for (int i = take(&q); i >= 0; i = take(&q)) {
        meet(&q, i, p);
        for (int k = 0; k < j->cols[i]; k++)
            if (!q.known[j->col[i][k]])
                now_known(&q, j->col[i][k]);
    }
}
