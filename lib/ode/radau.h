/* Inside the ode folder: the state of the Radau IIA method. radau.c is the method as the
 * driver sees it, radau_newton.c solves for the stages. */
#ifndef SGA_ODE_RADAU_H
#define SGA_ODE_RADAU_H

#include "partials.h"

struct radau {
    int n;
    const struct ode_problem *p;
    double field_cost;             /* of one evaluation, in multiplications */
    const struct radau_table *tab;
    const struct ode_implicit *eq; /* the problem's equations; or NULL */
    struct ode_partials partials;
    struct lin_shift *lin;
    double *jac;                   /* in the pattern's order */
    double *mass, *v;              /* where the problem has its equations: likewise; derivatives at the stages, s x n. NULL: it has not */
    int sign;                      /* what the real determinant's is for short steps; 0: not known */
    bool sign_fresh;               /* of the present Jacobian */
    bool jac_known, jac_fresh;     /* fresh: taken at the start of this step */
    double jac_h;                  /* the size of the step that it was taken for */
    double factored_h;             /* 0: not factored for this Jacobian */
    const struct radau_table *factored_tab;
    /* Stages: increments z_i = X_i - x, the same transformed, the field there, and the
     * right-hand sides; all s x n. */
    double *z, *w, *f, *r, *pair, *scale, *err, *memory;
    double eta;                    /* theta / (1 - theta) of the last step */
    double theta, contraction;     /* of the last solution: last rate, and its mean */
    int iterations;
    /* The polynomial of the last accepted step, to start from. */
    double *old_z, old_h;
    const struct radau_table *old_tab;
    int since_change;              /* steps */
    bool trouble;                  /* the last step had to be repeated for lack of convergence */
    bool refused_before;
    double refused_off, refused_h; /* of the last attempt at this step: see starts_off; 0: there was none */
    double kept;                   /* what steps since the last factorisation have lost by its matrices, in such steps */
    int fresh_iterations;          /* of the last one with a Jacobian of its own */
};

enum radau_outcome { RADAU_SOLVED, RADAU_REFUSED, RADAU_DIVERGED };

/* The stages of a step of size step->h: r->z. Takes the Jacobian and factors where that is
 * needed; RADAU_DIVERGED only with a fresh Jacobian. Adds to step->cost, sets step->retry. */
enum radau_outcome radau_stages(struct radau *r, struct ode_field *field, struct ode_step *step);

/* out (n) += M v, where the problem has its equations. */
void radau_mass_times(const struct radau *r, const double *v, double *out);

/* out = sum_i (L_i(theta) - minus_end L_i(1)) z_i, L_i the polynomials of the nodes and 0. */
void radau_polynomial(const struct radau_table *tab, int n, const double *z, double theta, bool minus_end, double *out);

#endif
