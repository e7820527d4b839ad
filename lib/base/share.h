/* How far a long loop is, for whoever watches the job. Never goes back: what is told is the largest so far. */
#ifndef SGA_BASE_SHARE_H
#define SGA_BASE_SHARE_H

struct sga_budget;

struct sga_share {
    double from, to;                          /* the part of the whole that the present loop is, within 0..1 */
    double told;                              /* the last that was told */
    void (*tell)(void *ctx, double fraction, double t); /* of the whole, 0..1; the system's time that the loop is at, NAN where it has none */
    void *ctx;
};

/* `done` of the present loop, 0..1, at time t of the system. Nothing where the budget has no share, or less than before. Cheap beside a look at the clock. */
void sga_share_tell(const struct sga_budget *b, double done, double t);

#endif
