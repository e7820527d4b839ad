/* Inside the structure folder. */
#ifndef SGA_STRUCTURE_STRUCTURE_WORK_H
#define SGA_STRUCTURE_STRUCTURE_WORK_H

#include "arena.h"
#include "oracle.h"

struct structure;

struct structure_work {
    const struct sys_system *sys;
    const struct sga_solution *sol;
    struct points_oracle *oracle;          /* on Pf */
    struct points_oracle space;            /* on the whole space; sampled when first asked */
    int space_state;                       /* 0 not asked, 1 there, -1 cannot be had */
    const struct sga_budget *budget;
    struct sga_arena mem;                  /* of column and active */
    struct expr_cone cone;
    int *column;                           /* by symbol: variable or -1 */
    int symbols;
    unsigned char *active;                 /* by symbol: a variable */
};

/* Which values at the start are free: a basis of the columns of d(constraints). */
void structure_initial(struct structure_work *w, struct structure *out);
/* The role of each equation, and the combinations behind consequences. */
void structure_equations(struct structure_work *w, struct structure *out);
/* Incidence, matching, blocks, groups. */
void structure_blocks(struct structure_work *w, struct structure *out);

/* What each block rests on (after the blocks), and each determined initial value. */
void structure_origins(struct structure_work *w, struct structure *out);
void structure_follow(struct structure_work *w, struct structure *out);

/* Whether e is zero on all of the space: 1, 0, -1 unknown. */
int structure_zero_everywhere(struct structure_work *w, expr_id e);

#endif
