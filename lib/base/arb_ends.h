/* Balls and their parts end with their block of code (arena.h): SGA_ENDS(arb_end) arb_t a = { 0 }; All zeros are an initialised 0. */
#ifndef SGA_BASE_ARB_ENDS_H
#define SGA_BASE_ARB_ENDS_H

#include <arb_mat.h>

#include "arena.h"

SGA_END_BY(arb_end, arb_t, arb_clear)
SGA_END_BY(arf_end, arf_t, arf_clear)
SGA_END_BY(mag_end, mag_t, mag_clear)
SGA_END_BY(arb_mat_end, arb_mat_t, arb_mat_clear)

/* Vectors of n zeros that end with an arena. Nothing but all zeros is set up before the end, so that they may be taken early. */
struct sga_arbs {
    arb_ptr at;
    slong n;
};

static inline void sga_arbs_end(struct sga_arbs *v)
{
    for (slong k = 0; k < v->n; k++)
        arb_clear(v->at + k);
}

static inline arb_ptr arbs_take(struct sga_arena *mem, slong n)
{
    struct sga_arbs *v = sga_take(mem, sizeof *v);
    *v = (struct sga_arbs){ sga_zeros(mem, (size_t)n, sizeof *v->at), n };
    SGA_AT_END(mem, sga_arbs_end, v);
    return v->at;
}

struct sga_mags {
    mag_ptr at;
    slong n;
};

static inline void sga_mags_end(struct sga_mags *v)
{
    for (slong k = 0; k < v->n; k++)
        mag_clear(v->at + k);
}

static inline mag_ptr mags_take(struct sga_arena *mem, slong n)
{
    struct sga_mags *v = sga_take(mem, sizeof *v);
    *v = (struct sga_mags){ sga_zeros(mem, (size_t)n, sizeof *v->at), n };
    SGA_AT_END(mem, sga_mags_end, v);
    return v->at;
}

#endif
