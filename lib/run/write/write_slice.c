/* What was not modelled. */
#include <assert.h>

#include "write.h"

#include "buf.h"
#include "run_job.h"
#include "request.h"
#include "slice.h"
#include "warnings.h"

void answer_write_slice(const struct job *j, struct sga_json *w)
{
    const struct model_slice *c = j->part ? j->part->slice : j->slice;
    const struct expr_store *st = &(j->part ? j->part : j)->request->store;
    if (!c)
        return;
    assert(c->gone + c->rows_gone > 0 && c->givens <= c->gone);
    sga_json_key(w, "not_modelled");
    sga_json_object(w);
    sga_json_member_int(w, "variables", c->gone);
    sga_json_member_int(w, "equations", c->rows_gone);
    if (c->gone > SGA_MOST_NAMES_LISTED)
        sga_limit_met(j->budget, SGA_LIMIT_NAMES_LISTED);
    sga_json_key(w, "names");
    sga_json_array(w);
    for (int k = 0; k < c->gone && k < SGA_MOST_NAMES_LISTED; k++)
        sga_json_string(w, st->symbol[c->symbol[k]].name);
    sga_json_end_array(w);
    sga_json_member_int(w, "apart", c->apart);
    sga_json_member_int(w, "follow", c->gone - c->apart);
    sga_json_member_string(w, "note", j->part ? "the outputs do not depend on these variables, and the motion was made without them; all else "
                           "that is said is of the whole system (whether the equations left out have solutions as long as the motion lasts was not examined)"
                           : "the outputs do not depend on these variables; verdict and dimensions are those of the rest, and whether "
                           "the equations left out have solutions (as long as the motion lasts) was not examined");
    sga_json_end_object(w);
}

void answer_write_slice_start(const struct job *j, struct sga_json *w)
{
    const struct model_slice *c = j->slice;
    if (!c || !c->givens)
        return;
    sga_json_key(w, "not_modelled");
    sga_json_object(w);
    for (int k = 0; k < c->givens; k++) {
        sga_json_key(w, j->request->store.symbol[c->given[k].symbol].name);
        sga_json_double(w, c->given[k].value);
    }
    sga_json_end_object(w);
}
