/* A set that an answer does not speak of. */
#ifndef SGA_RUN_STRATUM_H
#define SGA_RUN_STRATUM_H

#include <assert.h>

#include <stdbool.h>

#include "buf.h"
#include "cases.h"
#include "error.h"

enum stratum_state { STRATUM_LISTED, STRATUM_SOLVED, STRATUM_EMPTY, STRATUM_MERGED, STRATUM_SAME, STRATUM_UNSOLVED, STRATUM_SKIPPED };

/* Where a pivot or a factor of a product vanishes. */
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

/* Whether it keeps its rules: functions or a description say where it is, and its state has what goes with it. */
bool stratum_sane(const struct stratum *s);

#endif
