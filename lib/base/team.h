/* Processes that make the pieces of one loop together, as a team of threads would share the work of a loop.
 *
 * Each member runs the same request, comes to the same loop, and makes pieces of it until none is left; it writes no answer. The process
 * that leads makes pieces too, gets those of the others, and goes on. A piece is the same whoever makes it. Whoever runs the
 * job gives the functions: there may be nobody to help. */
#ifndef SGA_BASE_TEAM_H
#define SGA_BASE_TEAM_H

#include <stdbool.h>
#include <stddef.h>

struct sga_team {
    void *ctx;
    bool member;           /* it helps; false: it leads */
    double spent;          /* of a member: seconds that the job had run for when it was asked to help */
    bool begun;            /* its loop was: one in a job, the first */

    /* Leads: asks for help with the pieces [from, count), `spent` seconds after the job began, that took some `each` seconds so far. False: there is none to be had now; it may ask again.
     * Waits for nobody to start. May return in copies of this process too (fork), as members. */
    bool (*share)(void *ctx, int from, int count, double spent, double each);
    /* The pieces [*from, *to) are to be made; *made of all are there or handed out. False: none is left, and where it leads they are all made and given
     * to take; or the job ends. Waits for an answer of whoever runs the job. */
    bool (*next)(void *ctx, int *from, int *to, int *made);
    /* A member made these. Borrowed. False: nobody takes them any more. */
    bool (*give)(void *ctx, int from, int to, const char *data, size_t length);
    /* Leads, while next waits: what others made. Returns false where that is not understood; the job ends then. */
    bool (*take)(void *of, int from, int to, const char *data, size_t length);
    void *of;
};

#endif
