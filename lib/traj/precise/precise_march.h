/* Inside the traj folder: one solution in double-double as it marches, and how its steps are made.
 *
 * precise_march.c goes from point to point and delivers samples; a method (a const struct of
 * functions: precise_series.c, precise_radau.c) makes the steps; precise_choice.c says which. */
#ifndef SGA_TRAJ_PRECISE_MARCH_H
#define SGA_TRAJ_PRECISE_MARCH_H

#include "dd.h"
#include "ode.h"

struct precise;
struct precise_path;

enum precise_outcome { PRECISE_TAKEN, PRECISE_TOO_LARGE, PRECISE_REFUSED };

struct precise_point {
    num_dd t, *x;
};

struct precise_march;
struct precise_watch;

struct precise_method {
    const char *name;
    /* Of this march; m->rtol, m->atol are set. */
    void *(*alloc)(struct precise_march *m);
    void (*free)(void *state);
    /* Steps begin at m->here; size: a guess of theirs, or of the motion's scale. False: none can (m->why). */
    bool (*begin)(void *state, struct precise_march *m, double size);
    /* The next step, signed, cut times what it would be. */
    num_dd (*size)(void *state, struct precise_march *m, double cut);
    /* A step of h from m->here to m->there, which precise_arrive has made a point of the set. Otherwise *cut
     * is made smaller. */
    enum precise_outcome (*attempt)(void *state, struct precise_march *m, num_dd h, double *cut);
    /* The solution at a time inside the last step attempted. */
    void (*value)(const void *state, const struct precise_march *m, num_dd t, num_dd *x);
    /* m->here is the end of the last step attempted from now on. False: the march ends there (precise_end was called). */
    bool (*accepted)(void *state, struct precise_march *m);
    /* About what a step takes, in multiplications in double-double. */
    double (*cost)(const void *state, const struct precise_march *m);
};

extern const struct precise_method precise_series, precise_radau;

/* Which method; precise_choice.c. */
struct precise_choice {
    bool free, asked;          /* it may change; implicit steps were asked for */
    long try_at, wait, look;   /* steps: when other steps are tried, how many more then, and between looks */
    bool on_trial;
    long trial_from;           /* steps at the begin of the trial */
    double before;             /* progress for the work of the steps before it */
    double size, work;         /* means over the last steps */
    void *state[2];
    long steps[2];             /* made by series, by implicit steps */
    long rescued;              /* steps + 1 when steps shrank to nothing last; 0: never */
    enum ode_reason rescued_why;
};

/* The switches of the field and the constraints, and on which side each is held. precise_sides.c. */
struct precise_sides {
    int count;
    signed char *side;         /* 0: not held */
    unsigned char *pending;    /* the step attempted ends where it changes */
    double *rounding, *doubt;  /* of the arguments: see precise_sides.c */
    struct num_jacobian *slopes;      /* of the arguments */
    double *in, *slope;        /* work: n + 1; of slopes */
    struct num_jet2 *surface;  /* of the arguments, their values alone */
    num_dd *argument;          /* as they were noted last */
    bool natural;              /* nothing is held in the present step */
    bool heading;              /* the step ends at a change */
    num_dd turned_t; int turned;      /* where a switch was turned last, and how many there */
    int tries;                 /* to end the present step at a change */
};

struct precise_march {
    struct precise *p;
    struct precise_path *path;
    int n, next, next_piece, passed_knots;
    double rtol, atol, direction, first_size;
    double band_cut;           /* the next step is no longer than this; 0: no matter */
    double *along, *rate, *calm;       /* n: the field at here; its size; the largest where steps were no small part of the time passed */
    double work;               /* of all steps, in multiplications in double-double */
    bool beside, start_beside;
    struct precise_point here, there;
    long look_at; num_dd look_t; int hopeless;     /* see out_of_reach */
    double *scale;             /* n: the error allowed */
    struct precise_watch *watch;       /* precise_event.c; NULL: no events */
    enum ode_reason why;
    double *xd, *fd;           /* n: in double */
    num_dd *sought;            /* n: work */
    const struct precise_method *method;
    void *state;
    struct precise_choice choice;
    struct precise_sides sides;
};

/* Steps that solutions have in common show no difference of theirs: into so many parts this one divides what is the same way in all. */
int precise_parts(const struct precise *p);

