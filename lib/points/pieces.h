/* Inside the points folder: the searches behind beyond.h. */
#ifndef SGA_POINTS_PIECES_H
#define SGA_POINTS_PIECES_H

#include "beyond.h"

/* From p, over each switch alone, and from the points found there over a second one, and so on, some way. */
void points_pieces_search(struct points_beyond *b, const struct points_space *space, struct points_point *p);
/* From piece k back over the switch that was passed last. Whether a point was found: piece[k].back. */
bool points_pieces_back(struct points_beyond *b, const struct points_space *space, int k);

#endif
