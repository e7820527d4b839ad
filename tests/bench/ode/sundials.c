/* SUNDIALS: CVODE (Adams, BDF), ARKODE (explicit and diagonally implicit Runge-Kutta), IDA: one solution of a problem.
 * Jacobians are dense and exact. */
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <string.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "problem.h"

enum { ADAMS, BDF, ERK, DIRK, IDA };
const struct peer sundials_peers[] = {
    {"CVODE Adams", ADAMS, 12, false},
    {"ARKODE ERK 4", ERK, ARKODE_ZONNEVELD_5_3_4, false},
    {"ARKODE DOPRI 5", ERK, ARKODE_DORMAND_PRINCE_7_4_5, false},
    {"ARKODE Verner 6", ERK, ARKODE_VERNER_8_5_6, false},
    {"ARKODE Fehlberg 8", ERK, ARKODE_FEHLBERG_13_7_8, false},
    {"CVODE BDF", BDF, 5, true},
    {"ARKODE DIRK 4", DIRK, ARKODE_ESDIRK437L2SA_7_3_4, true},
    {"ARKODE DIRK 5", DIRK, ARKODE_ESDIRK547L2SA2_7_4_5, true},
    {"IDA", IDA, 5, true}, {0},
};
enum { MOST_STEPS = 1000000 };

struct job { const struct problem *p; long evaluations; };

static int field(realtype t, N_Vector x, N_Vector dx, void *ctx)
{
    struct job *j = ctx;
    j->evaluations++;
    j->p->field(t, N_VGetArrayPointer(x), N_VGetArrayPointer(dx));
    return 0;
}

static int slope(realtype t, N_Vector x, N_Vector f, SUNMatrix J, void *ctx, N_Vector a, N_Vector b, N_Vector c)
{
    (void)f, (void)a, (void)b, (void)c;
    const struct problem *p = ((struct job *)ctx)->p;
    double v[16 * 16];
    p->slope(t, N_VGetArrayPointer(x), v);
    for (int i = 0; i < p->n; i++)
        for (int k = 0; k < p->n; k++)
            SM_ELEMENT_D(J, i, k) = v[i * p->n + k];
    return 0;
}

static int residual(realtype t, N_Vector x, N_Vector dx, N_Vector r, void *ctx)
{
    int e = field(t, x, r, ctx);
    N_VLinearSum(1, dx, -1, r, r);
    return e;
}

/* cj I - J */
static int shifted_slope(realtype t, realtype cj, N_Vector x, N_Vector dx, N_Vector r, SUNMatrix J, void *ctx, N_Vector a,
                         N_Vector b, N_Vector c)
{
    (void)dx;
    const struct problem *p = ((struct job *)ctx)->p;
    slope(t, x, r, J, ctx, a, b, c);
    for (int i = 0; i < p->n; i++)
        for (int k = 0; k < p->n; k++)
            SM_ELEMENT_D(J, i, k) = (i == k ? cj : 0) - SM_ELEMENT_D(J, i, k);
    return 0;
}

static void silent(int code, const char *module, const char *function, char *msg, void *ctx)
{
    (void)code, (void)module, (void)function, (void)msg, (void)ctx;
}

/* What a solution holds; freed in one place. */
struct work {
    SUNContext context;
    N_Vector x, dx;
    SUNMatrix J;
    SUNLinearSolver linear;
    SUNNonlinearSolver nonlinear;
    void *memory;
};

static bool cvode(struct work *w, struct job *j, int kind, double rtol)
{
    w->memory = CVodeCreate(kind == ADAMS ? CV_ADAMS : CV_BDF, w->context);
    CVodeSetErrHandlerFn(w->memory, silent, NULL);
    bool ok = !CVodeInit(w->memory, field, 0, w->x) && !CVodeSetUserData(w->memory, j) &&
              !CVodeSStolerances(w->memory, rtol, rtol * j->p->floor) && !CVodeSetMaxNumSteps(w->memory, MOST_STEPS);
    if (kind == ADAMS) {
        w->nonlinear = SUNNonlinSol_FixedPoint(w->x, 0, w->context);
        return ok && !CVodeSetNonlinearSolver(w->memory, w->nonlinear);
    }
    return ok && !CVodeSetLinearSolver(w->memory, w->linear, w->J) && !CVodeSetJacFn(w->memory, slope);
}

