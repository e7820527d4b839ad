/* What a request says of the start beside its values. */
#include "start_of.h"

#include <assert.h>

#include "arena.h"
#include "request.h"
#include "trajectory.h"

void answer_start_of(const struct request *from, struct sga_arena *mem, struct traj_request *r)
{
    const struct request_trajectory *t = &from->trajectory;
    assert(!r->relation && !r->low);
    struct traj_relation *relation = sga_zeros(mem, (size_t)t->relations + 1, sizeof *relation);
    for (int k = 0; k < t->relations; k++)
        relation[k] = (struct traj_relation){ t->relation[k].value, t->relation[k].text, t->relation[k].place };
    r->relation = relation;
    r->relations = t->relations;
    r->rate_symbol = t->rate_symbol;
    r->low = t->low;
    r->high = t->high;
}
