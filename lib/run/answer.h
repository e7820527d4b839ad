/* Inside the run folder: one job from request to result. */
#ifndef SGA_RUN_ANSWER_H
#define SGA_RUN_ANSWER_H

#include "buf.h"
#include "cases.h"
#include "stage_clock.h"
#include "mech.h"
#include "operator.h"
#include "print.h"
#include "request.h"
#include "run.h"
#include "reduction.h"
#include "structure.h"
#include "sym.h"
#include "trajectory.h"
#include "warnings.h"
#include "witness.h"

/* Of the form `operator`. */
struct operator_answer {
    struct op_system system;
    int rank;
    bool solvable;                /* full rank: y exists for every e */
    bool asks_sources;            /* not of full rank, and the equations ask something of e */
    struct op_state state;        /* solvable only, like the next two */
    struct op_laurent laurent;
    struct op_singular_times singular, poles;   /* of the leading transfer coefficient; of the coefficients */
    struct op_jacobson jacobson;
    bool has_jacobson;
    struct sga_error no_jacobson; /* why not */
};

enum stratum_state { STRATUM_LISTED, STRATUM_SOLVED, STRATUM_EMPTY, STRATUM_MERGED, STRATUM_SAME, STRATUM_UNSOLVED, STRATUM_SKIPPED };

/* A set that the answer does not speak of: where a pivot or a factor of a product vanishes. */
struct stratum {
    const char *kind;             /* "pivot", "branch", "side", "instant", "domain", "parameter", "excess"; static */
    expr_id *where; char **text;  /* functions that vanish there, and how they are written */
    int wheres;                   /* 0: described only */
    char *description;            /* or NULL */
    bool approximate;             /* its point was approached, not proved to lie there */
    bool off;                     /* it does not meet the final set, but solutions may lie there */
    double *point; double time;   /* by variable: a point of it that was found, or NULL */
    enum stratum_state state;
    struct sga_buf result;        /* JSON: its answer */
    struct sga_error error;       /* where it could not be solved */
    struct sga_buf note;          /* EMPTY: why; SAME: JSON list of the functions that vanish at the equal set */
    struct sga_buf also;          /* JSON: the functions of strata that reach the same set */
    struct cases_part part;       /* kind "parameter": what is put in for which parameters */
    struct sga_buf sample;        /* JSON: values of the parameters on it, or empty */
};

/* Of the form `mechanical`. */
struct mechanical_answer {
    struct mech_fibre fibre;
    bool determined;              /* one acceleration at general points of W */
    struct mech_motion motion;
    bool has_motion;
    int first_root;               /* among the texts: total, tangent, orthogonal, reaction */
    struct mech_regularity regularity;
    bool has_regularity;
};

/* What of the request's system is not modelled, because the outputs do not depend on it (slice.h). */
struct slice_given { int symbol; double value; };
struct model_slice {
    bool made, tied;
    int variables, rows;          /* of the whole system, restrictions among the rows */
    int gone, apart, rows_gone;
    int *symbol;                  /* of the variables that are gone */
    struct slice_given *given; int givens;   /* initial values for them */
};

