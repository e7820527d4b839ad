/* Balls and their parts end with their block of code (arena.h): SGA_ENDS(arb_end) arb_t a = { 0 }; All zeros are an initialised 0. */
#ifndef SGA_BASE_ARB_ENDS_H
#define SGA_BASE_ARB_ENDS_H

#include <arb_mat.h>

#include "arena.h"

SGA_END_BY(arb_end, arb_t, arb_clear)
SGA_END_BY(arf_end, arf_t, arf_clear)
SGA_END_BY(mag_end, mag_t, mag_clear)
SGA_END_BY(arb_mat_end, arb_mat_t, arb_mat_clear)

/* take(arena, n): a vector of n zeros that ends with an arena. Nothing but all zeros is set up before the end, so that it may be
 * taken early. */
#define ARB_VECTOR_BY(take, pointer, clear) \
    struct take##_vector { \
        pointer at; \
        slong n; \
    }; \
    static inline void take##_end(struct take##_vector *v) \
    { \
        for (slong k = 0; k < v->n; k++) \
            clear(v->at + k); \
    } \
    static inline pointer take(struct sga_arena *mem, slong n) \
    { \
        struct take##_vector *v = sga_take(mem, sizeof *v); \
        *v = (struct take##_vector){ sga_zeros(mem, (size_t)n, sizeof *v->at), n }; \
        SGA_AT_END(mem, take##_end, v); \
        return v->at; \
    }
ARB_VECTOR_BY(arbs_take, arb_ptr, arb_clear)
ARB_VECTOR_BY(mags_take, mag_ptr, mag_clear)

#endif
