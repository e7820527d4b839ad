/* Large sparse systems of index 1 by IDA with KLU and their exact Jacobians: sparse PROBLEM N STOP SAMPLES FLOOR RTOL...
 *
 * The equations of tests/bench/large.py: `web`, `heat`, `network` (this one of index 2 there, brought to index 1 by hand: its sources and its
 * cutsets differentiated). Absolute tolerances are the relative one times FLOOR times the size of a variable. For each tolerance a line: it;
 * CPU seconds of the integration, the least of some; steps; seconds of one refactorization with a solve by KLU and one evaluation of the residual, of
 * the last point's Jacobian; and the variables that sparse.py compares, at the last time. The consistent start and what is set up once are not counted. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <ida/ida.h>
#include <klu.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

enum { MOST_STEPS = 1000000, REPEATS = 3, COMPARED = 8 };

/* Entries of the Jacobian dF/dx + cj dF/dx' in any order, an entry in parts too; the order and the places are the same at every call. */
struct entries {
    long count, room;
    long *row, *col;
    double *value;
};

struct problem {
    const char *name;
    int (*size)(int n);
    void (*begin)(int n, double *x, double *dx, double *id, double *unit);   /* `dx`: exact, or 0 with a guess of what is algebraic in `x` */
    void (*residual)(int n, double t, const double *x, const double *dx, double *out);
    void (*jacobian)(int n, double t, double cj, const double *x, struct entries *e);
    int (*compared)(int n, int k);   /* of COMPARED variables the k-th */
};

static void put(struct entries *e, int row, int col, double value)
{
    if (e->count == e->room) {
        e->room = 2 * e->room + 1024;
        e->row = realloc(e->row, (size_t)e->room * sizeof *e->row);
        e->col = realloc(e->col, (size_t)e->room * sizeof *e->col);
        e->value = realloc(e->value, (size_t)e->room * sizeof *e->value);
        if (!e->row || !e->col || !e->value)
            abort();
    }
    e->row[e->count] = row;
    e->col[e->count] = col;
    e->value[e->count++] = value;
}

/* The food web: species s (0 prey, 1 predators) at point k = n r + c is number 2 k + s. */

static int mirrored(int q, int r, int n) { return q < 0 || q >= n ? 2 * r - q : q; }

static void web_around(int n, int k, int at[4])
{
    int r = k / n, c = k % n;
    at[0] = n * mirrored(r - 1, r, n) + c;
    at[1] = n * mirrored(r + 1, r, n) + c;
    at[2] = n * r + mirrored(c - 1, c, n);
    at[3] = n * r + mirrored(c + 1, c, n);
}

static double *web_growth;

static int web_size(int n) { return 2 * n * n; }

static void web_begin(int n, double *x, double *dx, double *id, double *unit)
{
    int m = n - 1;
    web_growth = web_growth ? web_growth : calloc((size_t)(n * n), sizeof *web_growth);
    if (!web_growth)
        abort();
    for (int k = 0; k < n * n; k++) {
        double r = k / n, c = k % n, bump = 16 * r * c * (m - r) * (m - c) / ((double)m * m * m * m);
        web_growth[k] = 1 + 50 * r * c / (m * m) + 1000 * sin(4 * M_PI * c / m) * sin(4 * M_PI * r / m);
        x[2 * k] = 10 + bump * bump;
        x[2 * k + 1] = 100000;
        dx[2 * k] = dx[2 * k + 1] = 0;
        id[2 * k] = 1;
        id[2 * k + 1] = 0;
        unit[2 * k] = 1;
        unit[2 * k + 1] = 1e4;
    }
}

static void web_residual(int n, double t, const double *u, const double *v, double *out)
{
    (void)t;
    double m2 = (n - 1.0) * (n - 1.0);
    for (int k = 0; k < n * n; k++) {
        int at[4];
        double flow[2] = { -4 * u[2 * k], -4 * u[2 * k + 1] }, b = web_growth[k], c = u[2 * k], p = u[2 * k + 1];
        web_around(n, k, at);
        for (int q = 0; q < 4; q++) {
            flow[0] += u[2 * at[q]];
            flow[1] += u[2 * at[q] + 1];
        }
        out[2 * k] = v[2 * k] - (m2 * flow[0] + c * (b - c - p / 2e6));
        out[2 * k + 1] = -(m2 * flow[1] / 20 + p * (-b + 1e4 * c - p));
    }
}

