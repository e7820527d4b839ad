/* One job from request to result: what its stages keep, and what they run as.
 *
 * Each stage owns one struct, which its own header declares; the job has pointers to them, NULL until the stage has run. */
#ifndef SGA_RUN_RUN_JOB_H
#define SGA_RUN_RUN_JOB_H

#include <stdbool.h>
#include <stddef.h>

#include "arena.h"
#include "expr.h"

struct cases_part;
struct form_tangent;
struct job_ask;
struct job_integrals;
struct job_symmetries;
struct job_texts;
struct mechanical_answer;
struct model_slice;
struct operator_answer;
struct points_oracle;
struct request;
struct request_initial;
struct sga_buf;
struct sga_budget;
struct sga_error;
struct sga_solution;
struct sga_team;
struct sga_json;
struct sga_warnings;
struct sga_witness;
struct slides;
struct strata_tree;
struct stratum;
struct structure;
struct tradeoff;
struct traj_initial;
struct traj_request;
struct traj_result;
struct job;

/* Where a long result goes while it is written. */
struct answer_flow {
    const struct sga_buf *out;             /* the buffer of the result, and no other */
    void (*give)(void *ctx, const char *text, size_t length);
    void *ctx;
    size_t given;                          /* bytes, before those that the buffer holds */
};

/* What a job goes through. The list of them (run.c) is in the order in which they run, and ends with one without a name. */
struct job_stage {
    const char *name;                      /* of progress and of errors; static */
    double at;                             /* of the whole, where it begins; negative: it is not shown */
    bool follows;                          /* runs once all that is said is known not to rest on what was left out (slice.h) */
    bool (*wanted)(const struct job *j);   /* NULL: always */
    bool (*run)(struct job *j);            /* false: the job ends with j->err */
    void (*clear)(struct job *j);          /* what it has in the job, whether it ran or not; NULL: nothing of its own */
};

struct job {
    struct request *request;
    const char *request_text;     /* or NULL */
    size_t request_length;
    struct {                      /* what whoever runs the job gave (run.h) */
        size_t most_result;       /* bytes; 0: 1 GB */
        void (*progress)(void *ctx, const char *stage, double fraction, double t);   /* or NULL; t: job_progress_at */
        void *ctx;
        struct sga_team *team;    /* or NULL */
        struct answer_flow *flow; /* or NULL */
    } host;
    const struct job_stage *stages;
    struct sga_budget *budget;    /* in mem, or the owner's */
    struct sga_warnings *warnings;   /* the budget points to it: of this answer, not of its strata; or NULL */
    struct sga_arena mem;         /* what stages keep, until the job is cleared */
    struct stage_clock *clock;    /* in mem: of this answer, not of its strata */
    double spent;                 /* seconds of the time granted, before */
    const char *stage;            /* the last that was begun */
    struct sga_error *err;
    struct model_slice *slice;
    struct job *part;             /* the motion's own job, of what is left of the system where outputs ask for less (part.h); or NULL */
    struct {                      /* where the request starts: a hint for which component is meant */
        double *x;                /* by variable, or NULL */
        unsigned char *given;     /* by variable: its value is the request's, and not what follows from others; NULL: all are */
        double time;
        double *parameter;        /* by parameter: values of tables there, else NAN; NULL without x or tables */
    } start;
    struct {                      /* of a job that answers a stratum of another one; all 0: the request's own answer */
        int depth;                /* a stratum of a stratum ... */
        int inside;               /* the same without cases of parameters, of which there are no more inside each other than parameters */
        int parameter_case;       /* which substitution of parameters is being solved; 0: none */
        const struct job *above;  /* of the answer that this is a stratum of, or NULL; it has the same parameters, or: */
        bool is_case;             /* some were put in for this one */
        const struct cases_part *part;   /* ... with these, borrowed */
        expr_id *not_zero; int not_zeros;   /* what must not vanish of the parameters */
        bool on_part;             /* a part of a union is solved, given by a point: other parts are not looked for */
    } place;
    struct operator_answer *op;
    struct mechanical_answer *mechanical;
    struct form_tangent *primary; /* pull-back of the form hamiltonian with restrictions */
    int *redundant; int redundants;   /* of the form lagrangian: holonomic constraints that follow from others */
    unsigned char *restriction_kept;   /* by restriction: a constraint came from it; NULL: not known */
    struct {                      /* a 2-form that was given */
        bool checked;
        int closed;               /* 1 yes, 0 no, -1 not known */
        int variable[3];          /* not closed: this component of d omega */
        expr_id defect;
    } two_form;
    struct points_oracle *oracle; struct sga_solution *solution;   /* of the reduction, both or none */
    struct job_texts *texts;
    struct {
        struct stratum *at;
        int count;
        double work;              /* what searches for them have cost: Newton steps times the nodes that each evaluates */
        double least_cost;        /* of one such step on the set of the first spent_on - 1 constraints, for which no step was granted any more */
        int spent_on;             /* 0: there was none such */
        long compared;            /* nodes of constraints that factors were compared with: */
        struct strata_constraints *constraints;     /* these, by what they contain; NULL until then */
        bool skipped;             /* zeros of some functions were not, or not fully, looked for */
        const char **determinant; /* by dense block: what became of the search for its zeros; static texts; or NULL */
        struct strata_tree *tree; /* of all strata being solved; NULL at the request's own answer until then */
        int moves_on;             /* 1 + the stratum that the trajectory lies on; 0: none */
    } strata;
    char *signs;                  /* JSON: an assumption on signs of parameters, or NULL */
    struct sga_witness *witness;
    struct structure *structure;
    char *kronecker;              /* JSON value of the member, where structure is wanted; or NULL */
    bool kronecker_is_linear;     /* and it is a structure, not a reason */
    struct job_symmetries *symmetries;
    struct job_integrals *integrals;
    struct traj_initial *initial;
    int initial_residuals;        /* constraints of the solution that it belongs to */
    struct traj_result *trajectory;
    struct {                      /* of a system with modes, in the order in which the motion reaches them; the first is the answer's own */
        char **values, **entry;   /* JSON: {mode: value}; what the answer says of it (not of the first: NULL) */
        int count;
    } modes;
    struct {                      /* by slide of the trajectory, where slides were asked for */
        char **surface;           /* its function's text */
        int *dimension, *generations;   /* of the reduction of the system that slides */
        /* slides_begin and slides_end (slides.h), for who makes such a motion of another job: its derivatives. NULL: no motion goes by its switches */
        bool (*begin)(struct job *j, const struct sga_solution *solution, struct traj_request *rq, struct sga_arena *mem, struct slides **out);
        void (*end)(struct slides *s, bool ok);
        bool in_balls;            /* each switch is told from its sides, ones that do not jump too: in balls no motion passes one otherwise */
    } slides;
    char *sweep;                  /* JSON: those of a sweep, or NULL */
    bool one_of_many;             /* its time is what others have left: it is not extended (job_ends) */
    char *sets;                   /* JSON: what else is asked at each set of a sweep, or NULL */
    char *sensitivities;          /* JSON: the member of the trajectory, or NULL */
    char *fit;                    /* JSON: the member, or NULL */
    struct tradeoff *tradeoff;
    struct job_ask *ask;          /* linearization and what else is asked of the reduced system */
};

