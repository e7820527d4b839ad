/* What is printed of an answer. */
#ifndef SGA_RUN_JOB_TEXTS_H
#define SGA_RUN_JOB_TEXTS_H

#include "print.h"

struct job_texts {
    struct expr_names names;      /* roots: constraints, field, gauge fields, in this order */
    bool has;
    int first_field, first_gauge; /* places among the roots */
    expr_id *scale;               /* by constraint: what it was divided by for its text, or EXPR_UNDEF; or NULL */
    bool *reduced;                /* by constraint: that holds where those of older generations vanish; NULL: nowhere needed */
};

#endif
