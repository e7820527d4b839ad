/* Curves in a plane with two logarithmic axes, or two linear ones, as an SVG image.
 *
 * The image is a plain one: no scripts, no links, no fonts or styles from elsewhere; it is the same
 * for the same input, byte by byte. Texts are escaped, and what XML cannot hold is left out. */
#ifndef SGA_PLOT_PLOT_H
#define SGA_PLOT_PLOT_H

#include <stdbool.h>

struct sga_buf;

struct plot_point {
    double x, y;               /* points with a coordinate that is not finite, or on logarithmic axes not positive, are not shown */
    bool bound;                /* the true x is smaller or equal: drawn hollow */
};

/* A curve: its points are joined in their order. */
struct plot_curve {
    const char *name;          /* for the legend; UTF-8 */
    const struct plot_point *point;
    int points;
};

struct plot {
    bool linear;               /* axes; curves have no marks then, and break where a point is not shown */
    const char *title, *x_label, *y_label;
    const char *bound_label;   /* what a hollow mark means, for the legend; NULL where there are none */
    const struct plot_curve *curve;
    int curves;                /* any number; colours and marks repeat after 8 and 5 */
};

/* Appends the document. Axes cover whole decades, linear ones the points, upwards to round numbers. Without a point to show: axes from 1e-3,
 * linear ones from 0, to 1. Cost: linear. */
void plot_svg(const struct plot *p, struct sga_buf *out);

#endif