/* Runs the stages that follow what is said, or the others. False: j->err. */
bool job_run(struct job *j, bool follows);
/* Everything but the request. */
void job_clear(struct job *j);
/* The stage that errors name, and progress where fraction is 0 or more. */
void job_progress(struct job *j, const char *stage, double fraction);
void job_progress_at(struct job *j, const char *stage, double fraction, double t);    /* t: where a motion is; NAN: none is made */

/* True while time, memory and nobody's end let it work on; otherwise j->err says what does not. The other says nothing. */
bool job_goes_on(const struct job *j);
bool job_has_left(const struct job *j);
/* A part of the answer that may be left out for want of time, beside a motion that is there: its deadline is sooner, so that the rest can be written. Gives
 * the job's own, which job_leaves_out puts back. That is for a part that failed, or was not begun: true where it was for want of time (a warning at
 * pointer names it by `what`, and the error is forgotten). */
double job_shorten(struct job *j);
bool job_leaves_out(struct job *j, double deadline, const char *pointer, const char *what);

/* A motion that is there, and met the end of its time: it is written, also where the machine was so slow that what was kept for that has passed. */
void job_ends(struct job *j);

/* Whether this process only helps another one with the sets of a sweep (team.h): it writes no answer. */
bool job_helps(const struct job *j);

/* Bytes that the result may have. */
size_t answer_limit(const struct job *j);
/* False once out is over that, and the error is set. */
bool answer_fits(struct job *j, const struct sga_buf *out);
/* The same between two rows of the result, where what is written may go; no place in out is one after it. */
bool answer_goes(struct job *j, struct sga_buf *out);
/* A value that was written before. */
void answer_raw(struct job *j, struct sga_json *w, const char *text);
/* The name of a variable of the system. */
const char *answer_variable_name(const struct job *j, int variable);
/* Free functions are called f1, f2, ...; a name of the request is never used again. */
void answer_free_name(const struct job *j, int k, char *out, size_t size);
/* Whether a value that was given is not the one of the start x; whether some that trajectory.initial gives is not. */
bool answer_value_moved(const struct job *j, const struct request_initial *given, const double *x);
bool answer_start_moved(const struct job *j, const double *x);
/* Nodes that gauge fields may add where only a motion needs them; 0: no limit (balls have no other way). */
int answer_gauge_nodes(const struct job *j);

#endif
