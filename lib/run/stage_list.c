/* The table of stages. */
#include "stage_list.h"

#include "ask.h"
#include "derivation.h"
#include "dirac.h"
#include "follow.h"
#include "run_job.h"
#include "properties.h"
#include "reduce.h"
#include "request.h"
#include "sets.h"
#include "strata.h"
#include "texts.h"
#include "vary.h"

static bool has_operator(const struct job *j)
{
    return j->request->op.has;
}

static bool has_mechanical(const struct job *j)
{
    return j->request->mechanical;
}

static bool wants_structure(const struct job *j)
{
    return !job_helps(j) && j->request->want & REQUEST_STRUCTURE && !j->request->op.open_sources;
}

static bool wants_symmetries(const struct job *j)
{
    return !job_helps(j) && j->request->want & REQUEST_SYMMETRIES;
}

static bool wants_kronecker(const struct job *j)
{
    return !job_helps(j) && (j->request->want & REQUEST_STRUCTURE || answer_operator_is_pencil(j));
}

static bool wants_linearization(const struct job *j)
{
    return j->request->want & REQUEST_LINEARIZATION && !j->place.depth && !j->request->sweeps;
}

static bool wants_transfer(const struct job *j)
{
    return j->request->want & REQUEST_TRANSFER && !j->place.depth && !j->request->sweeps;
}

static bool wants_equilibria(const struct job *j)
{
    return j->request->want & REQUEST_EQUILIBRIA && !j->place.depth && !j->request->sweeps;
}

static bool wants_sensitivities(const struct job *j)
{
    return j->request->want & REQUEST_TRAJECTORY && j->request->trajectory.sensitivities.has && !j->place.depth && !j->request->sweeps;
}

static bool wants_derivation(const struct job *j)
{
    return !job_helps(j) && j->request->want & REQUEST_DERIVATION && !j->place.depth;
}

static bool wants_fit(const struct job *j)
{
    return j->request->want & REQUEST_FIT && !j->place.depth && !j->request->sweeps;
}

static bool wants_dirac(const struct job *j)
{
    return !job_helps(j) && j->request->want & REQUEST_DIRAC && !j->place.depth;
}

const struct job_stage job_stages[] = {
    { "operator",   -1,   false, has_operator,     answer_operator,          answer_operator_clear },
    { "mechanical", 0.04, false, has_mechanical,   answer_mechanical,        answer_mechanical_clear },
    { "reduction",  0.05, false, NULL,             answer_reduce,            answer_reduce_clear },
    { "sga",        -1,   false, has_mechanical,   answer_mechanical_motion, NULL },
    { "texts",      0.4,  false, NULL,             answer_texts,             answer_texts_clear },
    { "texts",      -1,   false, NULL,             answer_strata,            answer_strata_clear },
    { "texts",      -1,   false, NULL,             answer_signs,             answer_signs_clear },
    { "witness",    0.45, false, NULL,             answer_witness,           answer_witness_clear },
    { "derivation", -1,   false, wants_derivation, answer_derivation,        NULL },
    { "dirac",      -1,   false, wants_dirac,      answer_dirac,             NULL },
    { "structure",  0.45, false, wants_structure,  answer_structure,         answer_structure_clear },
    { "symmetries", 0.48, false, wants_symmetries, answer_symmetries,        answer_symmetries_clear },
    { "structure",  -1,   false, wants_kronecker,  answer_kronecker,         NULL },
    { "trajectory", 0.5,  true,  NULL,             answer_motion,            answer_motion_clear },
    { "sensitivities", 0.8, true, wants_sensitivities, answer_sensitivities, answer_vary_clear },
    { "fit",        0.82, true,  wants_fit,        answer_fit,               NULL },
    { "linearization", 0.9, true, wants_linearization, answer_linearization, answer_ask_clear },
    { "transfer",   -1,   true,  wants_transfer,   answer_transfer,          NULL },
    { "equilibria", -1,   true,  wants_equilibria, answer_equilibria,        NULL },
    { "sets",       0.9,  true,  answer_sets_are_asked, answer_sets,         answer_sets_clear },
    { "trajectory", -1,   true,  NULL,             answer_strata_solve,      NULL },
    { 0 },
};
