/* The samples of a result as a table of doubles. */
#ifndef SERVER_SAMPLES_H
#define SERVER_SAMPLES_H

#include "arena.h"
#include "json_scan.h"

struct samples {
    struct sga_arena mem;
    bool sweep;                   /* the first column is the place in the sweep, from 0: sets without rows have none here */
    const char **column;          /* names, each once: the second x is x#2 */
    int columns;
    double *value;                /* by rows; NaN for null */
    size_t rows;
};

/* From what view_open takes. False: that is not there, or memory ended. Digits past those of doubles are rounded away. Cost: linear in the
 * text, and sorting the names. End with samples_end, on failure too. */
bool samples_read(struct samples *s, struct slice trajectory);
void samples_end(struct samples *s);

#endif
