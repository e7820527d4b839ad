/* Inside the points folder: the searches behind beyond.h. */
#ifndef SGA_POINTS_PIECES_H
#define SGA_POINTS_PIECES_H

#include "beyond.h"

/* From p, over each of the switches asked for (by switch) alone, where that was not done before, and from the points found there
 * over a second one, and so on, some way. */
void points_pieces_search(struct points_beyond *b, const struct points_space *space, struct points_point *p, const unsigned char *asked);
/* From p, where the function of a switch that is none of the constraints' has a sign, to a point of the set beyond; and to one
 * near the surface, on the same side. The caller clears q in every case. */
bool points_pieces_over(struct points_beyond *b, const struct points_space *space, struct points_point *p, struct points_side from,
                        struct points_point *q);
bool points_pieces_near(struct points_beyond *b, const struct points_space *space, struct points_point *p, struct points_side from,
                        struct points_point *q);
/* From piece k back over the switch that was passed last. Whether a point was found: piece[k].back. */
bool points_pieces_back(struct points_beyond *b, const struct points_space *space, int k);

#endif
