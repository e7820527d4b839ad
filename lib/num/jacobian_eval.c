/* Accumulation: rows by reverse sweeps, or columns by forward sweeps. */
#include "jacobian_plan.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "exec.h"
#include "jacobian.h"
#include "lu.h"
#include "tape_jit.h"

/* y = S^-1 r: bar r = S^-T bar y, bar S = -bar r y^T */
static void solve_back(struct jacobian_solve *q, double *adj)
{
    const struct tape_solve *s = q->of;
    bool met = false;
    for (int i = 0; i < s->m && !met; i++)
        met = q->bar[i] != 0;
    if (!met)
        return;
    if (!s->singular)
        num_lu_solve_transposed(s->lu, s->perm, s->m, q->bar, q->work);
    for (int i = 0; i < s->m; i++) {
        q->bar[i] = 0;
        if (s->singular)
            q->work[i] = NAN;
    }
    for (int k = 0; k < q->edges; k++) {
        double r = q->work[q->edge[k].row];
        adj[q->edge[k].id] += q->edge[k].col < 0 ? r : -r * s->y[q->edge[k].col];
    }
}

/* dot y = S^-1 (dot r - dot S y), left in q->work */
static void solve_forward(struct jacobian_solve *q, const double *dot)
{
    const struct tape_solve *s = q->of;
    bool met = false;
    for (int k = 0; k < q->edges; k++) {
        double d = dot[q->edge[k].id];
        if (d == 0)
            continue;
        met = true;
        q->bar[q->edge[k].row] += q->edge[k].col < 0 ? d : -d * s->y[q->edge[k].col];
    }
    if (met && !s->singular)
        num_lu_solve(s->lu, s->perm, s->m, q->bar, q->work);
    for (int i = 0; i < s->m; i++) {
        q->bar[i] = 0;
        if (!met || s->singular)
            q->work[i] = met ? NAN : 0;
    }
}

/* 0 where the second is 0: of an infinite slope too. */
static double product(double a, double b) { return b != 0 ? a * b : 0; }

static void step_back(struct num_jacobian_plan *p, const struct jacobian_step *s, double w, double *adj)
{
    if (s->op == TAPE_FACTOR) {
        solve_back(p->solve + s->a, adj);
    } else if (w == 0) {
        return;
    } else if (s->op == TAPE_COMPONENT) {
        p->solve[s->a].bar[s->b] += w;
    } else {
        adj[s->a] += product(w, s->pa);
        if (s->b != p->sink)
            adj[s->b] += product(w, s->pb);
    }
}

static double step_forward(struct num_jacobian_plan *p, const struct jacobian_step *s, const double *dot)
{
    if (s->op == TAPE_FACTOR) {
        solve_forward(p->solve + s->a, dot);
        return 0;
    }
    if (s->op == TAPE_COMPONENT)
        return p->solve[s->a].work[s->b];
    double x = dot[s->a], y = dot[s->b];
    return product(s->pa, x) + product(s->pb, y);
}

static void row_by_reverse(struct num_jacobian *j, int row, double *values)
{
    struct num_jacobian_plan *p = j->plan;
    const struct jacobian_lists *l = &p->lists;
    double *adj = p->sweep;
    adj[p->root[row]] = 1;
    int n = l->all[row] ? p->steps : l->start[row + 1] - l->start[row];
    for (int i = n - 1; i >= 0; i--) {
        int k = l->all[row] ? i : l->item[l->start[row] + i];
        double w = adj[j->cols + k];
        adj[j->cols + k] = 0;
        step_back(p, p->step + k, w, adj);
    }
    for (int i = j->start[row]; i < j->start[row + 1]; i++) {
        values[i] = adj[j->col[i]];
        adj[j->col[i]] = 0;
    }
    adj[p->sink] = 0;
}

static void column_by_forward(struct num_jacobian *j, int col, double *values)
{
    struct num_jacobian_plan *p = j->plan;
    const struct jacobian_lists *l = &p->lists;
    double *dot = p->sweep;
    dot[col] = 1;
    int n = l->all[col] ? p->steps : l->start[col + 1] - l->start[col];
    for (int i = 0; i < n; i++) {
        int k = l->all[col] ? i : l->item[l->start[col] + i];
        dot[j->cols + k] = step_forward(p, p->step + k, dot);
    }
    for (int i = p->by_col[col]; i < p->by_col[col + 1]; i++)
        values[p->entry[i]] = dot[p->root[p->entry_row[i]]] + 0.0;    /* no -0 */
    for (int i = 0; i < n; i++)
        dot[j->cols + (l->all[col] ? i : l->item[l->start[col] + i])] = 0;
    dot[col] = 0;
}

static bool sweep(struct num_jacobian *j, const double *in, double *out, double *values)
{
    struct num_jacobian_plan *p = j->plan;
    bool finite = tape_eval_all(p->tape, in, out);
    jacobian_partials(p);
    if (p->forward)
        for (int c = 0; c < j->cols; c++)
            column_by_forward(j, c, values);
    else
        for (int r = 0; r < j->rows; r++)
            row_by_reverse(j, r, values);
    for (int i = 0; i < j->nnz; i++)
        finite &= (bool)isfinite(values[i]);
    return finite;
}

static void compile(struct num_jacobian *j)
{
    struct num_jacobian_plan *p = j->plan;
    p->code = jacobian_code(j);
    num_tape_compile(p->code, p->memory);
    if (tape_compile(p->code))
        return;
    num_tape_free(p->code);
    p->code = NULL;
    p->runs = LONG_MIN / 2;
}

bool num_jacobian_eval(struct num_jacobian *j, const double *in, double *out, double *values)
{
    struct num_jacobian_plan *p = j->plan;
    out = out ? out : p->out;
    if (p->code && tape_eval_parts(p->code, in, out, values))
        return true;
    if (p->memory && !p->code && ++p->runs >= (sga_exec_repeats(p->memory) ? TAPE_RUNS_REPEATED : TAPE_RUNS_BEFORE))
        compile(j);
    return sweep(j, in, out, values);
}

void num_jacobian_compile(struct num_jacobian *j, struct sga_exec *memory)
{
    struct num_jacobian_plan *p = j->plan;
    bool code = memory && jacobian_may_be_code(j);
    if (code && p->memory == memory)       /* what it has stays */
        return;
    num_tape_free(p->code);
    p->code = NULL;
    p->memory = code ? memory : NULL;
    p->runs = 0;
    p->tape->keep_all = !code;       /* sweeps read all values */
    num_tape_compile(p->tape, memory);
}

void num_jacobian_hold(struct num_jacobian *j, const signed char *side)
{
    struct num_jacobian_plan *p = j->plan;
    num_tape_hold(p->tape, side);
    for (int i = 0; p->code && i < p->tape->nheld; i++) {      /* constants have the same slots there */
        int slot = p->tape->held[i].slot;
        memcpy(p->code->value + slot, p->tape->value + slot, 3 * sizeof *p->code->value);
    }
    if (p->code)
        tape_forget_time(p->code);
}

bool num_jacobian_compiled(const struct num_jacobian *j) { return j->plan->code != NULL; }
