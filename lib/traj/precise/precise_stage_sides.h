/* Inside the traj folder: switches along implicit steps in double-double (precise_stage_sides.c). */
#ifndef SGA_TRAJ_PRECISE_STAGE_SIDES_H
#define SGA_TRAJ_PRECISE_STAGE_SIDES_H

#include "precise_series.h"
#include "precise_stages.h"

struct stage_sides {
    int s, count;              /* stages, switches */
    struct expansions *w;      /* at points where switches turn; w->change: over the last step attempted, whose length is w->here.scale */
    num_dd *g, *part, *x;      /* arguments by switch at 0 and the nodes; one as a polynomial over the step; n: work */
    double *work;
    double *noise, *rough, *in; /* by switch: what rounding leaves of it; in double; n + 1 */
};

/* NULL: there are no switches. */
struct stage_sides *stage_sides_new(struct precise_march *m, int s);
void stage_sides_free(struct stage_sides *q);
/* No change is known from here. */
void stage_sides_forget(struct stage_sides *q);
/* All sides are taken at here. False: there are none (m->why), or the march ended. */
bool stage_sides_begin(struct stage_sides *q, struct precise_march *m, double size);
/* The step: h, or to the first change that is known (m->sides.heading). */
num_dd stage_sides_size(struct stage_sides *q, struct precise_march *m, num_dd h);
/* A step of h was made to m->there, which is a point of the set. It keeps its sides up to there? Otherwise it is made anew: to the first change, or *cut is smaller. */
bool stage_sides_agree(struct stage_sides *q, struct precise_march *m, const struct precise_stages *st, num_dd h, double *cut);
/* Here is where the step ended: what turns there is turned. False: the march ends (precise_end was called). */
bool stage_sides_pass(struct stage_sides *q, struct precise_march *m, double size);

#endif
