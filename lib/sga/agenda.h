/* Inside the sga folder: which rows of an elimination are left, and the pivot that comes next. */
#ifndef SGA_SGA_AGENDA_H
#define SGA_SGA_AGENDA_H

#include "arena.h"
#include "at_start.h"

/* Rows by length, and which rows meet a column; both lists may hold stale members. */
struct agenda {
    struct sga_arena mem;
    const struct ech_context *c;
    struct ech_row *row;
    int rows;
    unsigned char *done;
    int **bucket; int *bucket_len; size_t *bucket_cap;    /* by number of entries */
    int **meet; int *meet_len; size_t *meet_cap;          /* by column */
    int cols;
    int lowest;
    struct agenda_size { int entries, functions; } *size;  /* by row, 0 once it is done: entries, and those that are no numbers ... */
    long left, entries, functions;                        /* ... and of all rows that are left and have entries */
    expr_id *mixed; int mixes; size_t mix_cap;            /* entries that are 0 on some sides of the set and not on others */
    bool sided;                                           /* these are asked now, on the side where the points are */
    struct at_start start;
    unsigned char *idle; size_t idle_cap;                 /* by expression: 1 it is no zero where a motion is to start, 2 it is; 0 not asked */
};

void agenda_init(struct agenda *a, const struct ech_context *c, struct ech_row *row, int rows, int cols);
void agenda_clear(struct agenda *a);
/* To be called where row i has changed. Costs what it is long. */
void agenda_file_row(struct agenda *a, int i);
/* Row i may have an entry in the column now. */
void agenda_file_column(struct agenda *a, int col, int i);
/* Row i is dealt with. */
void agenda_done(struct agenda *a, int i);
/* The best pivot among a few of the shortest rows, or a row without entries (at = -1). False: no rows are left. Costs what the rows that
 * are looked at are long, and the stale members that are dropped. */
bool agenda_choose(struct agenda *a, int *row, int *at);
/* Whether what is left is better solved as a whole (block.h) than with the chosen entry of row i as a pivot. Costs what that row is long. */
bool agenda_is_block(const struct agenda *a, int i, int at);

#endif
