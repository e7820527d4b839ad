/* Inside the request folder only: where the reader is, and strict access to JSON. */
#ifndef SGA_REQUEST_READER_H
#define SGA_REQUEST_READER_H

#include <jansson.h>

#include "buf.h"
#include "error.h"
#include "parse.h"
#include "request.h"

struct written;

struct reader {
    struct written *written;         /* where ranges and loops were written out; NULL: there are none */
    struct request_bounds *bounds;   /* narrower limits of who asks; NULL: none */
    bool by_name;                 /* parameters with values stay symbolic */
    const struct request_open *open; int opens;   /* parameters that stay symbolic, as if a sweep gave them */
    const int *choice;            /* by mode: the place of the value that it has; NULL: where it starts */
    struct request *r;
    struct sga_arena mem;         /* what ends with the reading; what the request keeps is taken from its own */
    struct sga_error *err;
    const char **form;             /* or NULL: gets the form, which is known before the rest */
    struct request_faults *faults; /* all are asked for: reading goes on after them; NULL: it ends with the first */
    struct sga_buf at;             /* JSON Pointer of the value being read */
    struct expr_grammar grammar;   /* with the parameters' values */
    expr_id *value;                /* by symbol: value of a parameter, or EXPR_UNDEF */
    size_t value_cap;
    int *column;                   /* by symbol: state variable, or -1 (once the system stands) */
    int columns;
    const json_t *fitted;          /* fit.parameters, where some of them have no value; or NULL */
    json_t *swept;                 /* its members: names of parameters that the sweep gives; or NULL */
    char symbolic[REQUEST_MAX_NAME + 1];   /* a parameter that stays symbolic, or "" */
};

/* The pointer grows by a member or an index; `at_back` takes it back to a mark. On a
 * failure it stays where it is: reading ends there. */
size_t at_member(struct reader *rd, const char *key);
size_t at_index(struct reader *rd, size_t index);
void at_back(struct reader *rd, size_t mark);
/* Records an error at the current pointer; returns false. */
bool at_fail(struct reader *rd, enum sga_code code, const char *fmt, ...) __attribute__((format(printf, 3, 4)));
/* faults.c: after a fault, where all are asked for: lists it and goes back to a mark, so that reading can go on there. False: reading
 * ends, by the fault that stands. */
bool at_pass(struct reader *rd, size_t mark);
/* Lists the fault that stands. */
void faults_add(struct reader *rd);
/* "a string", "an object", ...: what a value is, for messages. */
const char *kind_of(const json_t *v);
bool expected(struct reader *rd, const char *what, const json_t *v);

/* v is an object with no other members than these (NULL-terminated). */
bool only_members(struct reader *rd, const json_t *v, const char *const *allowed);
/* A member that must be there: NULL, with MISSING_MEMBER at the object, if it is not. */
const json_t *need_member(struct reader *rd, const json_t *object, const char *key);

/* A value that is no array is a list of one element. */
size_t list_size(const json_t *v);
const json_t *list_item(const json_t *v, size_t i);
size_t at_item(struct reader *rd, const json_t *list, size_t i);

/* Values. The text of an expression (a string, or a number as its decimal) goes to
 * *text where text is not NULL; it is the request's. */
expr_id read_expression(struct reader *rd, const json_t *v, char **text);
/* The same among others that are read whether it can be or not: 1 in its place where all faults are asked for. */
expr_id read_listed(struct reader *rd, const json_t *v, char **text);
bool read_number(struct reader *rd, const json_t *v, double low, double high, double *out);
/* A constant: a number or an exact string, of constants and valued parameters. */
bool read_value(struct reader *rd, const json_t *v, double *out, char **text);
/* The same, and the constant itself. */
bool read_exact(struct reader *rd, const json_t *v, double *out, expr_id *exact, char **text);
bool read_integer(struct reader *rd, const json_t *v, long low, long high, long *out);
bool read_boolean(struct reader *rd, const json_t *v, bool *out);
const char *read_string(struct reader *rd, const json_t *v);
/* The place of a string in a table of n words; -1 with an error naming them. */
int read_word(struct reader *rd, const json_t *v, const char *const *word, int n, const char *what);
/* Moves the store's sticky error to the current pointer. */
bool store_ok(struct reader *rd);

