/* Where a polynomial first leaves the side of a border that it begins on: by the variation of signs of its Bernstein
 * coefficients (Descartes' rule on an interval, after Vincent, Collins and Akritas), so that a short passage to the other
 * side is seen, also where the coefficients grow by many decades.
 * Sources: J. M. Lane, R. F. Riesenfeld, Bounds on a polynomial, BIT 21 (1981); C. Collins, A. Akritas, SYMSAC 1976. */
#ifndef NUM_FIRST_CHANGE_H
#define NUM_FIRST_CHANGE_H

#include <stdbool.h>

/* c: the coefficients 0..k of p, with p > 0 on the side that it is on; work: 2 (k + 1) numbers. True: p is not negative on
 * [0, *low], and negative at *high or just before, with one change between them; 0 <= low < high <= 1. False: no change in
 * (0, 1] that is deeper than the roundings of p's terms, or the numbers are not finite. Changes that are closer together
 * than 1e-11 are not told apart; where hundreds of near zeros have to be, the change that is given need not be the first. Cost: k^2 for each interval that is looked at, mostly one. */
bool num_first_change(const double *c, int k, double *work, double *low, double *high);

#endif
