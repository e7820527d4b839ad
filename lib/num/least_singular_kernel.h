/* Inside least_singular.c, once for each number type: NUMBER with OF_DOUBLE, ADD, SUB, MUL, DIV, HIGH, and NAME(function). */

/* L D L^T of B B^T - shift I. False: not positive definite, or not seen to be. */
static bool NAME(factor)(const struct lin_gram *g, const struct lin_sparse *B, double shift, NUMBER *L, NUMBER *D, NUMBER *y)
{
    bool positive = true;
    for (int k = 0; k < g->c; k++)
        y[k] = OF_DOUBLE(0);
    for (int k = 0; k < g->c && positive; k++) {
        for (int p = g->from[k]; p < g->from[k + 1]; p++)
            y[g->product[p].j] = ADD(y[g->product[p].j], MUL(OF_DOUBLE(B->val[g->product[p].a]), OF_DOUBLE(B->val[g->product[p].b])));
        NUMBER d = SUB(y[k], OF_DOUBLE(shift));
        y[k] = OF_DOUBLE(0);
        for (int p = g->left[k]; p < g->left[k + 1]; p++) {
            int i = g->at[p], end = g->place[p];
            NUMBER yi = y[i];
            y[i] = OF_DOUBLE(0);
            for (int q = g->column[i]; q < end; q++)
                y[g->row[q]] = SUB(y[g->row[q]], MUL(L[q], yi));
            L[end] = DIV(yi, D[i]);
            d = SUB(d, MUL(L[end], yi));
        }
        D[k] = d;
        positive = HIGH(d) > 0 && HIGH(d) * 0 == 0 && (k % 64 || sga_watch_ok());
    }
    return positive;
}

/* v becomes (L D L^T)^-1 v, in doubles: a direction, no proof. */
static void NAME(solve)(const struct lin_gram *g, const NUMBER *L, const NUMBER *D, double *v)
{
    for (int i = 0; i < g->c; i++)
        for (int q = g->column[i]; q < g->column[i + 1]; q++)
            v[g->row[q]] -= HIGH(L[q]) * v[i];
    for (int i = g->c - 1; i >= 0; i--) {
        v[i] /= HIGH(D[i]);
        for (int q = g->column[i]; q < g->column[i + 1]; q++)
            v[i] -= HIGH(L[q]) * v[g->row[q]];
    }
}

/* A guess of the least eigenvalue by inverse iteration; 0: there is none. */
static double NAME(guess)(struct work *w, NUMBER *L, NUMBER *D, NUMBER *y)
{
    const struct lin_gram *g = w->g;
    double guess = INFINITY;
    if (!NAME(factor)(g, w->B, 0, L, D, y))
        return 0;
    start_vector(g->c, w->v);
    for (int turn = 0; turn < TURNS; turn++) {
        NAME(solve)(g, L, D, w->v);
        double length = norm(g->c, w->v);
        if (!(length > 0 && isfinite(length)))
            return 0;
        guess = fmin(guess, 1 / length);
        for (int i = 0; i < g->c; i++)
            w->v[i] /= length;
    }
    return guess;
}

/* The bound, from a guess that is made smaller until the factor shows it. One of a coarser number is taken where that shows nothing with it. */
static double NAME(bound)(struct work *w, double u)
{
    SGA_ARENA(mem);
    const struct lin_gram *g = w->g;
    size_t c = (size_t)g->c + 1;
    NUMBER *L = sga_take(&mem, ((size_t)g->column[g->c] + 1) * sizeof *L), *D = sga_take(&mem, c * sizeof *D), *y = sga_take(&mem, c * sizeof *y);
    double error = w->rounding * u;
    for (int had = w->guess > 0; had >= 0; had--) {
        if (!had)
            w->guess = NAME(guess)(w, L, D, y);
        for (double shift = w->guess / 4; shift > 4 * error && shift > w->guess / (had ? 64 : INFINITY) && sga_budget_ok(w->budget, NULL); shift /= 16)
            if (NAME(factor)(g, w->B, shift, L, D, y))
                return sqrt(shift - error) * (1 - 0x1p-40);
    }
    return 0;
}
