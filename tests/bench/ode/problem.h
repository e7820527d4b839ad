/* A system of the integrators' benchmark, reduced by hand: cases.py writes the table. */
#ifndef BENCH_ODE_PROBLEM_H
#define BENCH_ODE_PROBLEM_H

#include <stdbool.h>

struct problem {
    const char *name;
    int stiff, n, samples, columns;
    void (*field)(double t, const double *x, double *dx);
    void (*slope)(double t, const double *x, double *J);   /* n x n by rows */
    const double *start;              /* at t = 0, consistent */
    const double *times;              /* samples */
    const double *reference;          /* samples x columns */
    const int *column;                /* variables that the reference gives */
    double floor;                     /* errors are relative to |value| + floor */
};
extern const struct problem problems[];
extern const int problem_count;

/* One solution: the columns at the samples into out, CPU seconds. False: it failed. */
struct outcome {
    double out[64];
    double seconds;
    long evaluations;
};
struct peer {
    const char *name;
    int kind;                         /* of its library */
    int order;
    bool implicit;                    /* takes the Jacobian: for stiff systems */
};
extern const struct peer sundials_peers[], gsl_peers[];   /* ended by a name NULL */
bool sundials_solve(const struct problem *p, const struct peer *peer, double rtol, struct outcome *o);
bool gsl_solve(const struct problem *p, const struct peer *peer, double rtol, struct outcome *o);

double cpu_seconds(void);
void take_sample(const struct problem *p, const double *x, int sample, struct outcome *o);

#endif
