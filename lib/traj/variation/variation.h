/* The motion together with its derivatives by parameters and initial values, as a system of its own.
 *
 * Of A x' = alpha with the final set xi = 0 and the field X there, all of them functions of a parameter k too, the derivative S = dx/dk satisfies
 *     A S' + (A_x S + A_k) x' = alpha_x S + alpha_k,    xi_x S + xi_k = 0,    S' = X_x S + X_k,
 * and the derivative by an initial value the same without the terms in k. The pair (x, S) is the motion of a system whose final set is the
 * tangent set of the other, so that it is integrated, projected and judged like any motion. Where the gauge is chosen (rates, least norm) the
 * field with the choice in it is what is differentiated. Where the motion turns a switch at a time that depends on k, S jumps by
 *     (X- - X+) dt/dk,    dt/dk = -(g_x S + g_k) / (g_x X- + g_t)    for the surface g = 0.
 * At events that set variables derivatives jump too: jump_slope.h.
 * (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, I.14 and II.6.) */
#ifndef SGA_TRAJ_VARIATION_H
#define SGA_TRAJ_VARIATION_H

#include "reduction.h"
#include "system.h"
#include "trajectory.h"

struct defined;

struct variation_by {
    int parameter;             /* symbol of the store, or -1: */
    int variable;              /* by the value that the request gives for it */
};

struct variation {
    bool of_defined;           /* equations define variables: what is differentiated is the rest, defined.system */
    struct defined *defined;
    const struct variation_by *by;   /* borrowed */
    int n, directions;         /* variables that are differentiated */
    struct sys_system system;  /* x, then the derivatives, direction by direction */
    struct sga_solution solution;
    struct traj_request request;   /* outputs: derivatives of those asked for, output by output; then these themselves */
    int outputs;               /* that were asked for, or all variables */
    struct traj_turns turns;
    struct traj_slopes slopes;
    struct traj_asked asked;   /* set by variation_place and variation_place_nearest, for balls */
    struct traj_relation *relation;   /* in balls: the relations of its start, each followed by its derivatives */
    bool jumps;                /* events set something: motions are those of the request that is differentiated, with this system as what is carried */
    bool may_jump;             /* the motion's field may jump, or its constraints bend, at a switch */
    double *initial;           /* the request's lists; set by variation_place, from the guess of what is differentiated (n each): */
    unsigned char *given, *held;
    double *guess;
    unsigned char *guessed, *kept;
    expr_id *exact, *output, *surface, *slope, *rate, *field, *event_slope, *set_slope, *mass_slope;
};

/* sys, sol and rq, with everything that the derivatives are taken by as symbols; expressions go to the store of sys. guess: directions x variables of sys, the
 * derivative of each given initial value. False with err: the field is not written as expressions (GAUGE), or a limit. variation_clear is due in any
 * case. `by` must outlive it. Cost: the expressions times the directions. */
bool variation_make(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                    const struct variation_by *by, int directions, const expr_id *guess, struct sga_error *err);
void variation_clear(struct variation *v);

/* The start of the derivatives. sys, sol and rq are the copies of those of v at values of the parameters; x: the start of the motion, by
 * variable of the whole. Where the start is given and stays so far that it is determined (given values that stay, and zeros of what was not given), rq's
 * start becomes that, and the rest of it is solved for by the constraints: true. False: the derivative has to be had otherwise. */
bool variation_place(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, struct traj_request *rq, const double *x);
/* Whether the start that was placed is off every surface where the equations change, or stays on it along the directions, or (where nothing jumps) leaves it at once:
 * otherwise the motion has another derivative on each side, or none. False: INITIAL with err. */
bool variation_starts_clear(const struct variation *v, const struct sys_system *sys, const struct traj_request *rq, struct sga_error *err);
/* Values of expressions without symbols. False: some have none. */
bool variation_constants(const struct expr_store *st, const expr_id *e, int count, double *value);
/* The start is x, with these derivatives (directions x variables of the whole). */
void variation_place_at(struct variation *v, struct traj_request *rq, const double *x, const double *slope);
/* The same in balls, near the nearest point to what was asked; unit: by variable, as of variation_units (borrowed). False: equations define variables. */
bool variation_place_nearest(struct variation *v, struct traj_request *rq, const double *x, const double *slope, const double *unit);
/* variation_found.c. In balls: the start is the nearest point of rq's relations too, and of bounds (by variable, or NULL) that it lies on, as variation_place_nearest has placed it in rq,
 * which has the relations of v at values of the parameters: rq->found. sys and sol are the copies of those of v. malloced; variation_found_free. */
struct enclosed_found *variation_found(const struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, const double *low, const double *high);
void variation_found_free(struct enclosed_found *found);
/* variation_digits.c. After variation_place_nearest, for double-double: the start and its derivatives become constants with all digits (exact: room for the variables of sys, which must
 * live as long as rq). False: they are not told so well. */
bool variation_digits(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, struct traj_request *rq, expr_id *exact);
/* unit: by variable of the system what a distance of 1 is for the nearest start. False: that of a given value follows the value. */
bool variation_units(const struct sys_system *sys, const struct traj_request *rq, const double *x, double *unit);

#endif
