/* Work-precision diagrams: axes by decades, marks, legend. Motions: linear axes, lines. */
#include "plot.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "buf.h"
#include "plot_text.h"

/* Pixels: the field of the curves, and the room around it. */
enum { LEFT = 78, TOP = 48, FIELD_WIDTH = 470, FIELD_HEIGHT = 350, RIGHT = 230, BOTTOM = 62 };
enum { WIDTH = LEFT + FIELD_WIDTH + RIGHT, HEIGHT = TOP + FIELD_HEIGHT + BOTTOM, LEGEND_LINE = 20 };
/* As many decades are labelled at the most. */
enum { MOST_LABELS = 9 };

/* Okabe and Ito's colours, apart for colour-blind readers too; black comes first. */
static const char *const colour[] = { "#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f" };
enum { COLOURS = sizeof colour / sizeof *colour, MARKS = 5 };

struct axis {
    double low, high;          /* decades, or values of a linear axis */
    double step;               /* between the lines of a linear axis; 0: it is logarithmic */
    double from, length;       /* pixels of low, and to high (negative: upwards) */
};

struct sheet {
    const struct plot *p;
    struct sga_buf *out;
    struct axis x, y;
};

static bool shown(const struct plot *p, const struct plot_point *q)
{
    if (p->linear)
        return isfinite(q->x) && isfinite(q->y);
    return q->x > 0 && isfinite(q->x) && q->y > 0 && isfinite(q->y);
}

/* Of a value of a linear axis, too. */
static double place_log(const struct axis *a, double decade)
{
    assert(a->high > a->low);
    return a->from + a->length * (decade - a->low) / (a->high - a->low);
}

static double place(const struct axis *a, double v)
{
    return place_log(a, a->step > 0 ? v : log10(v));
}

static void stretch(double *low, double *high, double v)
{
    *low = fmin(*low, v);
    *high = fmax(*high, v);
}

/* 1, 2 or 5 times a power of 10: some six of them make up the size. */
static double round_step(double size)
{
    double power = pow(10, floor(log10(size / 6))), times = size / 6 / power;
    return power * (times <= 1 ? 1 : times <= 2 ? 2 : times <= 5 ? 5 : 10);
}

/* `outward`: to whole steps. A value that does not change gets room on both sides. */
static void set_linear_axis(struct axis *a, double low, double high, bool outward)
{
    if (!(low <= high)) {
        low = 0;
        high = 1;
    }
    double room = high - low > 1e-12 * (fabs(low) + fabs(high)) ? 0 : fmax(fabs(high) / 2, high == 0 ? 1 : 0);
    a->low = low - room;
    a->high = high + room;
    a->step = round_step(a->high - a->low);
    if (outward) {
        a->low = a->step * floor(a->low / a->step + 1e-9);
        a->high = a->step * ceil(a->high / a->step - 1e-9);
    }
}

static void set_axis(struct axis *a, double low, double high)
{
    if (!(low <= high)) {
        low = 1e-3;
        high = 1;
    }
    a->low = floor(log10(low) + 1e-9);
    a->high = ceil(log10(high) - 1e-9);
    if (a->low == a->high)
        a->high++;
}

static void set_axes(struct sheet *s)
{
    double x_low = INFINITY, x_high = s->p->linear ? -INFINITY : 0, y_low = INFINITY, y_high = x_high;
    for (int c = 0; c < s->p->curves; c++)
        for (int i = 0; i < s->p->curve[c].points; i++) {
            const struct plot_point *q = s->p->curve[c].point + i;
            if (!shown(s->p, q))
                continue;
            stretch(&x_low, &x_high, q->x);
            stretch(&y_low, &y_high, q->y);
        }
    if (s->p->linear) {
        set_linear_axis(&s->x, x_low, x_high, false);
        set_linear_axis(&s->y, y_low, y_high, true);
    } else {
        set_axis(&s->x, x_low, x_high);
        set_axis(&s->y, y_low, y_high);
    }
    s->x.from = LEFT;
    s->x.length = FIELD_WIDTH;
    s->y.from = TOP + FIELD_HEIGHT;
    s->y.length = -FIELD_HEIGHT;
}

