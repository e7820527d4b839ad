/* The polynomial lies in the arena beside its context. */
#include "mpoly_take.h"

#include "arena.h"

struct taken {
    fmpz_mpoly_t f;
    const fmpz_mpoly_ctx_struct *ctx;
};

static void end(struct taken *t)
{
    fmpz_mpoly_clear(t->f, t->ctx);
}

fmpz_mpoly_struct *mpoly_take(struct sga_arena *mem, const fmpz_mpoly_ctx_t ctx)
{
    struct taken *t = sga_take(mem, sizeof *t);
    t->ctx = ctx;
    fmpz_mpoly_init(t->f, ctx);
    SGA_AT_END(mem, end, t);
    return t->f;
}
