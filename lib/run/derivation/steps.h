/* The steps of a derivation: each names those that it uses, so that a reader can check it from them alone. */
#ifndef SGA_RUN_STEPS_H
#define SGA_RUN_STEPS_H

#include "sheet.h"

struct sga_json;

/* Kinds: symbol, name.
 *   given         an equation of the request, or the definition of a variable that the form adds
 *   differentiate a constraint along the motion
 *   insert        a sum of multiples of steps, with velocities put in
 *   solve         velocities from equations
 *   constraint    a function that vanishes, independent of those before: the dimension falls
 *   redundant     a sum that leaves nothing new
 *   branch        of several ways for a function to vanish one is followed
 *   pivot         what was divided by
 *   stop          why the reduction ends */
#define STEP_KIND_TABLE(X) \
    X(GIVEN, "given") X(SOLVE, "solve") X(DIFFERENTIATE, "differentiate") X(INSERT, "insert") X(CONSTRAINT, "constraint") \
    X(REDUNDANT, "redundant") X(BRANCH, "branch") X(PIVOT, "pivot") X(STOP, "stop")

enum step_kind {
#define X(symbol, text) STEP_##symbol,
    STEP_KIND_TABLE(X)
#undef X
};

/* One equation left = right (relation "=", "!=") of what a step gives. */
struct step_line {
    expr_id left, right;
    const char *text;             /* of the left side where it is to stand as the answer has it; or NULL; borrowed */
};

struct step_term {
    int step;                     /* the number of a step */
    expr_id factor;               /* in the sheet's store; EXPR_UNDEF: it cannot be written */
};

struct step {
    enum step_kind kind;
    int generation;
    const char *text;
    struct step_line *line; int lines; size_t line_cap;
    const char *relation;         /* of the lines; static */
    int *use; int uses; size_t use_cap;
    struct step_term *term; int terms; size_t term_cap;
    int before, after;            /* dimensions */
    const char *basis;            /* static */
};

struct steps {
    struct derivation_sheet *sheet;
    struct sga_arena *mem;        /* of the texts and lists; the owner's */
    struct step *at; int count; size_t cap;
    int dimension;                /* of the set so far */
};

/* A new last step that changes no dimension; its number is count then. `text` is copied. */
struct step *steps_add(struct steps *s, enum step_kind kind, int generation, const char *basis, const char *text);
void steps_line(struct steps *s, struct step *p, expr_id left, expr_id right);
/* A number is used once, however often it is named. */
void steps_use(struct steps *s, struct step *p, int number);
void steps_term(struct steps *s, struct step *p, int number, expr_id factor);
/* The object {"steps": [...]}. */
void steps_write(struct steps *s, struct sga_json *w);

#endif