static void web_jacobian(int n, double t, double cj, const double *u, struct entries *e)
{
    (void)t;
    double m2 = (n - 1.0) * (n - 1.0);
    for (int k = 0; k < n * n; k++) {
        int at[4], prey = 2 * k, predator = prey + 1;
        double c = u[prey], p = u[predator], b = web_growth[k];
        put(e, prey, prey, cj + 4 * m2 - (b - 2 * c - p / 2e6));
        put(e, prey, predator, c / 2e6);
        put(e, predator, prey, -1e4 * p);
        put(e, predator, predator, 4 * m2 / 20 - (-b + 1e4 * c - 2 * p));
        web_around(n, k, at);
        for (int q = 0; q < 4; q++) {
            put(e, prey, 2 * at[q], -m2);
            put(e, predator, 2 * at[q] + 1, -m2 / 20);
        }
    }
}

static int web_compared(int n, int k) { return 2 * ((n * n - 1) * (k / 2) / (COMPARED / 2 - 1)) + k % 2; }

/* Heat on n x n points, spacing 1/(n + 1), a source u^2/8 inside; the boundary u + u^3 = neighbour + sin t. The point (r, c) of (n + 2) x (n + 2) is
 * number (n + 2) r + c; the corners, which nothing meets, are held at 0. */

static int heat_size(int n) { return (n + 2) * (n + 2); }

static int heat_edges(int n, int k) { int r = k / (n + 2), c = k % (n + 2); return (r == 0 || r == n + 1) + (c == 0 || c == n + 1); }

static int heat_inward(int n, int k)
{
    int r = k / (n + 2), c = k % (n + 2);
    return (n + 2) * (r < 1 ? 1 : r > n ? n : r) + (c < 1 ? 1 : c > n ? n : c);
}

static void heat_begin(int n, double *x, double *dx, double *id, double *unit)
{
    for (int k = 0; k < heat_size(n); k++) {
        x[k] = dx[k] = 0;
        id[k] = heat_edges(n, k) == 0;
        unit[k] = 1;
    }
    for (int k = 0; k < heat_size(n); k++)
        dx[k] = heat_edges(n, k) == 1 ? 1 : 0;
}

static void heat_residual(int n, double t, const double *u, const double *v, double *out)
{
    int w = n + 2;
    double m2 = (n + 1.0) * (n + 1.0), s = sin(t);
    for (int k = 0; k < w * w; k++)
        if (heat_edges(n, k) == 2)
            out[k] = u[k];
        else if (heat_edges(n, k))
            out[k] = u[k] + u[k] * u[k] * u[k] - u[heat_inward(n, k)] - s;
        else
            out[k] = v[k] - m2 * (u[k - w] + u[k + w] + u[k - 1] + u[k + 1] - 4 * u[k]) - u[k] * u[k] / 8;
}

static void heat_jacobian(int n, double t, double cj, const double *u, struct entries *e)
{
    (void)t;
    int w = n + 2;
    double m2 = (n + 1.0) * (n + 1.0);
    for (int k = 0; k < w * w; k++)
        if (heat_edges(n, k) == 2) {
            put(e, k, k, 1);
        } else if (heat_edges(n, k)) {
            put(e, k, k, 1 + 3 * u[k] * u[k]);
            put(e, k, heat_inward(n, k), -1);
        } else {
            put(e, k, k, cj + 4 * m2 - u[k] / 4);
            put(e, k, k - w, -m2);
            put(e, k, k + w, -m2);
            put(e, k, k - 1, -m2);
            put(e, k, k + 1, -m2);
        }
}

static int heat_compared(int n, int k) { return (n + 2) * (1 + (n - 1) * (k / 2) / (COMPARED / 2 - 1)) + (k % 2 ? (n + 1) / 2 : 1); }

