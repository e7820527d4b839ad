/* Inside the traj folder: one choice of sides and slides at a point where surfaces meet, tried. */
#ifndef SGA_TRAJ_SLIDE_TRIAL_H
#define SGA_TRAJ_SLIDE_TRIAL_H

#include "slide.h"

struct num_tape;

/* A mode with the derivatives of what decides in it: of the surface's function, or of the switch on a slide. */
struct ways {
    const struct traj_mode *mode;
    expr_id *root[2];
    struct num_tape *tape[2];     /* surface by surface: Taylor coefficients 0 to FIRST, to LAST */
    struct jump jump; bool ready;
    struct ways *next;
};

/* Of a mode, kept for the motion. */
struct ways *slide_ways(struct slide *s, const struct traj_mode *m);

/* Values of all roots at (t, x), and what of each is not told from 0. speed: by variable its derivative, or NULL. */
struct told { double *value, *doubt, *rounding; int order; };      /* rounding: of what is added up in it */
/* By Taylor coefficients along the mode's field, 0 to out->order, surface by surface; level: 0, or 1 for more of them. out->value is the caller's to free, whatever is returned. False: err. */
bool slide_tell(struct ways *w, int level, double t, const double *x, const double *speed, struct told *out, struct sga_error *err);

enum way { NO_WAY, IS_WAY, BRIEF, NOT_TOLD };      /* BRIEF: a slide that is over at once: none where there is another way */

/* What one choice comes to. */
struct trial {
    enum way way;
    const char *what;             /* NOT_TOLD: what is not; static or the mode's */
    struct traj_initial start; bool has_start;
    bool stays;                   /* it starts where the motion is */
    const struct traj_mode *mode;
};

/* A surface that is asked: the point lies on it, or its side is not what other switches leave it. */
enum { AT_IT = 1, TURNED };

/* One decision. */
struct decision {
    struct slide *s;
    struct jump *now; const struct traj_mode *from; const struct jump_at *at;
    int surfaces, along;
    double doubt;                 /* 1, or 0: derivatives are what they are */
    double *size;                 /* of what has a derivative, by all that was tried so far: sides come before slides */
    double *was, *grain;          /* by surface: its function as the motion comes; what it may move by without a jump */
    unsigned char *open;          /* by surface: it is asked */
    unsigned char *other;         /* by surface that is not: it would have to be */
};

/* slide.c. By surface its choice. slide_trial_clear is due. False: err. */
bool slide_try(const struct decision *d, const int *choice, struct trial *out, struct sga_error *err);
void slide_trial_clear(struct trial *t);

/* slide_many.c. More open surfaces than all of whose choices can be tried: where the first derivatives of their functions are affine in the switches, by a matrix with positive
 * principal minors, one choice is left, whatever the derivatives are (linear complementarity within -1 to 1; Cottle, Pang, Stone, The Linear Complementarity
 * Problem, 2009, 3.3): it is found by least-index pivots and tried. choice: as it is, and as it will be; *ways: 1 where it was found; *why: not told, static.
 * Cost: reductions of two more than surfaces are open, and of the one found; 2 to the number of open surfaces determinants. False: err. */
bool slide_many(const struct decision *d, int *choice, int *ways, const char **why, struct sga_error *err);

#endif
