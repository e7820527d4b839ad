/* A line on the terminal while a job takes long: its stage, the share done, the time left. Standard error, and only where that is a
 * terminal: elsewhere nothing is printed. */
#ifndef CLIENTS_PROGRESS_H
#define CLIENTS_PROGRESS_H

#include <stdbool.h>

struct progress {
    bool on;                      /* standard error is a terminal */
    char stage[24];
    double fraction;              /* of the whole job, the last that was told */
    double begin;                 /* seconds of sga_now */
    struct {
        double at, fraction;
    } mark[2];                    /* from the first on the rate is taken; the second becomes the first when it is old enough */
    double last;                  /* when the line was written; 0: it was not */
    int width;                    /* of what stands there */
};

void progress_begin(struct progress *p);
/* What is known now; the line is written after a second, and then some times a second at most. */
void progress_show(struct progress *p, const char *stage, double fraction);
/* The same as before, later: for calls in between. */
void progress_again(struct progress *p);
/* Erases the line. */
void progress_end(struct progress *p);

#endif
