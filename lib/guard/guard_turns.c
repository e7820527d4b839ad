/* Where functions along a way turn: between neighbours of these places each of them is monotone, so that a change of sign
 * or a touch of 0 cannot hide between nodes of a table, however close others are (products, clusters).
 *
 * Each function is interpolated in Chebyshev points; the way is halved where the coefficients do not fall to rounding. Zeros
 * of the derivative are isolated by bounds: |c_0| above the sum of the others leaves no zero, the same of the second
 * derivative one at the most (Boyd, Solving Transcendental Equations, SIAM 2014, chapters 2 and 3). */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "guard.h"
#include "mem.h"

/* Degree; halvings of a step, and of a piece (to 1e-7 of it); bisections of the place of an extreme (1e-9 of a piece: at an
 * extreme values change by the square). Not resolved after HALVINGS are kinks and noise, which are looked at as they stand, and
 * waves of more than 30 lengths in a step, of which the coefficients still tell the extremes as far as table.c follows. */
enum { N = 16, HALVINGS = 6, SPLITS = 24, BISECTIONS = 30 };
#define NOISE (64 * DBL_EPSILON)                /* of the largest value: what coefficients fall to */
#define ROUNDINGS 8.0                           /* of the place, in a value */
#define LITTLE 1e-6                             /* of the largest value: what noise is at the most, */
#define FALLS 0.85                              /* and the part of what it was before a piece was halved (a cube root: 0.8) */
#define FEW_DIGITS 1e-8                         /* the same where factors have lost digits of their own */
#define FAR 2.0                                 /* so many times as large as its changes a function does not come near 0, */
#define CLEAR 1e-3                              /* where the coefficients show these changes, up to a part of them */

struct piece { double a, b, c[N + 1]; };

/* cos(pi k/N) */
static const double WAVE[2 * N] = {
    1, 0.98078528040323044913, 0.92387953251128675613, 0.83146961230254523708, 0.7071067811865475244, 0.55557023301960222474, 0.38268343236508977173, 0.19509032201612826785,
    0, -0.19509032201612826785, -0.38268343236508977173, -0.55557023301960222474, -0.7071067811865475244, -0.83146961230254523708, -0.92387953251128675613, -0.98078528040323044913,
    -1, -0.98078528040323044913, -0.92387953251128675613, -0.83146961230254523708, -0.7071067811865475244, -0.55557023301960222474, -0.38268343236508977173, -0.19509032201612826785,
    0, 0.19509032201612826785, 0.38268343236508977173, 0.55557023301960222474, 0.7071067811865475244, 0.83146961230254523708, 0.92387953251128675613, 0.98078528040323044913,
};

/* Coefficients from values at cos(pi k/N): the even ones from sums of values at u and -u, the odd ones from differences. */
static void from_values(const double *v, double *c)
{
    double folded[2][N / 2 + 1];
    for (int k = 0; k <= N / 2; k++) {
        double end = k == 0 || k == N / 2 ? 0.5 : 1;       /* the middle stands twice */
        folded[0][k] = end * (v[k] + v[N - k]);
        folded[1][k] = end * (v[k] - v[N - k]);
    }
    for (int j = 0; j <= N; j++) {
        double sum = 0;
        for (int k = 0; k <= N / 2; k++)
            sum += folded[j & 1][k] * WAVE[j * k & (2 * N - 1)];
        c[j] = sum * (j == 0 || j == N ? 1.0 : 2.0) / N;
    }
}

/* Clenshaw's sum at u in [-1, 1]. */
static double at(const double *c, double u)
{
    double b1 = 0, b2 = 0;
    for (int j = N; j > 0; j--) {
        double b = c[j] + 2 * u * b1 - b2;
        b2 = b1;
        b1 = b;
    }
    return c[0] + u * b1 - b2;
}

