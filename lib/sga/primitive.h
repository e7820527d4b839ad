/* Inside the sga folder: candidates as vectors of the left kernel give them that have no common factor. */
#ifndef SGA_SGA_PRIMITIVE_H
#define SGA_SGA_PRIMITIVE_H

struct candidate;
struct state;

/* A left kernel vector that was made by dividing by pivots says nothing where these vanish; one of full length without a common
 * factor says what holds there too: (1, -1) on the rows z u' = z, z u' = z x gives z (1 - x) = 0, and z = 0 is a part of the set. Where
 * pivots cancelled c says less than the latter, and where they did not it has poles that are none of the set's: it becomes that, c by the vector's
 * common denominator (the candidate's `times`). Which rows were chosen for pivots, and in which order, does not show then. Left as it is where the
 * vector is too large, or was made with a dense block. */
void primitive_candidate(struct state *s, struct candidate *c);

#endif
