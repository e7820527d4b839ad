/* Sums of multiples of equations and tangencies, and the velocities that are put into them. */
#ifndef SGA_RUN_SUMS_H
#define SGA_RUN_SUMS_H

#include "steps.h"

struct sga_part;

/* What the derivation has so far. Numbers of steps are 0 where there is none yet. */
struct derivation {
    struct job *j;
    struct sga_arena mem;
    struct derivation_sheet sheet;
    struct steps steps;
    int *given;                   /* by row: the step */
    int *restricted;              /* by restriction */
    int *special;                 /* of the general points that contradict: by function */
    int *found;                   /* by constraint */
    int *insert;                  /* by constraint: the sum that left it */
    int *differentiated;          /* by constraint */
    int *solved;                  /* by rate */
    expr_id *xi;                  /* by constraint: the printed function, in the sheet */
};

/* A combination that is to become a step. */
struct derivation_sum {
    const struct sga_part *part; int parts;
    bool minus;                   /* printed_factor */
    expr_id divisor;
    int generation, epoch;        /* velocities of that epoch, from eliminations before `generation` */
    int before;                   /* rates before this one (all: INT_MAX) */
};

/* The terms of the sum and what is put in, as steps of their own where they are not there yet; then they are used by the step `number`. Whether
 * only velocities are left that these steps do not determine is `open`. */
struct derivation_terms {
    struct step_term *term; int terms;
    int *use; int uses;           /* solved velocities that are put in, and constraints' or rows' steps that settle the rest */
    bool velocities;              /* some had to be put in: */
    int *rate; int rates;         /* these, by rate */
    expr_id sum;                  /* before that; EXPR_UNDEF: some part cannot be written */
    bool open;                    /* some stay whose coefficients vanish, or that follow from all equations used */
};
struct derivation_terms derivation_sum_terms(struct derivation *d, const struct derivation_sum *sum);
void derivation_use_terms(struct derivation *d, struct step *p, const struct derivation_terms *t);
/* "(3), 1/2*(4)" and "with (1), (2) put in", appended. */
void derivation_terms_text(struct derivation *d, const struct derivation_terms *t, struct sga_buf *out);
/* Whether the sum, with what is put in, is `leaves` wherever both have a value: then no constraint is needed. */
bool derivation_sum_is(struct derivation *d, const struct derivation_terms *t, expr_id leaves);
/* The step holds on the constraints that were found before constraint i (all of them: the number of constraints). */
void derivation_on_constraints(struct derivation *d, struct step *p, int i);
/* The number of the step that differentiates constraint i. */
int derivation_differentiate(struct derivation *d, int constraint);

#endif
