/* Inside the run folder: expressions as a person would write them.
 *
 * What is shown is found in a store of its own, whose symbols are those of the request's under the same
 * indices, so that the reduction's graph does not grow by it. A sheet is a set of functions: constraints first, then
 * components of fields. Each is shown in the lightest of a few forms: as it arose with like terms together, in normal
 * form, as its zeros (constraints), shortened by what vanishes on the set. A form is an identity, on the set at the most, and
 * is asked about at points of the set all the same. */
#ifndef SGA_RUN_DISPLAY_H
#define SGA_RUN_DISPLAY_H

#include "expr.h"

struct job;
struct sga_constraint;

struct sheet {
    expr_id *root; int roots;       /* the functions, in the display's store */
    int constraints;                /* the first of them, by generation */
    int on_set;                     /* up to here values count on the set of the constraints only; those after it hold by themselves */
    const struct sga_constraint *constraint;
    expr_id *shown;                 /* by root */
    expr_id *scale;                 /* by constraint: root = scale * shown on the set of older generations */
    bool *reduced;                  /* by constraint: there only */
    long weight;                    /* of all texts */
};

struct display {
    struct job *j;
    struct expr_store st;
    expr_id *value;                 /* by symbol: of a parameter that has one in the request, otherwise EXPR_UNDEF */
};

/* An empty store with the request's symbols. */
void display_open(struct display *d, struct job *j);
void display_close(struct display *d);
/* Functions of another store are copied; map[i] is what its symbol i becomes. False: one has no value. */
bool display_sheet(struct display *d, struct sheet *s, const struct expr_store *from, const expr_id *map, const expr_id *root, int roots,
                   const struct sga_constraint *constraint, int constraints);
void display_sheet_clear(struct sheet *s);
/* Fills shown, scale, reduced and weight. */
void display_choose(struct display *d, struct sheet *s);
/* The same functions with the parameters' values in place of their names; EXPR_UNDEF where one has no value. */
void display_values(struct display *d, expr_id *e, int count);

/* Whether the functions of `own` can be written with the names of parameters that have values: the system is
 * reduced once more with these left symbolic, and what comes out is taken only where it is, with the values put in,
 * the same function. Fills `by_name` (cleared by the caller in every case). */
bool display_by_name(struct display *d, const struct sheet *own, struct sheet *by_name);

#endif
