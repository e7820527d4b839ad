/* Inside the traj folder: the piece of a motion that an event begins, in the mode that the event sets.
 *
 * Each mode has its own system and reduction, with its own variables: those of one name are one. Events and columns are the same in all. */
#ifndef SGA_TRAJ_JUMP_TURN_H
#define SGA_TRAJ_JUMP_TURN_H

#include "jump_set.h"

struct turn {
    const struct traj_mode *mode;  /* the present one */
    struct jump j;                 /* of it */
    struct jump before;            /* while an event is on that changes it: of the one before */
    bool changing;
    unsigned char *place;          /* what struct jump_to points to */
    double *x, *was;               /* in the variables of `mode`: set; as they were before */
    struct slide *slide;           /* where switches are modes; or NULL */
    bool stays;                    /* sides of switches are not taken now */
    char why[256];                 /* after turn_begin and turn_land: not empty: no motion goes on, for this reason */
};

bool turn_init(struct turn *s, const struct traj_mode *mode, struct sga_error *err);
void turn_clear(struct turn *s);
/* at: in the variables of the present mode, which turn_begin changes where an event sets one. to->x: as it is set, then (turn_land) the start.
 * turn_end is due once after turn_begin, whatever it gave; to->impulse is freed there unless it was taken. */
bool turn_begin(struct turn *s, const struct jump_at *at, struct jump_to *to, struct sga_error *err);
bool turn_land(struct turn *s, const struct jump_at *at, struct jump_to *to, signed char *side, unsigned char *stands, struct sga_error *err);
void turn_end(struct turn *s, struct jump_to *to);

#endif
