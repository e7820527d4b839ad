/* Inside the sga folder: the search for variables that equations define (definition.h). */
#ifndef SGA_SGA_DEFINITION_SEARCH_H
#define SGA_SGA_DEFINITION_SEARCH_H

#include "definition.h"
#include "facts.h"

struct definition_reach {
    int *seen;                     /* by definition: in this turn */
    int *stack, depth;             /* those that were met and are to be looked at */
};

struct definition_search {
    struct sga_arena mem;          /* of all vectors below */
    const struct sys_system *sys;
    const struct sga_budget *budget;
    struct expr_store *st;
    struct definitions *d;
    enum definitions_asked asked;
    struct expr_facts facts;
    struct expr_cone cone;
    unsigned char *moves;          /* by variable: its derivative is in some row */
    unsigned char *used;           /* by row: it is a definition, or no longer asked */
    int *met;                      /* by variable: how many other equations without derivatives have it */
    int *column;                   /* by symbol: variable or -1 */
    expr_id *factor, *rest;        /* by row: see struct definition; rest is the row where there is no factor */
    expr_id *alpha;                /* by row: the rest with what is defined so far put in */
    expr_id *map;                  /* by symbol */
    expr_id *slope; size_t slope_cap;   /* scratch, by place in the cone */
    /* where all are asked for, values stay as their rows have them until the end: */
    int *by;                       /* by variable: the definition that it has, or -1 */
    int *first, *variable;         /* the variables of row i are variable[first[i] .. first[i + 1]) */
    int *meet, *row;               /* the rows of variable j are row[meet[j] .. meet[j + 1]) */
    int *defines;                  /* by row: the definition that it is, or -1 */
    int turn;
    struct definition_reach down, up;   /* to what a definition uses, and to those that use it */
};

/* The variable that the row, with what is put in so far, defines, if one: of several the one that the fewest other equations without
 * derivatives have. */
bool definition_by(struct definition_search *s, int row, struct definition *best);

/* definition_bent.c: e = p (v - c) + q |v - c| + rest with numbers p, q and c, |q| < |p|, rises or falls with v throughout: v where e = 0, in
 * *value; the slope of e is p + q sign(v - c). The cone is e's, indexed. False: e is not that. */
bool definition_bent(struct definition_search *s, expr_id e, int symbol, expr_id *value, expr_id *slope);

/* definition_all.c: whether the row has a variable whose value, as known so far, leads back to v; false where not all are asked for. */
bool definition_comes_back(struct definition_search *s, int row, int v);
/* s->d gets all of them. */
void definition_all(struct definition_search *s);

#endif
