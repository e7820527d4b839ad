/* An answer as source for other languages: the constraints by generation, their Jacobian, the reduced field with the gauge functions as
 * arguments, the gauge fields, and a projection onto the constraints. Nothing is solved anew: the texts of the answer are read, and what
 * they say is written as statements without loops or tables (straight-line code, shared parts once). */
#ifndef SGA_EXPORT_EXPORT_H
#define SGA_EXPORT_EXPORT_H

#include "error.h"

struct sga_buf;

/* In the order of the columns of the table of operators (operators.c). */
enum export_language {
    EXPORT_C, EXPORT_PYTHON, EXPORT_MATLAB, EXPORT_JULIA, EXPORT_CASADI, EXPORT_MODELICA, EXPORT_LATEX, EXPORT_MATHML, EXPORT_LANGUAGES
};

struct export_parameter {
    const char *name;
    const char *value;            /* an expression without names; NULL: the parameter is an argument */
};
struct export_definition {
    const char *name, *text;      /* may use earlier ones */
};
struct export_constraint {
    int generation;
    const char *text;
};

/* What is exported: texts of the grammar (parse.h), borrowed. */
struct export_source {
    const char *job, *version;    /* for the head; of printable letters without end of comment */
    const char *time;             /* the name of time */
    const char **variable;        int variables;
    struct export_parameter *parameter;   int parameters;
    struct export_definition *definition; int definitions;
    struct export_constraint *constraint; int constraints;
    const char **component;       /* by variable */
    const char **gauge;           /* gauges rows of `variables` texts */
    int gauges;
    const char **output; int outputs;  /* of an FMU, beside the variables */
};

/* The language with this name; EXPORT_LANGUAGES: none. */
enum export_language export_language_find(const char *name);
const char *export_language_name(enum export_language l);
const char *export_language_type(enum export_language l);     /* media type */

/* Appends the source. False, with err set and nothing appended: a text cannot be read, a number lies outside of the doubles, or the whole
 * grows past what an expression store holds. Cost: linear in the texts, and for the Jacobian in its entries. */
bool export_code(const struct export_source *s, enum export_language language, struct sga_buf *out, struct sga_error *err);

#endif
