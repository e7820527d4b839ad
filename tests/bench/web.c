/* The food web of SUNDIALS' examples by IDA with KLU and its exact sparse Jacobian: web N STOP SAMPLES RTOL...
 *
 * The equations of tests/bench/large.py (web). For each tolerance (atol is the same times the size of a species: 1 for prey, 10^4 for
 * predators) a line: rtol; CPU seconds of the integration, the least of some; steps; and the species of the points that web.py compares, at
 * the last time. The consistent start and what is set up once are not counted. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

enum { MOST_STEPS = 1000000, REPEATS = 3, COMPARED = 4 };
static const double PREDATORS = 1e4;

/* Species s (0 prey, 1 predators) at (r, c) is number 2 (n r + c) + s. */
struct web { int n; double *growth; };

static int mirrored(int q, int r, int n) { return q < 0 || q >= n ? 2 * r - q : q; }

static void around(const struct web *w, int r, int c, int at[4])
{
    int n = w->n;
    at[0] = n * mirrored(r - 1, r, n) + c;
    at[1] = n * mirrored(r + 1, r, n) + c;
    at[2] = n * r + mirrored(c - 1, c, n);
    at[3] = n * r + mirrored(c + 1, c, n);
}

static int residual(realtype t, N_Vector x, N_Vector dx, N_Vector res, void *ctx)
{
    (void)t;
    const struct web *w = ctx;
    const double *u = N_VGetArrayPointer(x), *v = N_VGetArrayPointer(dx);
    double *out = N_VGetArrayPointer(res), m2 = (w->n - 1.0) * (w->n - 1.0);
    for (int k = 0; k < w->n * w->n; k++) {
        int at[4];
        double flow[2] = { -4 * u[2 * k], -4 * u[2 * k + 1] }, b = w->growth[k], c = u[2 * k], p = u[2 * k + 1];
        around(w, k / w->n, k % w->n, at);
        for (int q = 0; q < 4; q++) {
            flow[0] += u[2 * at[q]];
            flow[1] += u[2 * at[q] + 1];
        }
        out[2 * k] = v[2 * k] - (m2 * flow[0] + c * (b - c - p / 2e6));
        out[2 * k + 1] = -(m2 * flow[1] / 20 + p * (-b + 1e4 * c - p));
    }
    return 0;
}

static int by_row(const void *a, const void *b)
{
    long p = *(const long *)a, q = *(const long *)b;
    return (p > q) - (p < q);
}

/* By columns: that of a species has its own point's two rows, and the same species' rows beside. */
static int jacobian(realtype t, realtype cj, N_Vector x, N_Vector dx, N_Vector r, SUNMatrix J, void *ctx, N_Vector a, N_Vector b2, N_Vector c2)
{
    (void)t, (void)dx, (void)r, (void)a, (void)b2, (void)c2;
    const struct web *w = ctx;
    const double *u = N_VGetArrayPointer(x);
    double m2 = (w->n - 1.0) * (w->n - 1.0), *value = SUNSparseMatrix_Data(J);
    sunindextype *start = SUNSparseMatrix_IndexPointers(J), *row = SUNSparseMatrix_IndexValues(J), count = 0;
    SUNMatZero(J);
    for (int col = 0; col < 2 * w->n * w->n; col++) {
        int k = col / 2, s = col % 2, at[4], entries = 0;
        double c = u[2 * k], p = u[2 * k + 1], own[2], weight = s ? m2 / 20 : m2;
        long list[6];
        double sum[6];
        own[0] = s ? c / 2e6 : cj - (-4 * m2 + w->growth[k] - 2 * c - p / 2e6);
        own[1] = s ? -(-4 * m2 / 20 - w->growth[k] + 1e4 * c - 2 * p) : -1e4 * p;
        list[entries++] = 2 * k;
        list[entries++] = 2 * k + 1;
        around(w, k / w->n, k % w->n, at);
        for (int q = 0; q < 4; q++) {
            bool seen = false;
            for (int e = 2; e < entries; e++)
                seen |= list[e] == 2 * at[q] + s;
            if (!seen)
                list[entries++] = 2 * at[q] + s;
        }
        qsort(list, (size_t)entries, sizeof *list, by_row);
        for (int e = 0; e < entries; e++) {
            sum[e] = list[e] / 2 == k ? own[list[e] % 2] : 0;
            if (list[e] / 2 == k)
                continue;
            int there[4];
            around(w, (int)(list[e] / 2) / w->n, (int)(list[e] / 2) % w->n, there);
            for (int q = 0; q < 4; q++)
                sum[e] -= there[q] == k ? weight : 0;
        }
        start[col] = count;
        for (int e = 0; e < entries; e++) {
            row[count] = list[e];
            value[count++] = sum[e];
        }
        start[col + 1] = count;
    }
    return 0;
}