/* precise_march.c. m->scale for a point x. */
void precise_set_scale(struct precise_march *m, const num_dd *x);
/* Root mean square in units of m->scale; v may be so large that squares overflow. */
double precise_weighted(const struct precise_march *m, const num_dd *v);
/* m->there, where a step ends, is moved onto the set; false (m->why) where it is far from it or the field has no
 * value that ranks and signs allow. */
bool precise_arrive(struct precise_march *m);
double precise_largest(const num_dd *x, int n);
/* The same without asking where the point came from. */
bool precise_settle(struct precise_march *m, struct precise_point *q);
/* The field has a value at q that the rank and the pivots' signs allow, and what was given holds; otherwise m->why. */
bool precise_allowed(struct precise_march *m, const struct precise_point *q);
/* The march ends at here. */
void precise_end(struct precise_march *m, enum ode_reason reason, const char *detail);
/* Time from here to the last sample; to the next knot of a table, if that comes before. */
num_dd precise_rest(const struct precise_march *m);
num_dd precise_goal_rest(const struct precise_march *m);
/* Where a step of h ends: the knot itself, or the last time, if it comes to it. */
num_dd precise_after(const struct precise_march *m, num_dd h);

/* precise_jump.c. m->here, on the constraints that hold now. Where these jump, what no equation differentiates is solved for anew, and of sums that are
 * differentiated the parts, in double first, which says where to. False: m->why, and here as it was. */
bool precise_land(struct precise_march *m);
/* Arguments of switches at (t, x), into g, by steps of `step`; false: they have no values. */
bool precise_arguments(struct precise_march *m, num_dd t, const num_dd *x, num_dd *g, size_t step);
/* Those at here, into m->sides.argument (NaN where they have none); and whether that of e jumped from `was` to what was noted last, off its surface (m->sides.doubt). */
void precise_note_arguments(struct precise_march *m);
bool precise_leaps(const struct precise_sides *q, int e, num_dd was);
/* Arguments are noted at here again; those that jumped to their other sides since turn their switches: how many. After so many rounds they turn each other without end. */
int precise_turn_leapt(struct precise_march *m);
static inline int precise_rounds(const struct precise_march *m) { return 2 * m->sides.count + 2; }
/* precise_knots.c. h, but not beyond the next knot nor almost to it. */
num_dd precise_within_knots(const struct precise_march *m, num_dd h);
/* Tables are their polynomials of the first piece. */
void precise_knots_begin(struct precise_march *m);
/* The motion has come to here by a step of this size: where that is a knot, it goes on in the next piece, and what may jump there does. False: the march
 * is over. */
bool precise_pass_knot(struct precise_march *m, double size);

/* precise_sides.c. Nothing is held at first, nor afterwards. */
void precise_sides_begin(struct precise_march *m);
void precise_sides_end(struct precise_march *m);
/* Series come to nothing before a surface on which they are no more (of sqrt(abs(x))): the march goes on beyond it. False: that is not why, or it ends (precise_end was called). */
bool precise_sides_cross(struct precise_march *m, double size);

/* precise_event.c: around the march, whose start m->here is; the events of the last step attempted, into the path, and the place of what stops the motion (at *end)
 * or of the last that a result may hold; PRECISE_NO_PLACE: one of them is no point of the constraints. The step may still be refused; precise_watched: it was taken. */
enum precise_stop { PRECISE_GOES_ON, PRECISE_STOPPED, PRECISE_TOO_MANY, PRECISE_NO_PLACE };
void precise_watch_begin(struct precise_march *m);
void precise_watch_end(struct precise_march *m);
enum precise_stop precise_watch(struct precise_march *m, num_dd *end);
void precise_watched(struct precise_march *m);

/* precise_band.c: where in (0, 1) of the step h that was just made to m->there a pulse of the field lies that both ends are outside of;
 * 2: nowhere. */
double precise_band(struct precise_march *m, num_dd h);

/* precise_choice.c. */
void precise_choice_begin(struct precise_march *m);
/* After a step of this size: by another method from now on? */
void precise_choose(struct precise_march *m, double size);
/* Steps shrink to nothing though the field has values (a kink), or has none on the side that a switch is held on: true where series, which see kinks, go on. */
bool precise_rescue(struct precise_march *m);
/* No series at the start (a root at its border): true where implicit steps, which need none, begin. */
bool precise_begin_without_series(struct precise_march *m, double size);
/* The field has other programs from now on: the states are made anew; begin is due. */
void precise_choice_renew(struct precise_march *m);
/* Frees the states; the path's name of the methods. */
void precise_choice_end(struct precise_march *m);

#endif