/* names.c: a new symbol under a name that is allowed and not taken; its index or -1. */
/* A symbol is read as e from now on; EXPR_UNDEF: as itself. */
void set_value(struct reader *rd, int symbol, expr_id e);
int read_new_name(struct reader *rd, const json_t *v, enum expr_symbol_kind kind);
int new_name(struct reader *rd, const char *name, enum expr_symbol_kind kind);
bool is_identifier(const char *s);
/* The state variable of a name (x, x', der(x, 2)); index into system.variable or -1. */
int state_variable(struct reader *rd, const char *name);
/* For struct expr_grammar once the system stands: x' where it is a state variable. */
expr_id state_derivative(void *ctx, int symbol, int order);

/* value.c: the kinds of symbols in an expression, bit 1 << kind for each (enum expr_symbol_kind). */
unsigned symbol_kinds(const struct expr_store *st, expr_id e);
/* value.c: the double nearest to a constant expression; false where it has none. */
bool constant_value(const struct expr_store *st, expr_id e, double *out);

/* read_modes.c: the member `modes` of a system; the place of a value, or -1; the refusal of one that has none. */
bool read_modes(struct reader *rd, const json_t *system);
int read_mode_place(const struct request_mode *m, double value);
bool read_mode_refuse(struct reader *rd, const struct request_mode *m, double value);
/* read_tables.c: the member `tables` of a system: new names for functions of time. */
bool read_tables(struct reader *rd, const json_t *system);
/* After all else is read: the derivatives that the reduction may need, and whether what is wanted
 * can be had with tables. */
bool read_tables_end(struct reader *rd);

/* The parts of a request. */
bool read_system(struct reader *rd, const json_t *v);
bool read_want(struct reader *rd, const json_t *v);
bool read_trajectory(struct reader *rd, const json_t *v);
bool read_sensitivities(struct reader *rd, const json_t *v);   /* read_sensitivities.c: its member */
bool read_start_equations(struct reader *rd, const json_t *v); /* read_start.c: its member */
void start_equations_written(struct reader *rd, const json_t *v);   /* their places in v, which was written out */
/* read_bounds.c: {"x": [low, high]}, null for none, by variable; the request's. v NULL: none is bounded. */
bool read_bounds(struct reader *rd, const json_t *v, double **low, double **high);
/* Entry i of such a pair; null leaves *out. */
bool read_bound_end(struct reader *rd, const json_t *pair, size_t i, double *out);
bool read_symmetries(struct reader *rd, const json_t *v);
/* read_linearization.c; read_ports.c: its members `inputs` and `outputs`, of an object at the present place. */
bool read_linearization(struct reader *rd, const json_t *v);
bool read_transfer(struct reader *rd, const json_t *v);      /* read_transfer.c */
bool read_equilibria(struct reader *rd, const json_t *v);    /* read_equilibria.c; NULL: the member is not there */
/* read_fit.c: before the system, parameters of the fit that have no value become symbols with their guesses; what the member says. */
bool read_fit_names(struct reader *rd, const json_t *fit, const json_t *system);
bool read_fit(struct reader *rd, const json_t *v);
/* What initial values are where swept parameters are symbols. */
bool open_initial(struct reader *rd, struct request_initial *initial, int initials);
bool read_ports(struct reader *rd, const json_t *v, struct request_ports *ports);
/* read_sweep.c: before the system: which parameters are swept. After it: their values. With the trajectory: starts. */
bool read_sweep_names(struct reader *rd, const json_t *v);
bool read_sweep_parameters(struct reader *rd, const json_t *v);
bool read_sweep(struct reader *rd, const json_t *v);
/* The request, which has no sweep, with a set's values in system.parameters and trajectory.initial. A new reference. */
json_t *sweep_set_alone(const json_t *request, const json_t *set);
/* While initial values are read, swept parameters are numbers: those of set k, or (k < 0) of system.parameters, where
 * they have a value there, and otherwise of the first set. */
void sweep_bind(struct reader *rd, int k);
void sweep_unbind(struct reader *rd);
bool read_initial(struct reader *rd, const json_t *v, unsigned char *taken, struct request_initial **list, int *count);
bool read_events(struct reader *rd, const json_t *v);      /* its member `events` */
bool read_accuracy(struct reader *rd, const json_t *v);
bool read_families(struct reader *rd, const json_t *v);
bool read_limits(struct reader *rd, const json_t *v);