struct job {
    struct request request;
    struct model_slice slice;
    struct sga_budget budget;
    struct sga_warnings warnings; /* the budget points to it: of this answer, not of its strata */
    const struct sga_run_options *options;
    struct points_shadow shadow;
    struct sga_solution solution;
    bool solved;
    struct {                      /* where the request starts: a hint for which component is meant */
        double *x;                /* by variable, or NULL */
        unsigned char *given;     /* by variable: its value is the request's, and not what follows from others; NULL: all are */
        double time;
        double *parameter;        /* by parameter: values of tables there, else NAN; NULL without x or tables */
    } start;
    struct {
        struct expr_names names;  /* roots: constraints, field, gauge fields, in this order */
        bool has;
        int first_field, first_gauge;   /* places among the roots */
        expr_id *scale;           /* by constraint: what it was divided by for its text, or EXPR_UNDEF */
        bool *reduced;            /* by constraint: that holds where those of older generations vanish; NULL: nowhere needed */
    } texts;
    const char *request_text;     /* or NULL */
    size_t request_length;
    struct { struct sga_witness result; bool has; } witness;
    struct {
        struct traj_result result;
        bool has;
        struct sga_buf sweep;     /* JSON: those of a sweep, or empty */
    } trajectory;
    struct tradeoff *tradeoff;    /* or NULL */
    struct {
        struct traj_initial result;
        bool has;
        int residuals;            /* constraints of the solution that it belongs to */
    } initial;
    struct {                      /* whose drift is reported */
        expr_id *expr;
        int *given;               /* index into the request's, or -1: the energy */
        enum points_truth *truth; /* POINTS_ZERO: constant along the motion */
        int count;
    } integrals;
    struct {
        struct structure found;
        bool has;
        struct sga_buf kronecker; /* JSON value of the member, where structure is wanted */
        bool is_linear;           /* and it is a structure, not a reason */
    } structure;
    struct {
        struct sym_work *work;
        struct sym_check *check;  /* by candidate of the request */
        struct sym_result found;
        bool has, time;
    } symmetries;
    struct {
        struct stratum *at;
        int count;
        double work;              /* what searches for them have cost: Newton steps times the nodes that each evaluates */
        bool skipped;             /* zeros of some functions were not, or not fully, looked for */
        const char **determinant; /* by dense block: what became of the search for its zeros; static texts; or NULL */
        struct strata_tree *tree; /* of all strata being solved; NULL at the request's own answer until then */
        int moves_on;             /* 1 + the stratum that the trajectory lies on; 0: none */
    } strata;
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
    struct operator_answer *op;   /* or NULL */
    struct sga_buf signs;         /* JSON: an assumption on signs of parameters, or empty */
    struct {                      /* pull-back of the form hamiltonian with restrictions */
        bool has;
        struct form_tangent tangent;
    } primary;
    unsigned char *restriction_kept;   /* by restriction: a constraint came from it; NULL: not known */
    struct {                      /* a 2-form that was given */
        bool checked;
        int closed;               /* 1 yes, 0 no, -1 not known */
        int variable[3];          /* not closed: this component of d omega */
        expr_id defect;
    } two_form;
    int *redundant; int redundants;   /* of the form lagrangian: holonomic constraints that follow from others */
    struct mechanical_answer *mechanical;   /* or NULL */
    struct stage_clock clock;
    double spent;                 /* seconds of the time granted, before */
    const char *stage;            /* the last that was begun */
    struct sga_error *err;
};

/* The analysis over Q(t)[D], before the reduction. */
bool answer_operator(struct job *j);
void answer_operator_clear(struct job *j);
int answer_operator_index(const struct job *j);      /* -1: not solvable */
void answer_write_operator(const struct job *j, struct sga_json *w);

/* Runs the reduction, `solve`, after the equations of the form hamiltonian have been pulled back to the zero
 * set of its restrictions; on other branches too where the first one ends in a contradiction. */
bool answer_primary(struct job *j, bool (*solve)(struct job *));
void answer_primary_clear(struct job *j);
/* Takes and returns whether the reduction succeeded; refuses holonomic constraints that are irregular. */
bool answer_holonomic(struct job *j, bool ok);
/* After a reduction that left freedom: holonomic constraints whose differentials depend on those before them on the common
 * zeros ask nothing more; rows are added that set their multipliers to 0 (j->redundant). True: the system has to be reduced again. */
bool answer_holonomic_redundant(struct job *j);
/* Which restrictions a solution's constraints came from. */
void answer_restrictions_kept(struct job *j, const struct sga_solution *sol);
/* Is a given 2-form closed? */
bool answer_two_form(struct job *j);
void answer_write_restrictions(struct job *j, struct sga_json *w);
/* The geometry of the constraints, before the reduction; the system gets multipliers for independent
 * conditions only. Then, after it, acceleration and regularity as far as they are wanted. */
