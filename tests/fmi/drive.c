/* An importer in C for valgrind: an FMU's source is linked with its prefix, as static importers do, and taken through both of its kinds, right and
 * wrong calls, states that are kept and set again. Prints the states at the end; the exit status is 0 if each call gave what it should. */
#define FMI3_FUNCTION_PREFIX sga_model_
#include "fmi3Functions.h"

#include <stdio.h>
#include <stdlib.h>

static int wrong;

static void heard(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)e;
    (void)category;
    fprintf(stderr, "%d: %s\n", status, message);
}

static void is(fmi3Status got, fmi3Status should, const char *what)
{
    if (got == should)
        return;
    printf("%s: %d, not %d\n", what, got, should);
    wrong = 1;
}

static void model_exchange(const char *token, double start)
{
    fmi3Instance m = fmi3InstantiateModelExchange("a", token, NULL, fmi3False, fmi3True, NULL, heard);
    fmi3Boolean a, b, c, d, e;
    fmi3Float64 next;
    fmi3FMUState kept = NULL;
    size_t n = 0, z = 0;
    if (!m) {
        wrong = 1;
        return;
    }
    is(fmi3GetNumberOfContinuousStates(m, &n), fmi3OK, "number of states");
    is(fmi3GetNumberOfEventIndicators(m, &z), fmi3OK, "number of indicators");
    double *x = calloc(n + 1, sizeof *x), *dx = calloc(n + 1, sizeof *dx), *g = calloc(z + 1, sizeof *g);
    is(fmi3EnterContinuousTimeMode(m), fmi3Error, "continuous time at once");
    is(fmi3EnterInitializationMode(m, fmi3True, 1e-9, start, fmi3False, 0), fmi3OK, "enter");
    is(fmi3ExitInitializationMode(m), fmi3OK, "exit");
    is(fmi3UpdateDiscreteStates(m, &a, &b, &c, &d, &e, &next), fmi3OK, "update");
    is(fmi3EnterContinuousTimeMode(m), fmi3OK, "continuous");
    is(fmi3GetFMUState(m, &kept), fmi3OK, "keep");
    for (int k = 0; k < 50; k++) {
        is(fmi3GetContinuousStates(m, x, n), fmi3OK, "states");
        is(fmi3GetContinuousStateDerivatives(m, dx, n), fmi3OK, "derivatives");
        is(fmi3GetEventIndicators(m, g, z), fmi3OK, "indicators");
        for (size_t i = 0; i < n; i++)
            x[i] += 1e-3 * dx[i];
        is(fmi3SetTime(m, start + 1e-3 * (k + 1)), fmi3OK, "time");
        is(fmi3SetContinuousStates(m, x, n), fmi3OK, "set");
        is(fmi3CompletedIntegratorStep(m, fmi3True, &a, &b), fmi3OK, "step");
        if (a) {
            is(fmi3EnterEventMode(m), fmi3OK, "event");
            is(fmi3UpdateDiscreteStates(m, &a, &b, &c, &d, &e, &next), fmi3OK, "project");
            is(fmi3EnterContinuousTimeMode(m), fmi3OK, "go on");
        }
    }
    is(fmi3SetContinuousStates(m, x, n + 1), fmi3Error, "too many states");
    is(fmi3SetFMUState(m, kept), fmi3OK, "back");
    is(fmi3FreeFMUState(m, &kept), fmi3OK, "free");
    is(fmi3Terminate(m), fmi3OK, "terminate");
    is(fmi3SetTime(m, 0), fmi3Error, "after the end");
    fmi3FreeInstance(m);
    free(x);
    free(dx);
    free(g);
}

static void co_simulation(const char *token, double start, double stop, unsigned states)
{
    fmi3Instance m = fmi3InstantiateCoSimulation("b", token, NULL, fmi3False, fmi3True, fmi3False, fmi3False, NULL, 0, NULL, heard, NULL);
    fmi3Boolean a, b, c;
    fmi3Float64 last, t = start;
    if (!m) {
        wrong = 1;
        return;
    }
    is(fmi3DoStep(m, 0, 1, fmi3True, &a, &b, &c, &last), fmi3Error, "step at once");
    is(fmi3EnterInitializationMode(m, fmi3False, 0, start, fmi3True, stop), fmi3OK, "enter");
    is(fmi3ExitInitializationMode(m), fmi3OK, "exit");
    for (int k = 0; k < 4; k++, t = last)
        is(fmi3DoStep(m, t, (stop - start) / 4, fmi3True, &a, &b, &c, &last), fmi3OK, "step");
    is(fmi3DoStep(m, t, 1, fmi3True, &a, &b, &c, &last), fmi3Error, "past the stop time");
    for (unsigned r = 1; r <= states; r++) {
        double v = 0;
        is(fmi3GetFloat64(m, &r, 1, &v, 1), fmi3OK, "value");
        printf("%.17g\n", v);
    }
    is(fmi3Reset(m), fmi3OK, "reset");
    fmi3FreeInstance(m);
}

/* usage: drive TOKEN START STOP STATES */
int main(int argc, char **argv)
{
    if (argc != 5)
        return 2;
    if (fmi3InstantiateModelExchange("a", "another", NULL, fmi3False, fmi3False, NULL, NULL))
        return 1;
    model_exchange(argv[1], atof(argv[2]));
    co_simulation(argv[1], atof(argv[2]), atof(argv[3]), (unsigned)atoi(argv[4]));
    return wrong;
}