static double cpu(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void begin(const struct web *w, double *u, double *id, double *atol, double rtol)
{
    int n = w->n, m = n - 1;
    for (int k = 0; k < n * n; k++) {
        double r = k / n, c = k % n, bump = 16 * r * c * (m - r) * (m - c) / ((double)m * m * m * m);
        u[2 * k] = 10 + bump * bump;
        u[2 * k + 1] = 100000;
        id[2 * k] = 1;
        id[2 * k + 1] = 0;
        atol[2 * k] = rtol;
        atol[2 * k + 1] = rtol * PREDATORS;
    }
}

/* CPU seconds, -1: it failed. */
static double solve(struct web *w, double stop, int samples, double rtol, double *last, long *steps)
{
    SUNContext context;
    int size = 2 * w->n * w->n;
    SUNContext_Create(NULL, &context);
    N_Vector x = N_VNew_Serial(size, context), dx = N_VClone(x), id = N_VClone(x), atol = N_VClone(x);
    SUNMatrix J = SUNSparseMatrix(size, size, 6 * size, CSC_MAT, context);
    SUNLinearSolver linear = SUNLinSol_KLU(x, J, context);
    begin(w, N_VGetArrayPointer(x), N_VGetArrayPointer(id), N_VGetArrayPointer(atol), rtol);
    N_VConst(0, dx);
    void *memory = IDACreate(context);
    bool ok = !IDAInit(memory, residual, 0, x, dx) && !IDASetUserData(memory, w) && !IDASetId(memory, id) && !IDASVtolerances(memory, rtol, atol)
              && !IDASetMaxNumSteps(memory, MOST_STEPS) && !IDASetLinearSolver(memory, linear, J) && !IDASetJacFn(memory, jacobian)
              && !IDACalcIC(memory, IDA_YA_YDP_INIT, stop / samples / 1e3);
    double t, from = cpu();
    for (int k = 1; k <= samples && ok; k++)
        ok = IDASolve(memory, stop * k / samples, &t, x, dx, IDA_NORMAL) >= 0;
    double seconds = ok ? cpu() - from : -1;
    IDAGetNumSteps(memory, steps);
    const double *u = N_VGetArrayPointer(x);
    for (int k = 0; k < COMPARED * 2 && ok; k++)
        last[k] = u[2 * ((w->n * w->n - 1) * (k / 2) / (COMPARED - 1)) + k % 2];
    IDAFree(&memory);
    SUNLinSolFree(linear);
    SUNMatDestroy(J);
    N_VDestroy(x), N_VDestroy(dx), N_VDestroy(id), N_VDestroy(atol);
    SUNContext_Free(&context);
    return seconds;
}

int main(int argc, char **argv)
{
    struct web w = { .n = argc > 4 ? atoi(argv[1]) : 0 };
    if (w.n < 3)
        return fprintf(stderr, "web N STOP SAMPLES RTOL...\n"), 2;
    int m = w.n - 1;
    w.growth = calloc((size_t)(w.n * w.n), sizeof *w.growth);
    for (int k = 0; w.growth && k < w.n * w.n; k++) {
        double r = k / w.n, c = k % w.n;
        w.growth[k] = 1 + 50 * r * c / (m * m) + 1000 * sin(4 * M_PI * c / m) * sin(4 * M_PI * r / m);
    }
    for (int a = 4; a < argc; a++) {
        double last[2 * COMPARED] = { 0 }, least = -1, rtol = atof(argv[a]);
        long steps = 0;
        for (int k = 0; k < REPEATS; k++) {
            double now = solve(&w, atof(argv[2]), atoi(argv[3]), rtol, last, &steps);
            least = least < 0 || (now >= 0 && now < least) ? now : least;
        }
        printf("%g;%.6g;%ld", rtol, least, steps);
        for (int k = 0; k < 2 * COMPARED; k++)
            printf(";%.17g", last[k]);
        printf("\n");
    }
    free(w.growth);
    return 0;
}
