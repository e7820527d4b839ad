/* Where a function of time varies fast: a division of a time span into pieces on each of which it is as smooth as a
 * polynomial of low degree that a few values show.
 *
 * With the Taylor coefficients c_k at the middle of a piece of radius r, and enclosures C_k of those anywhere on it
 * (ball arithmetic on the whole piece, series.h), a piece is done where
 *     |C_p| r^p <= max(sum_{0<k<p} |c_k| r^k, small * the largest value seen)
 * so that what cannot be seen from the middle is no more than what can, or little at all. Others are halved, the
 * worst first. A pulse anywhere on a piece is in C_p, however narrow it is. */
#ifndef SGA_ENCLOSE_SMOOTH_PIECES_H
#define SGA_ENCLOSE_SMOOTH_PIECES_H

#include <stdbool.h>

#include "expr.h"

struct enc_pieces {
    int count;
    double *end;           /* ascending; the first piece begins at `from`, the last ends at `to` */
    double *step;          /* its length; INFINITY for pieces that are not much shorter than the longest one, and for those that
                            * are short only because they lie beside a place without a series */
    bool complete;         /* all are done; else the work, or the time (watch.h), ran out before */
};

/* u depends on the symbol `time` alone. From < to. At most `most` pieces, which costs about as many times 10
 * microseconds for each ten operations. Pieces are not halved below 1e-9 of the span, which they
 * come to where there is no series (sqrt(t) at 0, sin(t)/t there). False: u cannot be put into series, and nothing is filled. */
bool enc_pieces_find(struct enc_pieces *q, const struct expr_store *st, expr_id u, int time, double from, double to, double small,
                     int most);
void enc_pieces_clear(struct enc_pieces *q);

#endif
