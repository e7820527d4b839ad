/* Of the form `operator`: what its analysis found. */
#ifndef SGA_RUN_OPERATOR_ANSWER_H
#define SGA_RUN_OPERATOR_ANSWER_H

#include "error.h"
#include "operator.h"

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

#endif
