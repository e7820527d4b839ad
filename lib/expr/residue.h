/* Values of nodes modulo a prime, at two points: what is the same at both is a constant once sums and products are sorted, whatever
 * form it has, but for a chance of 1e-18 for each node. */
#ifndef SGA_EXPR_RESIDUE_H
#define SGA_EXPR_RESIDUE_H

#include "expr.h"

/* Whether e seems to be a constant (true for constants). Functions are taken as unknown but for f(0), f(1) where these are exact, and
 * odd and even ones as such; what divides by 0 is none. Linear in the nodes of e that were not asked about before; the store keeps
 * 16 bytes for each node once there was a question. */
bool expr_seems_constant(struct expr_store *st, expr_id e);

#endif
