/* Coordinates by elimination of the differentials, class by class: see coordinates.h. */
#include "coordinates.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kinds.h"
#include "manifold.h"
#include "mem.h"
#include "normal.h"

static const double DEAR = 1e8;
/* Rows have 1 as their largest entry. A slope below the first is left to other variables; below the second it is none. */
static const double SLIGHT = 1e-6, NONE = 1e-10;
/* Slopes as large as each other. */
static const double ALIKE = 1e-9;

enum { CLASSES = 6 };

struct columns {
    int n, c;
    double *column;          /* n x c: what the columns taken so far leave of each */
    unsigned char *class, *solved;
    int *by_name;
};

static double norm2(const double *v, int c)
{
    double sum = 0;
    for (int i = 0; i < c; i++)
        sum += v[i] * v[i];
    return sum;
}

/* The steepest column of the class, the later one by name of two alike; -1: none above the limit. */
static int steepest(const struct columns *a, int class, double limit)
{
    int best = -1;
    double most = 0;
    for (int i = 0; i < a->n; i++) {
        int j = a->by_name[i];
        double s = norm2(a->column + (size_t)j * (size_t)a->c, a->c);
        if (!a->solved[j] && a->class[j] == class && s > limit * limit && s >= (1 - ALIKE) * most) {
            best = j;
            most = fmax(s, most);
        }
    }
    return best;
}

static void take(struct columns *a, int j)
{
    double *q = a->column + (size_t)j * (size_t)a->c, size = norm2(q, a->c);
    a->solved[j] = 1;
    for (int k = 0; k < a->n; k++) {
        double *v = a->column + (size_t)k * (size_t)a->c, s = 0;
        if (a->solved[k])
            continue;
        for (int i = 0; i < a->c; i++)
            s += q[i] * v[i];
        for (int i = 0; i < a->c; i++)
            v[i] -= s / size * q[i];
    }
}

static void classify(struct columns *a, const struct sys_system *sys, const struct traj_request *rq)
{
    sys_kinds(sys, a->class);
    for (int j = 0; j < a->n; j++) {
        int kind = a->class[j] == SYS_COORDINATE ? 2 : a->class[j] == SYS_VELOCITY ? 1 : 0;
        a->class[j] = (unsigned char)(2 * kind + (rq->given[j] || (rq->held && rq->held[j])));
    }
}

bool coordinates_solved(struct manifold *m, const struct sys_system *sys, const struct traj_request *rq, const double *x, unsigned char *solved)
{
    if ((double)m->c * m->c * m->n > DEAR || manifold_residual(m, rq->start, x, NULL, NULL) < 0)
        return false;
    size_t n = (size_t)m->n, c = (size_t)m->c;
    struct columns a = { .n = m->n, .c = m->c, .solved = solved };
    a.column = sga_calloc(n * c + 1, sizeof *a.column);
    a.class = sga_malloc(n + 1);
    a.by_name = sga_malloc((n + 1) * sizeof *a.by_name);
    for (int i = 0; i < m->c; i++)
        for (int k = 0; k < m->cols[i]; k++)
            a.column[(size_t)m->col[i][k] * c + (size_t)i] = m->step->value[i][k];
    classify(&a, sys, rq);
    sys_by_name(sys, a.by_name);
    int left = m->c;
    for (int pass = 0; pass < 2; pass++)
        for (int class = 0; class < CLASSES; class++)
            for (int j; left > 0 && (j = steepest(&a, class, pass ? NONE : SLIGHT)) >= 0; left--)
                take(&a, j);
    assert(left >= 0);       /* no more are solved for than there are constraints */
    free(a.column);
    free(a.class);
    free(a.by_name);
    return true;
}