static void derivative(const double *c, double *d)
{
    d[N] = 0;
    for (int j = N; j > 0; j--)
        d[j - 1] = 2 * j * c[j] + (j + 1 <= N ? d[j + 1] : 0);
    d[0] *= 0.5;
}

static double rest(const double *c)
{
    double sum = 0;
    for (int j = 1; j <= N; j++)
        sum += fabs(c[j]);
    return sum;
}

static void add(struct guard_table *t, double theta)
{
    SGA_RESERVE(t->turn, t->turn_room, t->turns + 1);
    t->turn[t->turns++] = theta;
}

static double bisect(const struct piece *p)
{
    double a = -1, b = 1;
    bool up = at(p->c, 1) > 0;
    for (int k = 0; k < BISECTIONS; k++) {
        double u = 0.5 * (a + b);
        *((at(p->c, u) > 0) == up ? &b : &a) = u;
    }
    return p->a + 0.5 * (p->b - p->a) * (1 + b);
}

static void half(const struct piece *p, int side, struct piece *q)
{
    double v[N + 1], middle = 0.5 * (p->a + p->b);
    for (int k = 0; k <= N; k++)
        v[k] = at(p->c, 0.5 * (WAVE[k] + side));
    from_values(v, q->c);
    q->a = side < 0 ? p->a : middle;
    q->b = side < 0 ? middle : p->b;
}

/* Pieces come in order: neighbours are one. */
static void keep(struct guard_table *t, const struct piece *p, int e, double most)
{
    struct guard_quiet *last = t->quiets ? t->quiet + t->quiets - 1 : NULL;
    if (last && last->function == e && last->most == most && last->b == p->a) {
        last->b = p->b;
        return;
    }
    SGA_RESERVE(t->quiet, t->quiet_room, t->quiets + 1);
    t->quiet[t->quiets++] = (struct guard_quiet){ .a = p->a, .b = p->b, .most = most, .function = e };
}

/* Zeros of the derivative of a function whose largest value is `most`; where that is below `noise` all over a piece nothing is
 * seen yet. */
static void isolate(struct guard_table *t, const struct piece *first, int e, double most, double noise)
{
    struct { struct piece p; int depth; } stack[SPLITS + 2];
    int count = 1;
    stack[0].p = *first;
    stack[0].depth = 0;
    while (count > 0) {
        assert(count <= SPLITS + 1);       /* one half waits at each depth */
        struct piece p = stack[--count].p;
        int depth = stack[count].depth;
        double d[N + 1], others = rest(p.c);
        if (fabs(p.c[0]) > others)
            continue;
        if (fabs(p.c[0]) + others <= noise) {
            keep(t, &p, e, most);
            continue;
        }
        derivative(p.c, d);
        if (fabs(d[0]) > rest(d)) {
            if (at(p.c, -1) * at(p.c, 1) <= 0)
                add(t, bisect(&p));
        } else if (depth == SPLITS) {
            add(t, 0.5 * (p.a + p.b));
        } else {
            for (int side = 1; side >= -1; side -= 2, count++) {
                half(&p, side, &stack[count].p);
                stack[count].depth = depth + 1;
            }
        }
    }
}

enum seen { UNRESOLVED, NOT_NEAR, RESOLVED };

static double tail_of(const struct piece *p) { return fabs(p->c[N]) + fabs(p->c[N - 1]) + fabs(p->c[N - 2]); }

/* The function whose values at the Chebyshev points of the piece these are, `noise` being what they are uncertain by. */
static enum seen expand(const double *v, struct piece *p, double noise)
{
    from_values(v, p->c);
    double others = rest(p->c), tail = tail_of(p);
    if (!isfinite(fabs(p->c[0]) + others) || (fabs(p->c[0]) > FAR * others && tail <= CLEAR * others + noise))
        return NOT_NEAR;
    return tail <= noise ? RESOLVED : UNRESOLVED;
}