/* A form: how its members become rows. The variables' names stand in the store. */
struct form_kind {
    const char *name;
    bool (*read)(struct reader *rd, const json_t *system);   /* NULL: not available yet */
    const char *const *members;                              /* beside the common ones */
};
bool read_quasilinear(struct reader *rd, const json_t *system);
bool read_equations(struct reader *rd, const json_t *system);
/* The member `variables` as new symbols, the request's. NULL on failure. */
int *read_variables(struct reader *rd, const json_t *system, const char *member, int *count);

bool read_linear(struct reader *rd, const json_t *system);
bool read_descriptor(struct reader *rd, const json_t *system);
/* read_linear.c: the member `inputs`: functions of time, or new names, which become variables. The request's. */
struct read_signals {
    expr_id *u; int inputs;
    int *input; int free;      /* symbols of those that are variables */
};
bool read_signals(struct reader *rd, const json_t *system, struct read_signals *out);
/* names.c: a new name that stands for an expression wherever it is read from now on. */
bool read_alias(struct reader *rd, const json_t *v, expr_id e);
bool read_control(struct reader *rd, const json_t *system);
bool read_hamiltonian(struct reader *rd, const json_t *system);
bool read_lagrangian(struct reader *rd, const json_t *system);
bool read_operator(struct reader *rd, const json_t *system);
bool read_mechanical(struct reader *rd, const json_t *system);
/* Between the system and the trajectory: names for reactions, for outputs alone. */
void read_mechanical_outputs(struct reader *rd);

/* velocities.c. For struct expr_grammar: q' of a coordinate q, and nothing higher. */
expr_id read_velocity_of(void *ctx, int symbol, int order);
/* New variables q' for coordinates; lambda1, lambda2, ... (a name that is taken gets underscores).
 * NULL with the store's error; they are the request's. */
int *read_make_velocities(struct reader *rd, const int *coordinate, int n);
int *read_make_multipliers(struct reader *rd, int n);
/* Whether q, q' and the multipliers are as few variables as are allowed. */
bool read_motion_fits(struct reader *rd, int coordinates, int multipliers);

/* read_matrix.c: a member that is a matrix, dense or sparse, of a size that is known.
 * They end with the reading. */
struct read_matrix {
    const char *name;                     /* the member */
    int rows, cols;
    const char *per_row, *per_col;        /* what there is one row, one column for */
    const char *hint;                     /* said after a wrong number of rows, or NULL */
    bool constant;                        /* no entry may depend on variables or time */
    struct form_entry *entry;
    size_t entries, cap;
};
bool read_matrix(struct reader *rd, const json_t *system, struct read_matrix *m);
/* The same for a value at the present place, which m->name only names in messages. */
bool read_matrix_value(struct reader *rd, const json_t *v, struct read_matrix *m);
/* How many rows the member has as it is written. One flat list of `cols` entries is one row. */
bool read_matrix_rows(struct reader *rd, const json_t *system, const char *member, int cols, int *rows);
/* Entries that the request keeps. */
struct form_entry *read_matrix_kept(struct sga_arena *mem, const struct form_entry *entry, size_t entries);
/* A list of expressions under a member, the request's. count -1: the
 * member is absent. */
bool read_expression_list(struct reader *rd, const json_t *system, const char *member, expr_id **list, int *count);

/* written.c: ranges and loops written out, before anything else is read.
 *
 * `x[1:3]` in a list, or as a member's name, becomes x[1], x[2], x[3]; {"for": "i = 1:3", "equation": "x[i] = i"} in a list becomes
 * x[1] = 1, x[2] = 2, x[3] = 3; the system's `sizes` are put in for their names and leave it. What comes after sees plain names.
 * Gives v itself, with a reference more, where there is nothing to do; NULL with the first fault, at its place. All is counted before
 * anything is made: at most REQUEST_MAX_WRITTEN elements, and REQUEST_MAX_WRITTEN_BYTES of texts. Linear in what is made. */
json_t *write_out(struct reader *rd, json_t *v);
/* A fault of what was written out is told by the place in v where it came from, with the values of the loop and what was read. */
void written_place(const struct written *w, const json_t *v, struct sga_error *err);
void written_end(struct written *w);

/* canonical.c: compact text, members in their order. */
void write_json(struct sga_buf *out, const json_t *v);

/* json.c: text to JSON, or err with line and column. The caller releases it. */
json_t *load_json(const char *text, size_t length, struct sga_error *err);
/* Messages are cut at a number of bytes: what is then no UTF-8 becomes '?'. */
void make_utf8(char *text);

#endif
