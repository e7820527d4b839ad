/* Bounds of steps by the pieces of the time span. */
#include <math.h>

#include "ode.h"

double ode_within(const struct ode_piece *piece, int pieces, int *at, double t, double direction, double h)
{
    while (*at < pieces && (piece[*at].end - t) * direction <= 0)
        ++*at;
    double begin = 0;
    for (int i = *at; i < pieces && begin < h; i++) {
        h = fmin(h, begin + piece[i].step);
        begin = (piece[i].end - t) * direction;
    }
    return h;
}
