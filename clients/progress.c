/* The time left is extrapolated from the rate of the last seconds of the present stage: stages differ, and so do the solutions of a
 * motion, of which each is tighter than the one before. */
#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "budget.h"

static const double PATIENCE = 1, EVERY = 0.2;         /* seconds before the first line, and between two */
static const double RECENT = 2;                        /* seconds between two marks */
static const double KNOWN = 0.004;                      /* less of a job tells nothing of its rate */

void progress_begin(struct progress *p)
{
    *p = (struct progress){ .on = isatty(STDERR_FILENO), .begin = sga_now() };
}

static int put_left(char *out, size_t size, double seconds)
{
    if (seconds < 99.5)
        return snprintf(out, size, ", about %.0f s left", seconds);
    if (seconds < 99.5 * 60)
        return snprintf(out, size, ", about %.0f min left", seconds / 60);
    return snprintf(out, size, ", about %.0f h left", seconds / 3600);
}

static void write_line(struct progress *p, double now)
{
    char line[120];
    double done = p->fraction - p->mark[0].fraction, spent = now - p->mark[0].at;
    int n = snprintf(line, sizeof line, "%s, %.0f %%, %.0f s", p->stage, 100 * p->fraction, now - p->begin);
    if (done >= KNOWN && spent >= PATIENCE)
        n += put_left(line + n, sizeof line - (size_t)n, (1 - p->fraction) * spent / done);
    fprintf(stderr, "\r%s%*s", line, p->width > n ? p->width - n : 0, "");
    fflush(stderr);
    p->width = n;
    p->last = now;
}

void progress_again(struct progress *p)
{
    double now = p->on ? sga_now() : 0;
    if (p->on && *p->stage && now - p->begin >= PATIENCE && now - p->last >= EVERY)
        write_line(p, now);
}

void progress_show(struct progress *p, const char *stage, double fraction)
{
    if (!p->on)
        return;
    if (strncmp(stage, p->stage, sizeof p->stage - 1) != 0) {
        snprintf(p->stage, sizeof p->stage, "%s", stage);
        p->mark[0].at = p->mark[1].at = sga_now();
        p->mark[0].fraction = p->mark[1].fraction = fraction;
    }
    p->fraction = fraction;
    if (sga_now() - p->mark[1].at >= RECENT) {
        p->mark[0] = p->mark[1];
        p->mark[1].at = sga_now();
        p->mark[1].fraction = fraction;
    }
    progress_again(p);
}

void progress_end(struct progress *p)
{
    if (p->width)
        fprintf(stderr, "\r%*s\r", p->width, "");
    p->width = 0;
    fflush(stderr);
}
