/* The samples of a result as a table of doubles, or row by row. */
#ifndef SERVER_SAMPLES_H
#define SERVER_SAMPLES_H

#include "arena.h"
#include "view.h"

struct samples {
    struct sga_arena mem;
    bool sweep;                   /* the first column is the place in the sweep, from 0: sets without rows have none here */
    const char **column;          /* names, each once: the second x is x#2 */
    int columns;
    double *value;                /* by rows; NaN for null. NULL: they were not read */
    size_t rows;
    struct view view;
};

/* From what view_open takes. False: that is not there, or memory ended. Digits past those of doubles are rounded away. Cost: linear in the
 * text, and sorting the names. End with samples_end, on failure too. */
bool samples_read(struct samples *s, struct slice trajectory);
/* The same without the values: the names, and how many rows there are. Cost: a walk along the text. */
bool samples_open(struct samples *s, struct slice trajectory);
/* The next row of what was opened, s->columns numbers. False: there is none. */
bool samples_next(struct samples *s, double *value);
/* All of its rows, after samples_open. False: memory ended. */
bool samples_take(struct samples *s);
void samples_end(struct samples *s);

#endif