/* The network: e(r, c) is number 2 n r + c, the current i(r, c) from (r, c) to (r, c + 1) number 2 n r + n + c, that of a source, j(r), comes
 * last in its row. Hand-reduced: e(r, 0) = cos((r + 1) t) with its rate, i(r, n - 2) = sin(t + r) with its rate. */

static int network_size(int n) { return 2 * n * n; }
static int network_e(int n, int r, int c) { return 2 * n * r + c; }
static int network_i(int n, int r, int c) { return 2 * n * r + n + c; }
static int network_j(int n, int r) { return 2 * n * r + 2 * n - 1; }

static void network_begin(int n, double *x, double *dx, double *id, double *unit)
{
    for (int k = 0; k < network_size(n); k++) {
        x[k] = dx[k] = 0;
        id[k] = unit[k] = 1;
    }
    for (int r = 0; r < n; r++) {
        x[network_e(n, r, 0)] = 1;
        x[network_i(n, r, n - 2)] = sin(r);
        id[network_e(n, r, 0)] = id[network_e(n, r, n - 1)] = id[network_i(n, r, n - 2)] = id[network_j(n, r)] = 0;
        x[network_e(n, r, n - 1)] = -cos(r);
    }
}

/* What leaves (r, c) through its resistors. */
static double network_resistors(int n, const double *x, int r, int c)
{
    double sum = 0;
    for (int q = r - 1; q <= r + 1; q += 2)
        if (q >= 0 && q < n) {
            double d = x[network_e(n, r, c)] - x[network_e(n, q, c)];
            sum += d * d * d + d;
        }
    return sum;
}

static void network_residual(int n, double t, const double *x, const double *dx, double *out)
{
    for (int r = 0; r < n; r++) {
        for (int c = 1; c < n - 1; c++) {
            int k = network_e(n, r, c);
            out[k] = dx[k] - x[network_i(n, r, c - 1)] + x[network_i(n, r, c)] + network_resistors(n, x, r, c);
        }
        for (int c = 0; c < n - 2; c++) {
            int k = network_i(n, r, c);
            out[k] = dx[k] - x[network_e(n, r, c)] + x[network_e(n, r, c + 1)];
        }
        out[network_e(n, r, 0)] = x[network_e(n, r, 0)] - cos((r + 1) * t);
        out[network_j(n, r)] = -(r + 1) * sin((r + 1) * t) - x[network_j(n, r)] + x[network_i(n, r, 0)] + network_resistors(n, x, r, 0);
        out[network_i(n, r, n - 2)] = x[network_i(n, r, n - 2)] - sin(t + r);
        out[network_e(n, r, n - 1)] = cos(t + r) - x[network_e(n, r, n - 2)] + x[network_e(n, r, n - 1)];
    }
}

static void network_slopes(int n, const double *x, int r, int c, int row, struct entries *e)
{
    double sum = 0;
    for (int q = r - 1; q <= r + 1; q += 2)
        if (q >= 0 && q < n) {
            double d = x[network_e(n, r, c)] - x[network_e(n, q, c)], slope = 3 * d * d + 1;
            put(e, row, network_e(n, q, c), -slope);
            sum += slope;
        }
    put(e, row, network_e(n, r, c), sum);
}

static void network_jacobian(int n, double t, double cj, const double *x, struct entries *e)
{
    (void)t;
    for (int r = 0; r < n; r++) {
        for (int c = 1; c < n - 1; c++) {
            int k = network_e(n, r, c);
            put(e, k, k, cj);
            put(e, k, network_i(n, r, c - 1), -1);
            put(e, k, network_i(n, r, c), 1);
            network_slopes(n, x, r, c, k, e);
        }
        for (int c = 0; c < n - 2; c++) {
            int k = network_i(n, r, c);
            put(e, k, k, cj);
            put(e, k, network_e(n, r, c), -1);
            put(e, k, network_e(n, r, c + 1), 1);
        }
        put(e, network_e(n, r, 0), network_e(n, r, 0), 1);
        put(e, network_j(n, r), network_j(n, r), -1);
        put(e, network_j(n, r), network_i(n, r, 0), 1);
        network_slopes(n, x, r, 0, network_j(n, r), e);
        put(e, network_i(n, r, n - 2), network_i(n, r, n - 2), 1);
        put(e, network_e(n, r, n - 1), network_e(n, r, n - 2), -1);
        put(e, network_e(n, r, n - 1), network_e(n, r, n - 1), 1);
    }
}

