/* Inside enclosed*.c: one try with so many bits. */
#ifndef SGA_TRAJ_ENCLOSED_ATTEMPT_H
#define SGA_TRAJ_ENCLOSED_ATTEMPT_H

#include "enc_tables.h"
#include "enclosed.h"
#include "knots.h"

struct num_ball;

struct attempt {
    struct flow *f;
    const struct sys_system *sys;
    const struct sga_solution *sol;
    const struct traj_request *rq;
    struct enclose_problem problem;
    struct knots knots;
    struct enc_tables tables;
    int *before;                         /* by sample: knots before it */
    slong prec;
    arb_ptr start, time, box, column;    /* n; samples; samples x n; samples x columns */
    arb_ptr knot;                        /* knots.count */
    arb_t t0;
    int n, columns;
    struct enclose_end end;
    struct enclose_happened happened;
    arb_ptr happened_column;             /* happened.count x columns, of the last try; happened_room of them */
    slong happened_room;
    double excess;                       /* log2 of the largest radius / tolerance; -INFINITY where all are exact */
    bool last;                           /* the time ended before more bits could be tried */
};

/* Values of roots where the solution is in box (n) at t, into out. */
void attempt_evaluate(const struct attempt *a, struct num_ball *b, struct expr_cone *cone, const expr_id *root, int roots, const arb_t t, arb_srcptr box, arb_ptr out);
/* How far it came in its time. */
void attempt_say_time(const struct attempt *a, char *text, size_t room);
/* enclosed_keep.c: rows, events, the end, and what it cost, into the result. */
void attempt_keep(const struct attempt *a, struct traj_result *r);

#endif
