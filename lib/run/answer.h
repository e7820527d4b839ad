/* Inside the run folder: one job from request to result. */
#ifndef SGA_RUN_ANSWER_H
#define SGA_RUN_ANSWER_H

#include "buf.h"
#include "operator.h"
#include "print.h"
#include "request.h"
#include "run.h"
#include "sga.h"
#include "structure.h"
#include "trajectory.h"
#include "witness.h"

/* Of the form `operator`. */
struct operator_answer {
    struct op_system system;
    int rank;
    bool solvable;                /* full rank: y exists for every e */
    bool asks_sources;            /* not of full rank, and the equations ask something of e */
    struct op_state state;        /* solvable only, like the next two */
    struct op_laurent laurent;
    struct op_singular_times singular;
    struct op_jacobson jacobson;
    bool has_jacobson;
    struct sga_error no_jacobson; /* why not */
};

struct job {
    struct request request;
    struct sga_budget budget;
    const struct sga_run_options *options;
    struct points_shadow shadow;
    struct sga_solution solution;
    bool solved;
    double *near;                 /* by variable: where the request starts, or NULL */
    double near_time;
    struct expr_names texts;      /* roots: constraints, field, gauge fields, in this order */
    bool has_texts;
    int first_field, first_gauge; /* places among the roots */
    struct sga_witness witness;
    bool witnessed;
    struct traj_result trajectory;
    bool has_trajectory;
    struct traj_initial initial;
    bool has_initial;
    struct structure structure;
    bool has_structure;
    struct stratum { expr_id factor; const char *kind; char *text; } *stratum;
    int strata;
    struct sga_buf kronecker;     /* JSON value of the member, where structure is wanted */
    bool is_linear;               /* and it is a structure, not a reason */
    struct operator_answer *op;   /* or NULL */
    struct { double read, reduce, operator_form, print, witness, trajectory, structure; } seconds;
    const char *stage;            /* the last that was begun */
    struct sga_error *err;
};

/* The analysis over Q(t)[D], before the reduction. */
bool answer_operator(struct job *j);
void answer_operator_clear(struct job *j);
int answer_operator_index(const struct job *j);      /* -1: not solvable */
void answer_write_operator(const struct job *j, struct sga_json *w);
/* Consistent start and trajectory, as far as they are wanted. */
bool answer_motion(struct job *j);
/* Texts of what is wanted: normal forms where they are cheap, named parts otherwise. */
bool answer_texts(struct job *j);
/* The check at fresh points, of the printed texts where there are any, read back by the
 * parser; otherwise of the handles. */
bool answer_witness(struct job *j);
/* Factors of pivots that can vanish on the final set, and branches not followed. */
void answer_strata(struct job *j);
/* The result object. False: over answer_limit, memory or time. */
bool answer_write(struct job *j, struct sga_buf *out);
/* Bytes that the result may have. */
size_t answer_limit(const struct job *j);
/* False once out is over that, and the error is set. */
bool answer_fits(struct job *j, const struct sga_buf *out);
bool answer_write_trajectory(struct job *j, struct sga_json *w);
/* Members of the object `structure`, which is open; needs the structure. */
void answer_write_structure(struct job *j, struct sga_json *w);
void answer_write_initial(const struct job *j, struct sga_json *w);

#endif
