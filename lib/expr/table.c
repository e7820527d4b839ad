/* Interpolation of samples by polynomials between them. */
#include "table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"

/* Slopes s at the knots of the spline without knots at the second and the last but one, by
 * elimination in the tridiagonal system that says that second derivatives are continuous. */
static void slopes(int n, const double *h, const double *chord, double *s)
{
    SGA_ARENA(mem);
    double *diagonal = sga_take(&mem, (size_t)n * sizeof *diagonal), *upper = sga_take(&mem, (size_t)n * sizeof *upper);
    double a = h[0] + h[1], b = h[n - 2] + h[n - 3];
    diagonal[0] = h[1];
    upper[0] = a;
    s[0] = ((h[0] + 2 * a) * h[1] * chord[0] + h[0] * h[0] * chord[1]) / a;
    for (int i = 1; i < n; i++) {
        bool last = i == n - 1;
        double lower = last ? b : h[i], f = lower / diagonal[i - 1];
        double right = last ? (h[i - 1] * h[i - 1] * chord[i - 2] + (2 * b + h[i - 1]) * h[i - 2] * chord[i - 1]) / b
                            : 3 * (h[i] * chord[i - 1] + h[i - 1] * chord[i]);
        diagonal[i] = (last ? h[i - 2] : 2 * (h[i - 1] + h[i])) - f * upper[i - 1];
        upper[i] = last ? 0 : h[i - 1];
        s[i] = right - f * s[i - 1];
    }
    for (int i = n - 1; i >= 0; i--)
        s[i] = (s[i] - (i < n - 1 ? upper[i] * s[i + 1] : 0)) / diagonal[i];
}

/* Of the parabola through three knots. */
static void three_slopes(const double *h, const double *chord, double *s)
{
    double curve = (chord[1] - chord[0]) / (h[0] + h[1]);
    s[0] = chord[0] - curve * h[0];
    s[1] = chord[0] + curve * h[0];
    s[2] = chord[1] + curve * h[1];
}

/* The pieces between n samples without a step, from the one with this index. */
static void fill_pieces(struct expr_table *u, enum expr_interpolation kind, int first, int n, const double *value)
{
    const double *time = u->time + first;
    double (*piece)[4] = u->piece + first;
    SGA_FREED double *h = sga_malloc(3 * (size_t)n * sizeof *h);
    double *chord = h + n, *s = chord + n;
    for (int i = 0; i + 1 < n; i++) {
        h[i] = time[i + 1] - time[i];
        chord[i] = (value[first + i + 1] - value[first + i]) / h[i];
        piece[i][0] = value[first + i];
        piece[i][1] = chord[i];
    }
    bool curved = kind == EXPR_CUBIC && n > 2;
    if (curved && n == 3)
        three_slopes(h, chord, s);
    else if (curved)
        slopes(n, h, chord, s);
    for (int i = 0; curved && i + 1 < n; i++) {
        double bend = (s[i] + s[i + 1] - 2 * chord[i]) / h[i];
        piece[i][1] = s[i];
        piece[i][2] = (chord[i] - s[i]) / h[i] - bend;
        piece[i][3] = bend / h[i];
    }
}

struct expr_table *expr_table_new(enum expr_interpolation kind, int n, const double *time, const double *value)
{
    struct expr_table *u = sga_calloc(1, sizeof *u);
    *u = (struct expr_table){ .kind = kind, .knots = n, .at = -1 };
    u->time = memcpy(sga_malloc((size_t)n * sizeof *u->time), time, (size_t)n * sizeof *u->time);
    u->piece = sga_calloc((size_t)n, sizeof *u->piece);
    for (int from = 0, to; from < n; from = to) {      /* steps end one function and begin another one */
        for (to = from + 1; to < n && time[to] > time[to - 1]; to++)
            ;
        fill_pieces(u, kind, from, to - from, value);
        u->piece[to - 1][0] = value[to - 1];       /* of the step itself, which has no length */
        u->steps += to < n;
    }
    return u;
}

void expr_table_free(struct expr_table *u)
{
    if (!u)
        return;
    if (u->knot)
        _fmpq_vec_clear(u->knot, u->knots);
    free(u->given);
    free(u->fine);
    free(u->time);
    free(u->piece);
    free(u);
}

void expr_table_given(struct expr_table *u, const struct expr_store *st, const expr_id *time, const expr_id *value)
{
    if (!time && !value)
        return;
    size_t n = (size_t)u->knots;
    u->store = st;
    u->given = sga_calloc(2 * n, sizeof *u->given);
    if (time)
        memcpy(u->given, time, n * sizeof *time);
    if (value)
        memcpy(u->given + n, value, n * sizeof *value);
}

int expr_table_interval(const struct expr_table *u, double t)
{
    int low = 0, high = u->knots - 1;
    while (high - low > 1) {
        int middle = low + (high - low) / 2;
        if (u->time[middle] <= t)
            low = middle;
        else
            high = middle;
    }
    return low;
}

int expr_table_interval_exact(const struct expr_table *u, const fmpq_t t)
{
    int low = 0, high = u->knots - 1;
    while (high - low > 1) {
        int middle = low + (high - low) / 2;
        *(fmpq_cmp(u->knot + middle, t) <= 0 ? &low : &high) = middle;
    }
    return low;
}

double expr_table_value(const struct expr_table *u, int order, double t)
{
    int k = u->at;
    if (k < 0 && !(t >= u->time[0] && t <= u->time[u->knots - 1]))
        return NAN;
    if (k < 0)
        k = expr_table_interval(u, t);
    const double *c = u->piece[k], x = t - u->time[k];
    switch (order) {
    case 0:  return c[0] + x * (c[1] + x * (c[2] + x * c[3]));
    case 1:  return c[1] + x * (2 * c[2] + x * 3 * c[3]);
    case 2:  return 2 * c[2] + 6 * c[3] * x;
    case 3:  return 6 * c[3];
    default: return 0;
    }
}

int expr_table_smooth(const struct expr_table *u)
{
    return u->steps ? -1 : u->kind == EXPR_LINEAR ? 0 : 2;
}
