/* The geometry of mechanical constraints: the extended configuration space W, the conditions on its
 * fibre, the acceleration and its parts, the reaction, and where the source's assumptions fail.
 *
 * Source: A. Szatkowski, Arch. Mech. 42 (1990) 151-174. W is the set of positions and velocities that the
 * constraints h(X, eta) = 0 leave, with the velocity constraint of each function of X alone that
 * vanishes there; H is the matrix of the differentials along the fibre E_X of functions that
 * vanish on W. It is found by the reduction itself, run on X' = eta, 0 = h with eta' left open: where W is a fibre
 * bundle nothing else can come out, and irregular functions (squares, repeated ones) are replaced on the way. */
#ifndef SGA_MECH_MECH_H
#define SGA_MECH_MECH_H

#include "system.h"

struct form_mechanical;
struct points_oracle;
struct reduction_options;
struct sga_solution;

struct mech_fibre {
    struct sys_system kinematics;        /* X' = eta, 0 = h */
    struct sga_solution *W;              /* owned, NULL: nothing is solved; its constraints are W; empty where inconsistent */
    struct points_oracle *oracle;        /* owned: points of W */
    /* Functions whose differentials along the fibre are independent on W and span what is possible: H
     * has these rows. own: they are the request's constraints (or the derivatives of these), so that their multipliers
     * are the request's. */
    bool own;
    expr_id *condition; int conditions;
    int *constraint;                     /* the constraint that condition[i] comes from, where own; otherwise i */
    int *redundant; int redundants;      /* constraints whose condition follows from the others' */
    expr_id *H;                          /* conditions x coordinates */
    expr_id *rate;                       /* (D_X h) eta + d_t h, by condition: H xi = -rate */
};

/* Runs the reduction on the constraints and chooses the conditions. Where the system is restricted to a
 * subset, W is that subset, and the conditions are those of the whole W's fibre over it (remark 4 of the source: a subsystem
 * keeps the reactions of the system). NOT_SUPPORTED where that fibre has no tangent space. options as in sga_reduce,
 * near by coordinate and velocity. False with err; UNDECIDED where the rank of H could not be told at the
 * points found. Cost: a reduction, and cubic in the number of constraints. */
bool mech_fibre_find(struct mech_fibre *f, const struct sys_system *system, const struct form_mechanical *in,
                     const struct reduction_options *options, struct sga_error *err);
void mech_fibre_clear(struct mech_fibre *f);

/* By coordinate; the tangent and the orthogonal part add up to the total. */
struct mech_motion {
    expr_id *total, *tangent, *orthogonal, *reaction;
};

/* xi from M xi - H^T lambda = F, H xi = -rate; xi_o = -H^T (H H^T)^{-1} rate; R = H^T lambda. Few
 * conditions are solved in closed form, more as a linear solve. What is divided by is
 * assumed not to vanish. Cost: small. */
void mech_motion_find(struct mech_motion *m, const struct mech_fibre *f, const struct form_mechanical *in);
/* The parts of an acceleration that is known from elsewhere (total, by coordinate): where the motion is determined
 * on a part of W only. R = M xi - F. */
void mech_motion_of(struct mech_motion *m, const struct mech_fibre *f, const struct form_mechanical *in, const expr_id *total);
void mech_motion_clear(struct mech_motion *m);

/* Assumption III of the source: the rank of H is full all along W. */
enum mech_full { MECH_FULL_PROVED, MECH_FULL_SEARCHED, MECH_DROPS, MECH_DROP_SUSPECTED };
struct mech_regularity {
    enum mech_full full;
    double *point;          /* of W, by coordinate and velocity, where the rank drops; or NULL */
    double t;
    bool certified;         /* such a point was proved to exist beside it */
    int rank, augmented;    /* of H and of [H, -rate] there */
    expr_id *where; int wheres;   /* factors of what the elimination divided by that vanish there */
};

/* First by proof (no factor of a pivot can vanish, or the Gram determinant cannot), then by a search for
 * points of W with c^T H = 0, |c| = 1. Adds symbols for c to the store. */
void mech_regularity_find(struct mech_regularity *r, struct mech_fibre *f, const struct form_mechanical *in,
                          const struct reduction_options *options);
void mech_regularity_clear(struct mech_regularity *r);

#endif
