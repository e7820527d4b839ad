/* Inside the traj folder: several reductions of one system, each good where its pivots are large, as charts of a motion.
 *
 * A reduction divides by pivots, and what is derived later carries them: where one of them comes to 0 along a motion, its
 * constraints and its field lose their digits and then their values, though the rank of the equations may stay. Then other pivots
 * could have been taken. A chart more is the reduction of the same system with the pivots that are large at the place where the
 * motion ended; the motion is made once more, and at a step's end goes over to the chart whose pivots have shrunk least. Charts
 * have the same final set near the place (dimension and ranks are compared, and the constraints and the field there), so that x
 * means the same in each, and what is integrated is one motion.
 *
 * The chart in use lies in the flow itself (manifold, field, series, given equations, noise), the others beside it. */
#ifndef SGA_TRAJ_CHARTS_H
#define SGA_TRAJ_CHARTS_H

#include "flow.h"

/* Field and constraints of a chart in double-double, made where they are asked for first. */
struct charts_exact { struct num_jet2 *field, *constraint; };
/* charts_noise.c. The largest relative rounding of the field, and of the constraints as distances, near (t, x). Cost: some evaluations in
 * double-double. */
double charts_noise(struct charts_exact *e, struct field *f, struct manifold *m, double t, const double *x);
void charts_exact_clear(struct charts_exact *e);

/* Where a motion went over to another chart. */
struct charts_change {
    double t;
    int pivot, left;              /* the pivot that had shrunk, and in which chart; its text: charts_pivot */
};

struct charts {
    const struct sga_solution *first; const struct traj_request *rq;      /* borrowed */
    int count, at;                /* of all; the one in the flow */
    struct chart *chart;
    double start;                 /* where each solution begins: in chart 0 */
    double *in, *value;           /* work: n + 1; the longest direct tape */
    struct lin_sparse *pattern;   /* of dX/dx in all charts; NULL: as in the first */
    const signed char *side;      /* where switches are held now, borrowed; NULL: they are not */
    int *place;                   /* by chart: entries of its pattern in it */
    bool stop;                    /* a chart was added on the way: the motion is to be made once more, and this one goes no further */
    int tries;                    /* to add one */
    double looked; int since;     /* how small a pivot was when the others were looked at last, and steps since then */
    struct charts_change *change; int changes; size_t change_cap;      /* of the solution that was marched last */
};

/* A reduction of the kind of `first` whose pivots are large at the values that the request gives: true, and *own and *oracle are due to be
 * cleared, where there is one and constraints of `first` may carry pivots. */
bool charts_solve_at_start(const struct sys_system *sys, const struct sga_solution *first, const struct traj_request *rq, struct sga_solution *own,
                           struct points_oracle *oracle);
/* For a flow that is ready: its first chart, where constraints may carry pivots that come to 0. */
void charts_init(struct flow *f, const struct sga_solution *first, const struct traj_request *rq);
/* A chart for where the motion of this flow ended, at the last point that it took (stop is set). False, and nothing is changed: what ended it is no
 * pivot that shrinks, no other pivots are there, the rank drops, or the system has switches that the charts do not share. Cost: a
 * reduction. */
bool charts_add(struct flow *f);
/* After a chart was added: the next solutions know it. */
void charts_again(struct flow *f);
/* Each solution begins in the first one. */
void charts_begin(struct flow *f);
/* Back to the first, the list of changes as it is. */
void charts_return(struct flow *f);
/* The motion has come to (t, x): whether it went over to another chart, and x was moved to the set as that has it. Where a pivot is on its way to 0 and no chart is better one may be
 * added (stop). Cost: the pivots; where one is small, some evaluations in double-double. */
bool charts_choose(struct flow *f, double t, double *x);
/* The largest relative rounding of field and constraints in the chart in use where the motion ended (charts_noise); 0: not known. */
double charts_lost(struct flow *f);
/* The text of the pivot that a change left, malloced. */
char *charts_pivot(struct flow *f, const struct charts_change *c);
/* dX/dx in charts->pattern. */
bool charts_slope(struct flow *f, double t, const double *x, double *value);
void charts_clear(struct flow *f);

#endif
