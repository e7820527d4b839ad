/* Inside the run folder: the system that belongs to a stratum. */
#ifndef SGA_RUN_STRATA_CASE_H
#define SGA_RUN_STRATA_CASE_H

#include "form.h"

struct job;
struct points_point;
struct points_space;
struct sga_error;
struct stratum;

/* The mechanical part shares what it does not change with the request. */
struct strata_case {
    struct sys_system system;            /* owned */
    struct form_mechanical mechanical;   /* of that form, with the parameter replaced too; mass NULL: nothing was */
};

/* Whether a motion can stay on it, and functions say where it is. */
bool strata_solvable(const struct stratum *s);
/* Whether it is another part of the constraint set, given by a point: the same system is solved near it. */
bool strata_is_part(const struct stratum *s);

/* The functions of s->where are added to the restriction; where s is a case of
 * parameters, those of s->part are put in. False: UNDECIDED, where there are none. mechanical: of that form, whose rows and variables
 * will be changed; otherwise NULL. */
bool strata_case_make(struct strata_case *part, const struct sys_system *system, const struct form_mechanical *mechanical,
                      struct stratum *s, struct sga_error *err);
void strata_case_clear(struct strata_case *part);

/* Numerical rank of [A; d xi] at a point, for the first `rows` rows and c functions of the
 * space: singular values above 1e-10 of the largest, rows scaled to largest entry 1. The point
 * is known to 64 bits, so what is 0 there comes out far below. Cost: that of a dense SVD. */
int strata_rank_at(struct job *j, const struct points_space *space, int rows, int c, struct points_point *p);

#endif
