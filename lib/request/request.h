/* A request, read from JSON and checked: what run works on.
 *
 * This folder is the only one that knows the JSON library. Reading is strict: every
 * member is known, of its type, within its limits; the first fault is reported with
 * its JSON Pointer, and inside an expression with line and column. A struct request
 * owns everything it points to, and keeps no JSON. */
#ifndef SGA_REQUEST_REQUEST_H
#define SGA_REQUEST_REQUEST_H

#include <stdbool.h>
#include <stddef.h>

#include "arena.h"
#include "system.h"

struct sga_buf;

/* What can be wanted: symbol, name. The bit of a symbol is 1u << its place. */
#define REQUEST_WANT_TABLE(X) \
    X(CONSTRAINTS, "constraints") X(INDEX, "index") X(VECTOR_FIELD, "vector_field") \
    X(GAUGE, "gauge") X(CONSISTENT_INITIAL, "consistent_initial") X(SYMMETRIES, "symmetries") \
    X(STRUCTURE, "structure") X(TRAJECTORY, "trajectory") X(TRADEOFF, "tradeoff") X(LINEARIZATION, "linearization") \
    X(TRANSFER, "transfer") X(EQUILIBRIA, "equilibria") X(DERIVATION, "derivation") X(FIT, "fit") X(DIRAC, "dirac")

enum {
#define X(sym, text) REQUEST_PLACE_##sym,
    REQUEST_WANT_TABLE(X)
#undef X
    REQUEST_WANTS
};
enum request_want {
#define X(sym, text) REQUEST_##sym = 1 << REQUEST_PLACE_##sym,
    REQUEST_WANT_TABLE(X)
#undef X
};
/* What is made for each set of a sweep. */
enum { REQUEST_OF_SETS = REQUEST_TRAJECTORY | REQUEST_LINEARIZATION | REQUEST_TRANSFER | REQUEST_EQUILIBRIA | REQUEST_FIT };
const char *request_want_text(int place);      /* 0 <= place < REQUEST_WANTS */

/* What repeats in lists of the answer is said once: in long ones, wherever it can be, never. */
enum request_families { REQUEST_FAMILIES_AUTO, REQUEST_FAMILIES_FOLD, REQUEST_FAMILIES_WHOLE };

enum request_arithmetic {
    REQUEST_AUTO, REQUEST_DOUBLE, REQUEST_DOUBLE_DOUBLE, REQUEST_BALL
};

struct request_initial {
    int variable;             /* index into system.variable */
    double value;             /* nearest double to the exact text */
    expr_id exact;            /* a constant of the store */
    char *text;               /* as given, in the grammar */
    expr_id open;             /* the same with swept and opened parameters as symbols; EXPR_UNDEF where there are none */
};

struct request_rate {
    int variable;             /* index into system.variable */
    expr_id rate;             /* its derivative: of variables and time */
    char *text;
};

struct request_set {
    int variable;             /* or -1 - a mode's place */
    expr_id value;            /* of variables and time */
};

/* A name whose value events set: a number to each reduction. */
struct request_mode {
    char *name; int symbol;
    double *value; expr_id *exact; int values;   /* no two are the same */
    int start, now;           /* places of its values: where it starts; that the request was read with */
    bool in_system;           /* its name stands in the system */
};

struct request_event {
    char *name;               /* no two are the same */
    expr_id expression;       /* of variables and time */
    char *text;
    int direction;            /* +1: up, -1: down, 0: any */
    bool stop;
    struct request_set *set; int sets;   /* action set: what is assigned; no variable twice */
    int most;                 /* it acts so many times; 0: always */
};

/* A function of time given by samples. */
struct request_table {
    char *name;
    struct expr_table *values;
    bool in_system;           /* it, or a derivative of it, stands in the system, not in what is asked of its motions alone */
};

/* Derivatives of the motion that are asked for beside it. */
struct request_sensitivities {
    bool has;
    const char **parameter; int parameters;   /* names of parameters with values, none twice */
    int *initial; int initials;               /* variables that trajectory.initial gives, none twice */
};

/* What holds at the start. */
struct request_relation {
    expr_id value;            /* left - right: of variables, time and symbols of rate_symbol */
    char *text;
    char *place;              /* JSON Pointer to where it was said */
};

