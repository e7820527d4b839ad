/* What each stage of a job takes. */
#include "stage_clock.h"

#include <assert.h>

#include "budget.h"

enum stage stage_begin(struct stage_clock *c, enum stage stage)
{
    double now = sga_now();
    enum stage before = c->now;
    assert(stage < STAGES && before < STAGES);
    if (c->since > 0)
        c->seconds[before] += now - c->since;
    c->now = stage;
    c->since = now;
    return before;
}

const char *stage_text(enum stage stage)
{
    static const char *const text[] = {
#define X(symbol, name) name,
        STAGE_TABLE(X)
#undef X
    };
    return text[stage];
}
