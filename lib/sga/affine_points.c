/* Points of affine sets, for those who ask for values. */
#include "affine.h"

bool affine_sample(struct state *s, int constraints)
{
    int all = s->sol->constraints;
    s->sol->constraints = constraints;
    enum points_status status = state_sample_defined(s);
    s->sol->constraints = all;
    if (status == POINTS_OK)
        return true;
    if (status == POINTS_STOPPED)
        return sga_budget_ok(s->options->budget, s->err);
    return sga_fail(s->err, SGA_E_NO_REAL_POINT, "no point of the final set was found where the equations have values; "
                    "give trajectory.initial near such a point");
}