struct request_trajectory {
    bool has;                 /* the request has this member */
    double start;             /* where `initial` holds */
    double *times;            /* samples of them, strictly increasing from start or later
                               * (or strictly decreasing from start or earlier); NULL where
                               * neither stop nor times was given and no trajectory is wanted */
    int samples;
    expr_id exact_start, exact_stop;   /* constants of the store */
    expr_id *exact_times;     /* samples of them; NULL where they are evenly spaced from start to stop */
    struct request_initial *initial; int initials;   /* in the order of the variables */
    int *hold; int holds;                            /* variable indices, in the order given */
    struct request_relation *relation; int relations;   /* start_equations */
    int *rate_symbol;                                /* by variable: the symbol that stands for its derivative in them, or -1; NULL: there are none */
    double *low, *high;                              /* bounds of the start, by variable; infinite: none; NULL: none at all */
    expr_id *output; char **output_text; int outputs;  /* 0: all variables */
    struct request_rate *rate; int rates;            /* in the order of the variables */
    expr_id *integral; char **integral_text; int integrals;   /* functions whose drift is reported */
    expr_id *condition; char **condition_text; int conditions;   /* functions that shall vanish */
    struct request_event *event; int events;
    bool sliding;                                    /* where the equations jump and lead back, the motion goes on along the surface */
    struct request_sensitivities sensitivities;
};

/* A parameter that has a value in the request: expressions were read with the value in its place. */
struct request_known {
    int symbol;
    expr_id value;            /* free of symbols */
};

/* A parameter that sets of the sweep give: symbolic to the analysis. */
struct request_swept {
    int symbol;
    expr_id value;            /* in system.parameters: where a set gives none; EXPR_UNDEF: it must */
};

/* A start, or parameters, of its own. */
struct request_sweep {
    expr_id *parameter;       /* by swept parameter, constants of the store; NULL: none is swept */
    double *parameter_value;
    struct request_initial *initial; int initials;   /* in the order of the variables; those of trajectory.initial
                                                      * that are not given here too */
};

/* Where atol is not given: this times rtol, but not below the least unless rtol is. */
#define REQUEST_ATOL_OF_RTOL 1e-2
#define REQUEST_LEAST_ATOL 1e-12
struct request_accuracy {
    double rtol, atol;        /* 1e-8, 1e-10 unless said */
    bool own_atol;            /* atol was said */
    enum request_arithmetic arithmetic;
    char *method;             /* NULL: chosen */
};

struct request_limits {
    double seconds;           /* 30 unless said */
    double megabytes;         /* that the job may add to its process; 0: what the service allows */
    int nodes;                /* of the expression store */
    int generations;
    int terms;                /* of one polynomial in normal forms; 0: not said */
    int bits;                 /* of one exact number */
};

/* Of the form `operator`: sum A_i y^(i) = B e. */
struct request_operator {
    bool has;
    int unknowns, sources, order;
    int *unknown;             /* symbols */
    expr_id *A;               /* order + 1 matrices of unknowns x unknowns, by rows: functions of time */
    expr_id *B;               /* unknowns x sources */
    expr_id *source;          /* functions of time; EXPR_UNDEF for a source that is only named */
    char **source_name;       /* as given */
    bool open_sources;        /* some source is only named */
};

/* Of the form `mechanical`: symbols that outputs may use; EXPR_UNDEF where the name was taken. */
struct request_forces {
    expr_id *reaction;        /* by coordinate: reaction_x */
    expr_id power;            /* reaction_power */
};

/* A field D^i d/dx_i + theta d/dt, or a map, to be checked. */
struct request_candidate {
    char *name;
    bool is_map;
    expr_id *component;       /* by variable, then time; what is not given is 0, or the identity */
};

/* What goes in and what comes out of a linearization. */
struct request_input {
    const char *name;
    int variable;             /* index into system.variable, or -1: */
    int signal;               /* the symbol of a table, or -1 */
};

struct request_ports {
    bool says_inputs;         /* they were given; otherwise they are the variables with the role "input" */
    struct request_input *input; int inputs;
    expr_id *output; char **output_text; int outputs;
};

/* Where to linearize, beside a start or samples. */
struct request_place {
    double time;
    struct request_initial *initial; int initials;   /* in the order of the variables */
};

enum request_at { REQUEST_AT_START, REQUEST_AT_SAMPLES, REQUEST_AT_PLACES };

struct request_linearization {
    bool has;
    bool symbolic;                         /* about any point, as expressions */
    bool least_norm;                       /* of freedom that no input names, else refused */
    enum request_at at;
    struct request_place *place; int places;
    struct request_ports ports;
};

struct request_transfer {
    struct request_ports ports;
    double *frequency; int frequencies;   /* >= 0, in radians per unit of time */
};

