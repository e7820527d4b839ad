/* Inside the pencil folder: the structure modulo one prime. */
#ifndef SGA_PENCIL_STAIRCASE_H
#define SGA_PENCIL_STAIRCASE_H

#include <flint/nmod_mat.h>

#include "integral.h"

/* By step j = 1, 2, ...: nullity[j - 1] columns of A are deflated, on which B has rank[j - 1].
 * nullity_j - rank_j minimal indices are j - 1, and rank_j - nullity_(j+1) infinite blocks have size j. */
struct staircase {
    int *nullity, *rank;
    int steps;
    size_t nullity_cap, rank_cap;
};

struct structure_mod {
    struct staircase right, left;
    nmod_mat_t finite;             /* J (or its transpose), square */
    double work;                   /* multiplications spent */
};

/* p modulo a prime below 2^62. Every index is at most that over the rationals in the sense of
 * ranks of expanded matrices: a rank modulo a prime is never too large. False: the budget
 * ended. The caller clears m after true. */
bool structure_mod(const struct integral *p, mp_limb_t prime, struct structure_mod *m,
                   const struct sga_budget *budget, struct sga_error *err);
void structure_mod_clear(struct structure_mod *m);

/* Sum of all nullities and ranks at or before step k of both staircases compared: < 0 where a is
 * the more generic structure, 0 where they are the same. */
int structure_mod_compare(const struct structure_mod *a, const struct structure_mod *b);

#endif
