/* Steps of less than a thousandth are not told. */
#include "share.h"

#include <stddef.h>

#include "budget.h"

void sga_share_tell(const struct sga_budget *b, double done, double t)
{
    struct sga_share *s = b ? b->share : NULL;
    double fraction = s ? s->from + (s->to - s->from) * (done < 0 ? 0 : done > 1 ? 1 : done) : 0;
    if (!s || !(fraction >= s->told + 1e-3))
        return;
    s->told = fraction;
    s->tell(s->ctx, fraction, t);
}
