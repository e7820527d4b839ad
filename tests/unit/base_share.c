/* Shares: of the whole, never back, in steps that can be seen. */
#include "budget.h"
#include "check.h"
#include "share.h"

struct said {
    int times;
    double last, t;
};

static void tell(void *ctx, double fraction, double t)
{
    struct said *s = ctx;
    s->times++;
    s->last = fraction;
    s->t = t;
}

int main(void)
{
    struct said said = { 0 };
    struct sga_share share = { .from = 0.5, .to = 0.9, .tell = tell, .ctx = &said };
    struct sga_budget budget = { .share = &share };
    sga_share_tell(NULL, 0.5, 1);
    sga_share_tell(&(struct sga_budget){ 0 }, 0.5, 1);
    CHECK(said.times == 0);
    sga_share_tell(&budget, 0.5, 2);
    CHECK(said.times == 1 && said.last > 0.699 && said.last < 0.701 && said.t == 2);
    sga_share_tell(&budget, 0.25, 3);
    sga_share_tell(&budget, 0.501, 4);
    CHECK(said.times == 1);
    sga_share_tell(&budget, 7, 5);
    CHECK(said.times == 2 && said.last > 0.899 && said.last < 0.901);
    share.from = 0.9, share.to = 0.95;
    sga_share_tell(&budget, -1, 6);
    CHECK(said.times == 2);
    sga_share_tell(&budget, 1, 7);
    CHECK(said.times == 3 && said.last > 0.949 && said.t == 7);
    return CHECK_END();
}
