/* Inside the mech folder only: looking for points of W where the rank of H drops. */
#ifndef SGA_MECH_DROPS_H
#define SGA_MECH_DROPS_H

#include "facts.h"
#include "mech.h"

struct num_ball;

struct mech_search {
    struct mech_regularity *r;
    struct mech_fibre *f;
    const struct form_mechanical *in;
    const struct reduction_options *options;
    struct expr_store *st;
    struct expr_facts facts;
    expr_id *factor; int factors; size_t factor_cap;
    bool all_never_zero;
    int n, m;                 /* coordinates, conditions */
    bool simple;              /* M is positive definite, seen at once */
};

/* H_ij */
static inline expr_id mech_entry(const struct mech_search *s, int i, int j)
{
    return s->f->H[(size_t)i * (size_t)s->n + (size_t)j];
}

/* ranks.c: numerical ranks at the symbols of a ball, by singular values above tolerance. H and [H, -rate]; then [M, H^T; H, 0], whose
 * full rank is n + m. */
void mech_ranks_at(const struct mech_search *s, struct num_ball *ball, double tolerance, int *rank, int *augmented);
int mech_whole_rank_at(const struct mech_search *s, struct num_ball *ball, double tolerance);

/* drops.c: both note in s->r what they find. Points of W where a factor of a pivot vanishes, or where branches meet; points of W with
 * c^T H = 0 and |c| = 1 (M v = H^T c, H v = 0 where the masses may fail too). */
void mech_search_factors(struct mech_search *s);
void mech_search_kernels(struct mech_search *s);

#endif
