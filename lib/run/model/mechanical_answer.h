/* Of the form `mechanical`: the geometry of its constraints, and what follows from it. */
#ifndef SGA_RUN_MECHANICAL_ANSWER_H
#define SGA_RUN_MECHANICAL_ANSWER_H

#include "mech.h"

struct mechanical_answer {
    struct mech_fibre fibre;
    bool determined;              /* one acceleration at general points of W */
    struct mech_motion motion;
    bool has_motion;
    int first_root;               /* among the texts: total, tangent, orthogonal, reaction */
    struct mech_regularity regularity;
    bool has_regularity;
};

#endif
