/* What is known of a function being zero on a set. */
#ifndef SGA_POINTS_TRUTH_H
#define SGA_POINTS_TRUTH_H

enum points_truth { POINTS_NONZERO, POINTS_ZERO, POINTS_UNKNOWN };

#endif