/* An output that is held at a value. */
struct request_held {
    int output;                                /* index into request.output */
    expr_id exact;
};

struct request_equilibria {
    struct request_initial *hold; int holds;   /* in the order of the variables */
    struct request_held *output; int outputs;  /* no output twice */
    int *free; int frees;                      /* variables: inputs that the search chooses */
    double *low, *high;                        /* by variable; infinite: no bound */
    int starts;
};

/* What a fit is to find: a parameter, or an initial value. */
struct request_unknown {
    const char *name;
    int variable;                              /* index into system.variable; -1: a parameter */
    double guess, low, high;                   /* infinite: no bound */
    bool has_guess;                            /* of an initial value: otherwise it is the experiment's */
};

/* One measured output. */
struct request_column {
    expr_id output; char *text;
    double *value, *weight;                    /* by time; value NAN: not measured */
};

struct request_experiment {
    double *time; int times;                   /* in any order, on one side of the start */
    struct request_column *column; int columns;
    struct request_initial *initial; int initials;   /* in the order of the variables, those of trajectory.initial among them */
};

struct request_fit {
    struct request_unknown *parameter; int parameters;
    struct request_unknown *initial; int initials;   /* of each experiment its own */
    struct request_experiment *experiment; int experiments;
    bool list;                                 /* they were given as a list */
    int starts;                                /* further guesses within the bounds */
};

struct request_symmetries {
    struct request_candidate *check; int checks;
    bool has_search;
    int degree, integral_degree;
    bool time;                /* the fields may depend on time and move it */
    bool says_time;           /* otherwise left to whether the system depends on time */
    expr_id *function; int functions;
};

struct request {
    struct sga_arena mem;             /* what it points to but the store, the system and the tables */
    struct expr_store store;
    struct sys_system system;         /* in store */
    struct request_table *table; int tables;
    char *name;                       /* of the system; NULL: none */
    const char *form;                 /* static text */
    char **equation; int equations;   /* of the form equations: the texts as they were given */
    struct form_hamiltonian *hamiltonian;   /* of that form, else NULL; with restrictions its rows are not made
                                       * yet: the pull-back needs regular functions first. Owned, with its arrays */
    unsigned want;                    /* bits of enum request_want */
    struct request_trajectory trajectory;
    struct request_mode *mode; int modes;
    struct request_sweep *sweep; int sweeps;   /* 0: one trajectory */
    struct request_swept *swept; int swept_count;
    struct request_known *known; int knowns; size_t known_cap;
    struct request_accuracy accuracy;
    struct request_limits limits;
    struct request_operator op;
    struct form_mechanical *mechanical;     /* of that form, else NULL */
    struct request_forces forces;     /* where there are outputs */
    struct request_symmetries symmetries;
    struct request_linearization linearization;
    struct request_transfer transfer;
    struct request_fit fit;                 /* where it is wanted */
    struct request_equilibria equilibria;   /* where they are wanted */
    expr_id *output; char **output_name; int outputs;   /* of the form descriptor */
    expr_id lagrangian;               /* L(q, v, t), where the form has one and no forces; or EXPR_UNDEF */
    int multiplier;                   /* of the form lagrangian: the symbol of the first holonomic constraint's multiplier, those of the others follow */
    int coordinates;                  /* of it: the system's variables are q, v, multipliers */
    enum request_families families;
    bool strata;                      /* each stratum shall be solved on its own */
};

/* Once in a process, before the first request: the JSON library's memory is watched too. */
void request_init(void);

/* Read a request. On failure err is filled and r is left cleared. Cost: linear in the text and
 * in what the form makes of it. */
bool request_read(struct request *r, const char *text, size_t length, struct sga_error *err);
/* The same within bounds narrower than the request's own limits. Where it failed by them,
 * `met` is set: then nothing is known against the request. */
struct request_bounds { double seconds; int nodes; bool met; };
/* What checking a request may take; one that needs more is judged where it runs. */
enum { REQUEST_CHECK_SECONDS = 1, REQUEST_CHECK_NODES = 2000000 };
/* The system alone, parameters that have a value left symbolic, unless it is a whole number of one digit: for texts that
 * call them by their names. False: it cannot be read so; no reason is given. */
bool request_read_named(struct request *r, const char *text, size_t length, int nodes);
/* The whole request, with some parameters as symbols: they are swept ones, of no set. `open` are their names, none twice; where the request gives
 * one no value, or another one is meant, it is `near`. */
