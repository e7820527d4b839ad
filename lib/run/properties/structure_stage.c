/* Structure: as the reduction saw it, and the pencil. */
#include "properties.h"

#include <stdlib.h>

#include "run_job.h"
#include "kronecker.h"
#include "request.h"
#include "stage_clock.h"
#include "structure.h"

bool answer_structure(struct job *j)
{
    stage_begin(j->clock, STAGE_STRUCTURE);
    j->structure = sga_zeros(&j->mem, 1, sizeof *j->structure);
    return structure_find(&j->request->system, j->solution, j->oracle, j->budget, j->structure, j->err);
}

void answer_structure_clear(struct job *j)
{
    if (j->structure)
        structure_clear(j->structure);
    j->structure = NULL;
    free(j->kronecker);
}

bool answer_kronecker(struct job *j)
{
    return kronecker_text(j, &j->kronecker, &j->kronecker_is_linear);
}