static int network_compared(int n, int k) { return network_e(n, (n - 1) * (k / 2) / (COMPARED / 2 - 1), k % 2 ? 2 : 1); }

static const struct problem PROBLEMS[] = {
    { "web", web_size, web_begin, web_residual, web_jacobian, web_compared },
    { "heat", heat_size, heat_begin, heat_residual, heat_jacobian, heat_compared },
    { "network", network_size, network_begin, network_residual, network_jacobian, network_compared },
};

/* A problem of one size, the pattern of its Jacobian by columns, and where each of its entries goes. */
struct task {
    const struct problem *of;
    int n, size;
    struct entries entries;
    long *place, filled;
    sunindextype *start, *row;
};

static struct entries *sorted;

static int by_place(const void *a, const void *b)
{
    long p = *(const long *)a, q = *(const long *)b, d = sorted->col[p] - sorted->col[q];
    d = d ? d : sorted->row[p] - sorted->row[q];
    return (d > 0) - (d < 0);
}

static void find_pattern(struct task *task, const double *x)
{
    struct entries *e = &task->entries;
    task->of->jacobian(task->n, 0, 1, x, e);
    long *order = malloc((size_t)e->count * sizeof *order), col = -1, row = -1;
    task->place = malloc((size_t)e->count * sizeof *task->place);
    task->row = malloc((size_t)e->count * sizeof *task->row);
    task->start = malloc((size_t)(task->size + 1) * sizeof *task->start);
    if (!order || !task->place || !task->row || !task->start)
        abort();
    for (long k = 0; k < e->count; k++)
        order[k] = k;
    sorted = e;
    qsort(order, (size_t)e->count, sizeof *order, by_place);
    for (long k = 0; k < e->count; k++) {
        long at = order[k];
        if (e->col[at] != col || e->row[at] != row) {
            while (col < e->col[at])
                task->start[++col] = task->filled;
            row = e->row[at];
            task->row[task->filled++] = row;
        }
        task->place[at] = task->filled - 1;
    }
    while (col < task->size)
        task->start[++col] = task->filled;
    free(order);
}

static int residual(realtype t, N_Vector x, N_Vector dx, N_Vector out, void *ctx)
{
    const struct task *task = ctx;
    task->of->residual(task->n, t, N_VGetArrayPointer(x), N_VGetArrayPointer(dx), N_VGetArrayPointer(out));
    return 0;
}

static int jacobian(realtype t, realtype cj, N_Vector x, N_Vector dx, N_Vector r, SUNMatrix J, void *ctx, N_Vector a, N_Vector b, N_Vector c)
{
    (void)dx, (void)r, (void)a, (void)b, (void)c;
    struct task *task = ctx;
    double *value = SUNSparseMatrix_Data(J);
    memcpy(SUNSparseMatrix_IndexPointers(J), task->start, (size_t)(task->size + 1) * sizeof *task->start);
    memcpy(SUNSparseMatrix_IndexValues(J), task->row, (size_t)task->filled * sizeof *task->row);
    memset(value, 0, (size_t)task->filled * sizeof *value);
    task->entries.count = 0;
    task->of->jacobian(task->n, t, cj, N_VGetArrayPointer(x), &task->entries);
    for (long k = 0; k < task->entries.count; k++)
        value[task->place[k]] += task->entries.value[k];
    return 0;
}