struct request_open { const char *name; double near; bool replaces; };
bool request_read_open(struct request *r, const char *text, size_t length, const struct request_open *open, int opens, struct sga_error *err);
/* The whole request, with its modes at other values than at the start (by mode the place of the value), and parameters open as above. */
struct request_choice { const int *choice; const struct request_open *open; int opens; };
bool request_read_modes(struct request *r, const char *text, size_t length, const struct request_choice *mode, struct sga_error *err);
bool request_read_within(struct request *r, const char *text, size_t length, struct request_bounds *bounds, struct sga_error *err);
/* The system's own rules; starts and rates in the order of the variables, times one way. Linear; asserted where reading ends. */
bool request_sane(const struct request *r);
void request_clear(struct request *r);

/* What is wrong with a request, in the order of reading; at most SGA_MOST_FAULTS. What may only follow from a fault that is
 * listed is not: names that stand in a system that has one, values beside a value that cannot be read. */
struct request_faults {
    struct sga_error *list; int count; size_t cap;
    bool cut;                 /* there may be more */
};
/* As request_read_within, but goes on after faults of which the rest does not depend, and lists all. True: there are none, or
 * `bounds->met`, in which case r is cleared. Otherwise r is cleared but for its form. */
bool request_read_all(struct request *r, const char *text, size_t length, struct request_bounds *bounds, struct request_faults *faults);
void request_faults_clear(struct request_faults *faults);

/* The same JSON, compact, members sorted, numbers in their shortest form (1.0 and 1e0 are 1):
 * appended to out. Checks the JSON only, not what it means. */
bool request_canonical(const char *text, size_t length, struct sga_buf *out, struct sga_error *err);

/* The request with its ranges and loops written out, appended to out: the text itself where it has none, otherwise compact JSON with
 * members in their order. What is no request but for that is not looked at. */
bool request_plain(const char *text, size_t length, struct sga_buf *out, struct sga_error *err);
/* The sets of a request's sweep as texts of requests of their own, which have no sweep: a set's values stand in system.parameters and trajectory.initial. NULL with err; to be freed.
 * Cost: the text once; of each set's text what that is long. */
struct request_sets;
struct request_sets *request_sets_new(const char *text, size_t length, struct sga_error *err);
void request_sets_text(const struct request_sets *s, int k, struct sga_buf *out);
void request_sets_free(struct request_sets *s);

/* Limits that a request may not pass. */
enum {
    REQUEST_MAX_VARIABLES = 400000,
    REQUEST_MAX_UNKNOWNS = 64,        /* of the form operator */
    REQUEST_MAX_SAMPLES = 1000000,
    REQUEST_MAX_SWEEP = 10000,        /* starts */
    REQUEST_MAX_EVENTS = 64,          /* functions */
    REQUEST_MAX_SET_TIMES = 1000000,  /* repetitions of an event that sets variables */
    REQUEST_MAX_MODES = 64,           /* names of modes */
    REQUEST_MAX_MODE_VALUES = 1000,   /* of one of them */
    REQUEST_MAX_TABLES = 64,
    REQUEST_MAX_KNOTS = 100000,       /* of one table */
    REQUEST_MAX_INTEGRALS = 64,
    REQUEST_STARTS = 100,             /* of a search for equilibria, unless said */
    REQUEST_MAX_STARTS = 100000,
    REQUEST_MAX_FIT_STARTS = 10000,
    REQUEST_MAX_EXPERIMENTS = 1000,
    REQUEST_MAX_UNKNOWNS_FIT = 64,    /* parameters, and initial values, of a fit */
    REQUEST_MAX_PORTS = 1000,         /* inputs, outputs of a linearization */
    REQUEST_MAX_FREQUENCIES = 100000,
    REQUEST_MAX_PLACES = 1000,        /* where to linearize */
    REQUEST_MAX_BITS = 1 << 17,       /* of one exact number */
    REQUEST_MAX_NAME = 128,           /* bytes of a name */
    REQUEST_MAX_EXPRESSION = 1 << 26, /* bytes of one expression, with its sums written out */
    REQUEST_MAX_WRITTEN = 4000000,    /* elements that ranges and loops make, in all */
    REQUEST_MAX_WRITTEN_BYTES = 1 << 28,   /* of their texts (INDEX_WRITTEN of one) */
    REQUEST_MAX_DEPTH = 64            /* of nested JSON */
};

/* Sample time k (0 <= k < samples) as a constant of the request's store. */
expr_id request_exact_time(struct request *r, int k);

#endif
