/* Polynomials that end with an arena (arena.h), which keeps their context for that. */
#ifndef SGA_POLY_MPOLY_TAKE_H
#define SGA_POLY_MPOLY_TAKE_H

#include <flint/fmpz_mpoly.h>

struct sga_arena;

/* A new one, 0. */
fmpz_mpoly_struct *mpoly_take(struct sga_arena *mem, const fmpz_mpoly_ctx_t ctx);

#endif