static void turns_of(struct guard_table *t, const struct piece *p, int e, double most, double noise)
{
    struct piece slope = *p;
    derivative(p->c, slope.c);
    isolate(t, &slope, e, most, N * noise);
}

/* The last coefficients of function e over a piece did not fall with its length, as those of a function do that bends, has a kink or a root in it: they are what its
 * values are uncertain by (1 - (1 - u)). */
static bool is_noise(struct guard_table *t, const struct piece *p, int e, double most)
{
    double tail = tail_of(p), before = t->tail[e];
    t->tail[e] = tail;
    if (!(tail <= LITTLE * most && tail > FALLS * before))
        return false;
    t->noise[e] = fmax(t->noise[e], 2 * tail);
    return true;
}

/* Every function over [a, b]; false: some is not resolved there. */
static bool look(struct guard_table *t, const struct guard_way *way, double a, double b, bool last)
{
    double *v = sga_malloc((N + 1) * (size_t)t->count * sizeof *v);
    bool resolved = true;
    int turns = t->turns, quiets = t->quiets;
    for (int k = 0; k <= N; k++) {
        way->at(way->of, a + 0.5 * (b - a) * (1 + WAVE[k]), t->g);
        for (int e = 0; e < t->count; e++)
            v[e * (N + 1) + k] = t->g[e];
    }
    for (int e = 0; e < t->count && resolved; e++) {
        struct piece p = { .a = a, .b = b };
        double most = fmax(fabs(t->low[e]), fabs(t->high[e]));
        enum seen s = expand(v + e * (N + 1), &p, t->noise[e]);
        resolved = last || s != UNRESOLVED || is_noise(t, &p, e, most);
        if (resolved && s != NOT_NEAR)
            turns_of(t, &p, e, most, t->noise[e]);
    }
    if (!resolved) {
        t->turns = turns;
        t->quiets = quiets;
    }
    free(v);
    return resolved;
}

/* Where all that is seen of a function is below rounding of its largest value: a product of factors that are all small there
 * still has digits of its own (FEW_DIGITS). A sum has none, and is noise; so is the slope at an extreme of higher order, which lies in the middle. */
static void look_again(struct guard_table *t, const struct guard_way *way, struct guard_quiet q)
{
    double v[N + 1], most = 0;
    add(t, 0.5 * (q.a + q.b));
    struct piece p = { .a = q.a, .b = q.b };
    for (int k = 0; k <= N; k++) {
        way->at(way->of, q.a + 0.5 * (q.b - q.a) * (1 + WAVE[k]), t->g);
        v[k] = t->g[q.function];
        most = fmax(most, fabs(v[k]));
    }
    if (most > 0 && most <= CLEAR * q.most && expand(v, &p, FEW_DIGITS * most) == RESOLVED)
        turns_of(t, &p, q.function, most, FEW_DIGITS * most);
}

static int ascending(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

void guard_table_turns(struct guard_table *t, const struct guard_way *way)
{
    double a = 0, width = 1;
    t->turns = t->quiets = 0;
    for (int e = 0; e < t->count; e++)
        t->noise[e] = NOISE * fmax(fabs(t->low[e]), fabs(t->high[e])) + ROUNDINGS * way->grain * (t->high[e] - t->low[e]) + (way->noise ? 2 * way->noise[e] : 0);
    while (a < 1) {
        for (int e = 0; e < t->count; e++)
            t->tail[e] = INFINITY;
        while (!look(t, way, a, a + width, width <= ldexp(1, -HALVINGS)))
            width *= 0.5;
        a += width;
        assert(a <= 1);
        while (width < 1 && fmod(a, 2 * width) == 0)       /* as wide again as the halves before were */
            width *= 2;
    }
    for (int k = 0; k < t->quiets; k++)        /* which may add to them */
        look_again(t, way, t->quiet[k]);
    if (t->turns)
        qsort(t->turn, (size_t)t->turns, sizeof *t->turn, ascending);
}
