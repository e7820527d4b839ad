/* Inside the traj folder: derivatives of expressions along the directions of a variation. */
#ifndef SGA_TRAJ_VARIATION_ALONG_H
#define SGA_TRAJ_VARIATION_ALONG_H

#include "derive.h"

struct sys_system;
struct variation_by;

struct variation_along {
    struct expr_store *st;
    const struct sys_system *sys;       /* whose variables x are */
    const struct variation_by *by;
    int directions;
    const expr_id *slope;               /* directions x n: the symbols of S */
    int *variable_of;                   /* by symbol: variable, or -1 */
    unsigned char *active;              /* by symbol */
    struct expr_cone cone;
    struct expr_term *term; size_t cap;
};

/* Symbols that stand for S (directions x variables; malloced), of the same names each time. The store may run out: then some are EXPR_UNDEF. */
expr_id *along_symbols(const struct sys_system *sys, const struct variation_by *by, int directions);
/* All pointers are borrowed. along_end is due. */
void along_begin(struct variation_along *a, const struct sys_system *sys, const struct variation_by *by, int directions, const expr_id *slope);
void along_end(struct variation_along *a);
/* to[d] = e_x S_d + e_k. */
void along_of(struct variation_along *a, expr_id e, expr_id *to);

/* variation_found.c: v->relation, and those of its request. False with err: as start_search_init. */
struct variation;
struct traj_request;
struct sga_solution;
struct sga_error;
bool variation_relations(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct variation_along *a, struct sga_error *err);

#endif
