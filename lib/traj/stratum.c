/* A solution that seems to grow without bound may only have come to a stratum: what is solved for there (a multiplier, a
 * derivative) tends to infinity, while the variables on which a pivot depends stay finite and the pivot tends
 * to 0 at the same time. Then it is the equations' rank that ends the motion. */
#include <math.h>
#include <stdlib.h>

#include "derive.h"
#include "field.h"
#include "mem.h"
#include "signal.h"
#include "system.h"
#include "tape.h"

/* Variables this much larger than where the motion started are on their way to infinity. */
static const double GROWN = 1e3;
/* The pivot is nearly 0, and going on as it does it reaches 0 within this part of the time passed. The first pair is for
 * motions that stop short of the stratum, because what grows leaves no digits for steps. */
static const struct { double shrunk, soon; } near_zero[] = { { 1e-4, 1e-3 }, { 1, 1e-5 } };

/* p depends on no variable that grows. */
static bool stays_finite(const struct field *f, expr_id p, const unsigned char *grown)
{
    struct expr_cone cone;
    bool ok = true;
    expr_cone_init(&cone);
    expr_cone_of(f->sys->store, &cone, &p, 1);
    for (int i = 0; i < cone.count && ok; i++) {
        const struct expr_node *n = f->sys->store->node + cone.list[i];
        ok = n->op != EXPR_SYM || !grown[n->a];
    }
    expr_cone_clear(&cone);
    return ok;
}

/* p and its derivative along v, from the last point inside. */
static bool along(const struct field *f, expr_id p, const double *v, double out[2])
{
    struct expr_store *st = f->sys->store;
    int n = f->n, *inputs = sga_malloc((size_t)(n + 1) * sizeof *inputs);
    expr_id *root = sga_malloc((size_t)(n + 2) * sizeof *root);
    double *in = sga_malloc((size_t)(n + 1) * sizeof *in), *value = sga_malloc((size_t)(n + 2) * sizeof *value);
    root[0] = p;
    for (int j = 0; j <= n; j++) {
        inputs[j] = j < n ? f->sys->variable[j].symbol : f->sys->time;
        in[j] = j < n ? f->here[j] : f->here_t;
        root[j + 1] = j < n ? expr_diff(st, p, inputs[j]) : expr_time_partial(st, p, inputs[j]);
    }
    struct sga_error ignored = { 0 };
    struct num_tape *tape = expr_store_ok(st) ? num_tape_new(st, root, n + 2, inputs, n + 1, &ignored) : NULL;
    bool ok = tape && num_tape_eval(tape, in, value);
    out[0] = value[0];
    out[1] = ok ? value[n + 1] : 0;
    for (int j = 0; j < n && ok; j++)
        out[1] += value[j + 1] != 0 ? value[j + 1] * v[j] : 0;
    num_tape_free(tape);
    free(inputs);
    free(root);
    free(in);
    free(value);
    return ok && isfinite(out[1]);
}

int field_approaches(struct field *f, const double *start, double start_t, double end_t, bool choice)
{
    int found = -1, n = f->n;
    double passed = end_t - start_t, *v = sga_calloc((size_t)n + 1, sizeof *v), p[2];
    unsigned char *grown = sga_calloc((size_t)f->sys->store->symbols + 1, 1);
    for (int j = 0; j < n; j++)
        grown[f->sys->variable[j].symbol] = fabs(f->here[j]) > GROWN * (1 + fabs(start[j]));
    double *x = sga_malloc((size_t)(n + 1) * sizeof *x);
    for (int j = 0; j < n; j++)
        x[j] = f->here[j];
    bool moves = field_eval(f, f->here_t, x, v);
    double soonest = INFINITY;      /* where one of them falls fast, so do others that depend on the same */
    for (int q = choice ? f->chosen : 0; q < (choice ? f->pivots : f->chosen) && moves; q++) {
        expr_id e = f->pivot_expr[q];
        if (!stays_finite(f, e, grown) || !along(f, e, v, p) || p[1] == 0)
            continue;
        double left = -p[0] / p[1] / passed;
        bool near = p[0] == 0;
        for (int k = 0; k < 2 && left > 0; k++)
            near |= left < near_zero[k].soon && fabs(p[0]) <= near_zero[k].shrunk * f->pivot_start[q];
        if (near && left < soonest) {
            soonest = left;
            found = q;
        }
    }
    free(x);
    free(v);
    free(grown);
    return found;
}
