/* What data tell of the unknowns. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "least_squares.h"
#include "mem.h"

/* Singular values that are no more than so many times the uncertainty of the columns beside the first one say nothing; nor do ones below this. An
 * unknown takes part in a direction if it has so much of it. */
static const double TIMES = 30, LEAST = 1e-10, TAKES_PART = 1e-4;

void fit_spread_of(const struct fit_at *at, int m, int p, struct fit_spread *s)
{
    const double *J = at->J;
    size_t n = (size_t)p;
    *s = (struct fit_spread){ .p = p, .singular = sga_calloc(n + 1, sizeof(double)), .direction = sga_calloc(n * n + 1, sizeof(double)),
                              .covariance = sga_calloc(n * n + 1, sizeof(double)), .told = sga_calloc(n + 1, 1) };
    double *A = sga_calloc((size_t)m * n + 1, sizeof *A), *length = sga_calloc(n + 1, sizeof *length);
    for (size_t j = 0; j < n; j++) {
        for (int i = 0; i < m && !at->bound[j]; i++)
            length[j] = hypot(length[j], J[(size_t)i * n + j]);
        if (length[j] * at->size[j] <= at->noise)
            length[j] = 0;
        for (int i = 0; i < m && length[j] > 0; i++)
            A[(size_t)i * n + j] = J[(size_t)i * n + j] / length[j];
    }
    fit_singular_values(A, m, p, s->singular, s->direction);
    double least = fmax(TIMES * at->unsure, LEAST) * s->singular[0];
    while (s->rank < p && s->singular[s->rank] > least)
        s->rank++;
    for (size_t j = 0; j < n; j++)
        s->told[j] = length[j] > 0;
    for (int k = s->rank; k < p; k++)
        for (size_t j = 0; j < n; j++)
            if (fabs(s->direction[(size_t)k * n + j]) > TAKES_PART)
                s->told[j] = 0;
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < n; b++)
            for (int k = 0; k < s->rank && s->told[a] && s->told[b]; k++) {
                const double *d = s->direction + (size_t)k * n;
                s->covariance[a * n + b] += d[a] * d[b] / (s->singular[k] * s->singular[k]) / (length[a] * length[b]);
            }
    free(A);
    free(length);
}

void fit_spread_clear(struct fit_spread *s)
{
    free(s->singular);
    free(s->direction);
    free(s->covariance);
    free(s->told);
    *s = (struct fit_spread){ 0 };
}