bool answer_mechanical(struct job *j);
bool answer_mechanical_motion(struct job *j);
void answer_mechanical_clear(struct job *j);
void answer_write_mechanical(struct job *j, struct sga_json *w);
/* traj_run of the answer's system; in the form operator it ends at singular times. */
bool answer_integrate(const struct job *j, const struct sga_solution *solution, const struct traj_request *request,
                      struct traj_result *result, struct sga_error *err);
/* Consistent start and trajectory, as far as they are wanted. */
bool answer_motion(struct job *j);
/* After answer_motion failed with NO_MOTION: the motion of the stratum that the start lies on,
 * where strata are solved; otherwise the refusal names the strata. */
bool answer_motion_on_stratum(struct job *j);
/* Texts of what is wanted: normal forms where they are cheap, named parts otherwise. */
bool answer_texts(struct job *j);
/* One printed text without names of parts as an expression of the request's store, parameters that have values put in;
 * EXPR_UNDEF: it does not read back. */
expr_id answer_text_read(struct job *j, const char *text);
/* The check at fresh points, of the printed texts where there are any, read back by the
 * parser; otherwise of the handles. */
bool answer_witness(struct job *j);
/* Factors of pivots that can vanish on the final set, and branches not followed; where the
 * strata shall be solved, also pivots' zeros off the final set. */
void answer_strata(struct job *j);
/* Signs of symbolic parameters without which no point of the final set was found. */
void answer_signs(struct job *j);
/* Solves each of them as a system of its own, and theirs in turn, within limits of depth and
 * number that are said where they are reached. False: the job was cancelled. */
bool answer_strata_solve(struct job *j);
void answer_strata_clear(struct job *j);
/* The first integrals whose drift the trajectory shall report, of a solution and its shadow. */
void answer_integrals(struct job *j, const struct sga_solution *s, struct points_shadow *shadow, struct traj_request *r);
void answer_integrals_clear(struct job *j);
void answer_write_drift(const struct job *j, struct sga_json *w);
/* Nodes that gauge fields may add where only a motion needs them; 0: no limit (balls have no other way). */
int answer_gauge_nodes(const struct job *j);
/* The reduction. */
bool answer_reduce(struct job *j);
/* Everything but the request. */
void answer_clear(struct job *j);
void answer_write_strata(const struct job *j, struct sga_json *w);
void answer_write_empty_strata(const struct job *j, struct sga_json *w);
/* The name of a variable of the system. */
const char *answer_variable_name(const struct job *j, int variable);
void answer_write_evidence(struct job *j, struct sga_json *w);
/* The result object. False: over answer_limit, memory or time. */
bool answer_write(struct job *j, struct sga_buf *out);
/* Bytes that the result may have. */
size_t answer_limit(const struct job *j);
/* False once out is over that, and the error is set. */
bool answer_fits(struct job *j, const struct sga_buf *out);
/* What the answer says beside itself of names that nothing uses, before the system is cut; and of the number of
 * equations and the start, once all is known. */
void answer_warn_unused(struct job *j);
void answer_warn(struct job *j);
/* Whether some value that trajectory.initial gives is not the one of the start x. */
bool answer_start_moved(const struct job *j, const double *x);
bool answer_write_trajectory(struct job *j, struct sga_json *w);
/* The tables of the system, where it has any, and what the answer uses of them. */
void answer_write_tables(const struct job *j, struct sga_json *w);
/* Members of the object `structure`, which is open; needs the structure. */
void answer_write_structure(struct job *j, struct sga_json *w);
/* Symmetries, as far as they are wanted. The shadow is not used after the clearing. */
bool answer_symmetries(struct job *j);
void answer_symmetries_clear(struct job *j);
void answer_write_symmetries(struct job *j, struct sga_json *w);
void answer_write_initial(const struct job *j, struct sga_json *w);

#endif