static bool arkode(struct work *w, struct job *j, const struct peer *peer, double rtol)
{
    if (peer->kind == ERK) {
        w->memory = ERKStepCreate(field, 0, w->x, w->context);
        ERKStepSetErrHandlerFn(w->memory, silent, NULL);
        return !ERKStepSetUserData(w->memory, j) && !ERKStepSetTableNum(w->memory, (ARKODE_ERKTableID)peer->order) &&
               !ERKStepSStolerances(w->memory, rtol, rtol * j->p->floor) && !ERKStepSetMaxNumSteps(w->memory, MOST_STEPS);
    }
    w->memory = ARKStepCreate(NULL, field, 0, w->x, w->context);
    ARKStepSetErrHandlerFn(w->memory, silent, NULL);
    return !ARKStepSetUserData(w->memory, j) &&
           !ARKStepSetTableNum(w->memory, (ARKODE_DIRKTableID)peer->order, ARKODE_ERK_NONE) &&
           !ARKStepSStolerances(w->memory, rtol, rtol * j->p->floor) && !ARKStepSetMaxNumSteps(w->memory, MOST_STEPS) &&
           !ARKStepSetLinearSolver(w->memory, w->linear, w->J) && !ARKStepSetJacFn(w->memory, slope);
}

static bool ida(struct work *w, struct job *j, double rtol)
{
    w->dx = N_VClone(w->x);
    field(0, w->x, w->dx, j);
    w->memory = IDACreate(w->context);
    IDASetErrHandlerFn(w->memory, silent, NULL);
    return !IDAInit(w->memory, residual, 0, w->x, w->dx) && !IDASetUserData(w->memory, j) &&
           !IDASStolerances(w->memory, rtol, rtol * j->p->floor) && !IDASetMaxNumSteps(w->memory, MOST_STEPS) &&
           !IDASetLinearSolver(w->memory, w->linear, w->J) && !IDASetJacFn(w->memory, shifted_slope);
}

/* CVODE and IDA interpolate at the samples, to their order; ARKODE's polynomials are of lower order than its formulas,
 * which are stopped at them. */
static bool advance(struct work *w, int kind, double stop)
{
    double t;
    switch (kind) {
    case ADAMS:
    case BDF:
        return CVode(w->memory, stop, w->x, &t, CV_NORMAL) >= 0;
    case ERK:
        return !ERKStepSetStopTime(w->memory, stop) && ERKStepEvolve(w->memory, stop, w->x, &t, ARK_NORMAL) >= 0;
    case DIRK:
        return !ARKStepSetStopTime(w->memory, stop) && ARKStepEvolve(w->memory, stop, w->x, &t, ARK_NORMAL) >= 0;
    default:
        return IDASolve(w->memory, stop, &t, w->x, w->dx, IDA_NORMAL) >= 0;
    }
}

static void clear(struct work *w, int kind)
{
    if (kind == ERK)
        ERKStepFree(&w->memory);
    else if (kind == DIRK)
        ARKStepFree(&w->memory);
    else if (kind == IDA)
        IDAFree(&w->memory);
    else
        CVodeFree(&w->memory);
    if (w->nonlinear)
        SUNNonlinSolFree(w->nonlinear);
    if (w->linear)
        SUNLinSolFree(w->linear);
    if (w->J)
        SUNMatDestroy(w->J);
    if (w->dx)
        N_VDestroy(w->dx);
    N_VDestroy(w->x);
}

bool sundials_solve(const struct problem *p, const struct peer *peer, double rtol, struct outcome *o)
{
    static SUNContext context;
    if (!context)
        SUNContext_Create(NULL, &context);
    struct job j = {p, 0};
    double begin = cpu_seconds();
    struct work w = {.context = context, .x = N_VNew_Serial(p->n, context)};
    memcpy(N_VGetArrayPointer(w.x), p->start, (size_t)p->n * sizeof *p->start);
    if (peer->implicit) {
        w.J = SUNDenseMatrix(p->n, p->n, context);
        w.linear = SUNLinSol_Dense(w.x, w.J, context);
    }
    bool ok = peer->kind == IDA ? ida(&w, &j, rtol)
              : peer->kind == ERK || peer->kind == DIRK ? arkode(&w, &j, peer, rtol) : cvode(&w, &j, peer->kind, rtol);
    for (int k = 0; k < p->samples && ok; k++) {
        ok = advance(&w, peer->kind, p->times[k]);
        take_sample(p, N_VGetArrayPointer(w.x), k, o);
    }
    clear(&w, peer->kind);
    o->seconds = cpu_seconds() - begin;
    o->evaluations = j.evaluations;
    return ok;
}