static double cpu(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seconds of a refactorization and a solve by KLU of that Jacobian, and of one residual: the least of some. */
static double floor_of(struct task *task, SUNMatrix J, N_Vector x, N_Vector dx, N_Vector out)
{
    klu_l_common common;
    klu_l_defaults(&common);
    double least = INFINITY, *value = SUNSparseMatrix_Data(J);
    klu_l_symbolic *symbolic = klu_l_analyze(task->size, task->start, task->row, &common);
    klu_l_numeric *numeric = symbolic ? klu_l_factor(task->start, task->row, value, symbolic, &common) : NULL;
    for (int k = 0; k < 2 * REPEATS && numeric; k++) {
        double from = cpu();
        residual(0, x, dx, out, task);
        if (!klu_l_refactor(task->start, task->row, value, symbolic, numeric, &common)
            || !klu_l_solve(symbolic, numeric, task->size, 1, N_VGetArrayPointer(out), &common))
            break;
        least = fmin(least, cpu() - from);
    }
    klu_l_free_numeric(&numeric, &common);
    klu_l_free_symbolic(&symbolic, &common);
    return least;
}

/* CPU seconds, -1: it failed. */
static double solve(struct task *task, double stop, int samples, double rtol, double factor, double *last, long *steps, double *least)
{
    SUNContext context;
    SUNContext_Create(NULL, &context);
    N_Vector x = N_VNew_Serial(task->size, context), dx = N_VClone(x), id = N_VClone(x), atol = N_VClone(x);
    task->of->begin(task->n, N_VGetArrayPointer(x), N_VGetArrayPointer(dx), N_VGetArrayPointer(id), N_VGetArrayPointer(atol));
    if (!task->place)
        find_pattern(task, N_VGetArrayPointer(x));
    N_VScale(rtol * factor, atol, atol);
    SUNMatrix J = SUNSparseMatrix(task->size, task->size, task->filled, CSC_MAT, context);
    SUNLinearSolver linear = SUNLinSol_KLU(x, J, context);
    void *memory = IDACreate(context);
    bool ok = !IDAInit(memory, residual, 0, x, dx) && !IDASetUserData(memory, task) && !IDASetId(memory, id) && !IDASVtolerances(memory, rtol, atol)
              && !IDASetMaxNumSteps(memory, MOST_STEPS) && !IDASetLinearSolver(memory, linear, J) && !IDASetJacFn(memory, jacobian)
              && !IDACalcIC(memory, IDA_YA_YDP_INIT, stop / samples / 1e3);
    double t, from = cpu();
    for (int k = 1; k <= samples && ok; k++)
        ok = IDASolve(memory, stop * k / samples, &t, x, dx, IDA_NORMAL) >= 0;
    double seconds = ok ? cpu() - from : -1;
    IDAGetNumSteps(memory, steps);
    for (int k = 0; k < COMPARED && ok; k++)
        last[k] = N_VGetArrayPointer(x)[task->of->compared(task->n, k)];
    if (ok && *least == 0)
        *least = floor_of(task, J, x, dx, id);
    IDAFree(&memory);
    SUNLinSolFree(linear);
    SUNMatDestroy(J);
    N_VDestroy(x), N_VDestroy(dx), N_VDestroy(id), N_VDestroy(atol);
    SUNContext_Free(&context);
    return seconds;
}

int main(int argc, char **argv)
{
    struct task task = { .n = argc > 6 ? atoi(argv[2]) : 0 };
    for (size_t k = 0; argc > 6 && k < sizeof PROBLEMS / sizeof *PROBLEMS; k++)
        task.of = strcmp(PROBLEMS[k].name, argv[1]) ? task.of : &PROBLEMS[k];
    if (task.n < 3 || !task.of)
        return fprintf(stderr, "sparse web|heat|network N STOP SAMPLES FLOOR RTOL...\n"), 2;
    task.size = task.of->size(task.n);
    double floor = 0;
    for (int a = 6; a < argc; a++) {
        double last[COMPARED] = { 0 }, least = -1, rtol = atof(argv[a]);
        long steps = 0;
        for (int k = 0; k < REPEATS; k++) {
            double now = solve(&task, atof(argv[3]), atoi(argv[4]), rtol, atof(argv[5]), last, &steps, &floor);
            least = least < 0 || (now >= 0 && now < least) ? now : least;
        }
        printf("%g;%.6g;%ld;%.6g", rtol, least, steps, floor);
        for (int k = 0; k < COMPARED; k++)
            printf(";%.17g", last[k]);
        printf("\n");
        fflush(stdout);
    }
    free(task.entries.row), free(task.entries.col), free(task.entries.value);
    free(task.place), free(task.row), free(task.start);
    free(web_growth);
    return 0;
}
