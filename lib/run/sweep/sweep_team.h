/* Inside the run folder: the sets of a sweep, made by this process, or by several (team.h). */
#ifndef SGA_RUN_SWEEP_TEAM_H
#define SGA_RUN_SWEEP_TEAM_H

#include <stdbool.h>
#include <stddef.h>

struct job;

/* What members leave. */
struct sweep_left {
    int moved;       /* starts that were */
    int found;       /* motions */
    bool late;       /* one had none for want of time */
};

/* Makes set k: its JSON, malloced, with what it leaves added to *left. NULL: the job ends with its error. */
struct sweep_maker {
    void *of;
    char *(*make)(void *of, int set, struct sweep_left *left);
};

/* All sets of the job's sweep, in the order of the request, as a JSON array, malloced; *left: of all of them. NULL: the job ends. Warnings and
 * counts of work of other processes are added to the job's own.
 * alone: sets leave more in the job than their texts, so that it makes all of them. Where this process only helps (job_helps) the result is NULL in any case. */
char *sweep_all(struct job *j, int sets, bool alone, struct sweep_maker maker, struct sweep_left *left);

#endif