static void line(struct sga_buf *out, const char *stroke, double x1, double y1, double x2, double y2)
{
    sga_buf_printf(out, "<line stroke=\"%s\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n", stroke, x1, y1, x2, y2);
}

static void put_text(struct sga_buf *out, double x, double y, const char *more, const char *text)
{
    sga_buf_printf(out, "<text x=\"%.1f\" y=\"%.1f\"%s>", x, y, more);
    plot_escape(text, out);
    sga_buf_puts(out, "</text>\n");
}

/* 10 with its exponent. */
static void put_decade(struct sga_buf *out, double x, double y, const char *anchor, int exponent)
{
    sga_buf_printf(out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">10<tspan dy=\"-6\" font-size=\"10\">%d</tspan></text>\n",
                   x, y, anchor, exponent);
}

static void put_linear_axis(struct sheet *s, const struct axis *a, bool across)
{
    double bottom = TOP + FIELD_HEIGHT, right = LEFT + FIELD_WIDTH;
    for (double k = ceil(a->low / a->step - 1e-9); k * a->step <= a->high + 1e-9 * a->step; k++) {
        char label[40];
        double at = place(a, k * a->step);
        snprintf(label, sizeof label, "%.6g", k == 0 ? 0.0 : k * a->step);
        across ? line(s->out, "#cccccc", at, TOP, at, bottom + 5) : line(s->out, "#cccccc", LEFT - 5, at, right, at);
        if (across)
            put_text(s->out, at, bottom + 24, " text-anchor=\"middle\"", label);
        else
            put_text(s->out, LEFT - 9, at + 5, " text-anchor=\"end\"", label);
    }
}

/* Lines at decades and, where there are few, at 2 to 9 between them; labels. */
static void put_axis(struct sheet *s, const struct axis *a, bool across)
{
    int low = (int)a->low, high = (int)a->high, every = (high - low + MOST_LABELS - 1) / MOST_LABELS;
    double bottom = TOP + FIELD_HEIGHT, right = LEFT + FIELD_WIDTH;
    for (int d = low; d <= high; d++) {
        double at = place_log(a, d);
        for (int k = 2; k <= 9 && d < high && high - low <= 4; k++) {
            double minor = place_log(a, d + log10(k));
            across ? line(s->out, "#eeeeee", minor, TOP, minor, bottom) : line(s->out, "#eeeeee", LEFT, minor, right, minor);
        }
        across ? line(s->out, "#cccccc", at, TOP, at, bottom + 5) : line(s->out, "#cccccc", LEFT - 5, at, right, at);
        if ((d - low) % every)
            continue;
        if (across)
            put_decade(s->out, at, bottom + 24, "middle", d);
        else
            put_decade(s->out, LEFT - 9, at + 5, "end", d);
    }
}

/* Circle, square, diamond, triangle up, triangle down. */
static void put_mark(struct sga_buf *out, int kind, double x, double y, const char *fill, const char *stroke)
{
    static const char *const path[MARKS] = { NULL, "m-3.5,-3.5h7v7h-7z", "m0,-5l5,5l-5,5l-5,-5z", "m0,-5l4.6,8h-9.2z", "m0,5l4.6,-8h-9.2z" };
    if (!path[kind])
        sga_buf_printf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.8\" fill=\"%s\" stroke=\"%s\"/>\n", x, y, fill, stroke);
    else
        sga_buf_printf(out, "<path d=\"M%.1f,%.1f%s\" fill=\"%s\" stroke=\"%s\"/>\n", x, y, path[kind], fill, stroke);
}

