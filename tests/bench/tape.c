/* Ratios of the executors of a tape: interpreter and machine code, for fields of some 20, 200
 * and 2000 operations (a chain of masses with cubic springs), and their Jacobians.
 * Prints one line of JSON for each, in ns. */
#include <stdio.h>
#include <stdlib.h>

#include "budget.h"
#include "exec.h"
#include "jacobian.h"

/* Accelerations of n masses; inputs[0 .. n) are the positions. */
static void chain(struct expr_store *st, int n, expr_id *root, int *inputs)
{
    expr_id *x = malloc((size_t)(n + 2) * sizeof *x);
    for (int i = 0; i < n; i++) {
        char name[16];
        snprintf(name, sizeof name, "x%d", i);
        x[i + 1] = expr_symbol_add(st, name, EXPR_VARIABLE);
        inputs[i] = i;
    }
    x[0] = x[n + 1] = expr_int(st, 0);
    expr_id stiff = expr_rational(st, 7, 5), soft = expr_rational(st, 1, 3), force = x[0];
    for (int i = 0; i <= n; i++) {
        expr_id d = expr_sub(st, x[i + 1], x[i]);
        expr_id pull = expr_mul(st, d, expr_add(st, stiff, expr_mul(st, soft, expr_mul(st, d, d))));
        if (i > 0)
            root[i - 1] = expr_sub(st, pull, force);
        force = pull;
    }
    free(x);
}

/* Seconds for one call. */
static double time_field(struct num_tape *t, double *in, double *out)
{
    double best = 1e9;
    for (int turn = 0; turn < 7; turn++) {
        int n = 20000000 / (20 + num_tape_length(t)) / 20;
        double begin = sga_cpu();
        for (int i = 0; i < n; i++) {
            in[0] += 1e-9;
            num_tape_eval(t, in, out);
        }
        double s = (sga_cpu() - begin) / n;
        best = s < best ? s : best;
    }
    return best;
}

static double time_jacobian(struct num_jacobian *j, struct num_tape *t, double *in, double *out, double *values)
{
    double best = 1e9;
    for (int turn = 0; turn < 5; turn++) {
        int n = 20000000 / (20 + num_tape_length(t)) / 200;
        double begin = sga_cpu();
        for (int i = 0; i < n; i++) {
            in[0] += 1e-9;
            num_jacobian_eval(j, in, out, values);
        }
        double s = (sga_cpu() - begin) / n;
        best = s < best ? s : best;
    }
    return best;
}

int main(void)
{
    static const int size[] = { 3, 33, 333 };
    struct sga_exec *memory = sga_exec_new(1 << 22);
    for (int k = 0; k < 3; k++) {
        int n = size[k], *inputs = malloc((size_t)n * sizeof *inputs);
        struct expr_store st;
        expr_store_init(&st);
        expr_id *root = malloc((size_t)n * sizeof *root);
        double *in = malloc((size_t)n * sizeof *in), *out = malloc((size_t)n * sizeof *out);
        chain(&st, n, root, inputs);
        for (int i = 0; i < n; i++)
            in[i] = 0.01 * i;
        struct num_tape *t = num_tape_new(&st, root, n, inputs, n, NULL);
        struct num_jacobian *j = num_jacobian_new(t, NULL, 0);
        double *values = malloc((size_t)(j->nnz + 1) * sizeof *values);
        double slow = time_field(t, in, out), slow_j = time_jacobian(j, t, in, out, values);
        num_jacobian_compile(j, memory);
        num_tape_compile(t, memory);
        double fast = time_field(t, in, out), fast_j = time_jacobian(j, t, in, out, values);
        printf("{\"operations\": %d, \"field\": [%.2f, %.2f], \"jacobian\": [%.2f, %.2f]}\n",
               num_tape_length(t), 1e9 * slow, 1e9 * fast, 1e9 * slow_j, 1e9 * fast_j);
        num_jacobian_free(j);
        num_tape_free(t);
        expr_store_clear(&st);
        free(inputs);
        free(root);
        free(in);
        free(out);
        free(values);
    }
    sga_exec_free(memory);
    return 0;
}