static void put_line(struct sheet *s, const struct plot_curve *c, int number)
{
    bool open = false;
    for (int i = 0; i <= c->points; i++) {
        bool here = i < c->points && shown(s->p, c->point + i);
        if (here)
            sga_buf_printf(s->out, s->p->linear ? "%s%.2f,%.2f" : "%s%.1f,%.1f", open ? " " : "<polyline points=\"",
                           place(&s->x, c->point[i].x), place(&s->y, c->point[i].y));
        else if (open && (i == c->points || s->p->linear))
            sga_buf_printf(s->out, "\" fill=\"none\" stroke=\"%s\" stroke-width=\"1.5\"%s/>\n", colour[number % COLOURS],
                           number >= COLOURS ? " stroke-dasharray=\"5 3\"" : "");
        open = here || (open && !s->p->linear);
    }
}

static void put_curve(struct sheet *s, int number)
{
    const struct plot_curve *c = s->p->curve + number;
    const char *stroke = colour[number % COLOURS];
    put_line(s, c, number);
    for (int i = 0; i < c->points && !s->p->linear; i++)
        if (shown(s->p, c->point + i))
            put_mark(s->out, number % MARKS, place(&s->x, c->point[i].x), place(&s->y, c->point[i].y),
                     c->point[i].bound ? "#ffffff" : stroke, stroke);
}

static void put_legend(struct sheet *s)
{
    double x = LEFT + FIELD_WIDTH + 18, y = TOP + 12;
    for (int k = 0; k < s->p->curves; k++, y += LEGEND_LINE) {
        const char *stroke = colour[k % COLOURS];
        sga_buf_printf(s->out, "<line stroke=\"%s\" stroke-width=\"1.5\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"%s/>\n", stroke,
                       x, y, x + 26, y, k >= COLOURS ? " stroke-dasharray=\"5 3\"" : "");
        if (!s->p->linear)
            put_mark(s->out, k % MARKS, x + 13, y, stroke, stroke);
        put_text(s->out, x + 33, y + 4, "", s->p->curve[k].name);
    }
    if (!s->p->bound_label)
        return;
    put_mark(s->out, 0, x + 13, y, "#ffffff", "#555555");
    put_text(s->out, x + 33, y + 4, " fill=\"#555555\"", s->p->bound_label);
}

void plot_svg(const struct plot *p, struct sga_buf *out)
{
    struct sheet s = { .p = p, .out = out };
    int lines = p->curves + (p->bound_label != NULL), needed = TOP + 24 + LEGEND_LINE * lines;
    int height = needed > HEIGHT ? needed : HEIGHT;
    set_axes(&s);
    assert(height >= HEIGHT && lines >= p->curves);
    sga_buf_printf(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" "
                   "viewBox=\"0 0 %d %d\" role=\"img\" font-family=\"sans-serif\" font-size=\"13\">\n<title>", WIDTH, height, WIDTH, height);
    plot_escape(p->title, out);
    sga_buf_printf(out, "</title>\n<rect width=\"%d\" height=\"%d\" fill=\"#ffffff\"/>\n", WIDTH, height);
    (p->linear ? put_linear_axis : put_axis)(&s, &s.x, true);
    (p->linear ? put_linear_axis : put_axis)(&s, &s.y, false);
    sga_buf_printf(out, "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"none\" stroke=\"#333333\"/>\n", LEFT, TOP, FIELD_WIDTH, FIELD_HEIGHT);
    for (int k = 0; k < p->curves; k++)
        put_curve(&s, k);
    put_legend(&s);
    put_text(out, LEFT, TOP - 20, " font-size=\"15\"", p->title);
    put_text(out, LEFT + FIELD_WIDTH / 2.0, TOP + FIELD_HEIGHT + 50, " text-anchor=\"middle\"", p->x_label);
    char turned[96];
    snprintf(turned, sizeof turned, " text-anchor=\"middle\" transform=\"rotate(-90 20 %.1f)\"", TOP + FIELD_HEIGHT / 2.0);
    put_text(out, 20, TOP + FIELD_HEIGHT / 2.0, turned, p->y_label);
    sga_buf_puts(out, "</svg>\n");
}
