/* The staircase modulo a prime, in system form.
 *
 * Row operations make A = [I F; 0 0] and the change of unknowns z = x_P + F x_N makes it
 * [I 0; 0 0]: the pencil is then x' = T x + G u, 0 = S x + D u (Rosenbrock's system matrix), u the
 * kernel of A. One step deflates all of u:
 *  1. Rows 0 = S x + D u with a pivot in D are solved for it: row and column of u go.
 *  2. The others of u stand in x' = T x + G u only. Rows with a pivot in G go, and their x_i
 *     become the next u: elimination adds multiples of row i to rows j, so A's rows become
 *     e_j - c_ji e_i, and z_j = x_j - c_ji x_i makes them e_j again; column i of T and S gains c_ji times
 *     column j.
 * Steps are counted by (columns of u, rank of [G; D]). Without u left the transposed pencil is
 * x' = T^T x + S^T u and has no equations 0 = .. at all; its staircase gives the left indices, and
 * the finite part stays. Each pivot costs one update of the matrix, so all steps together are cubic. */
#include "staircase.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "mem.h"

/* rows x cols, a pointer for each row so that rows go without copying. */
struct grid {
    int rows, cols;
    mp_limb_t **row, *data;
};

static void grid_init(struct grid *g, int rows, int cols)
{
    g->rows = rows;
    g->cols = cols;
    g->data = sga_calloc((size_t)rows * (size_t)cols + 1, sizeof *g->data);
    g->row = sga_calloc((size_t)rows + 1, sizeof *g->row);
    for (int i = 0; i < rows; i++)
        g->row[i] = g->data + (size_t)i * (size_t)cols;
}

static void grid_clear(struct grid *g)
{
    free(g->row);
    free(g->data);
    *g = (struct grid){ 0 };
}

/* x' = T x + G u in the first q rows, 0 = S x + D u in the other s; columns: q of x, k of u. */
struct plant {
    struct grid m;
    int q, s, k;
    mp_limb_t p;
    double work;
};

/* y -= c x */
static void subtract(mp_limb_t *y, const mp_limb_t *x, int n, mp_limb_t c, mp_limb_t p)
{
    mp_limb_t w = n_mulmod_precomp_shoup(c, p);
    for (int i = 0; i < n; i++)
        if (x[i])
            y[i] = n_submod(y[i], n_mulmod_shoup(c, x[i], w, p), p);
}

static void scale(mp_limb_t *x, int n, mp_limb_t c, mp_limb_t p)
{
    mp_limb_t w = n_mulmod_precomp_shoup(c, p);
    for (int i = 0; i < n; i++)
        if (x[i])
            x[i] = n_mulmod_shoup(c, x[i], w, p);
}

static int weight(const mp_limb_t *x, int n)
{
    int w = 0;
    for (int i = 0; i < n; i++)
        w += x[i] != 0;
    return w;
}

/* [A | B] with A in reduced echelon form, in place; pivot[i] is the column of row i. The row with
 * the fewest entries is the pivot: circuits stay sparse. Returns the rank of A. */
static int echelon(struct grid *ab, int cols, int *pivot, mp_limb_t p, double *work,
                   const struct sga_budget *budget, struct sga_error *err)
{
    int rank = 0;
    for (int c = 0; c < cols && rank < ab->rows; c++) {
        int best = -1, least = 0;
        if (budget && !sga_budget_ok(budget, err))
            return -1;
        for (int i = rank; i < ab->rows; i++) {
            int w = ab->row[i][c] ? weight(ab->row[i], ab->cols) : 0;
            if (w && (best < 0 || w < least)) {
                best = i;
                least = w;
            }
        }
        if (best < 0)
            continue;
        mp_limb_t *t = ab->row[best];
        ab->row[best] = ab->row[rank];
        ab->row[rank] = t;
        scale(t + c, ab->cols - c, n_invmod(t[c], p), p);
        for (int i = 0; i < ab->rows; i++) {
            if (i == rank || !ab->row[i][c])
                continue;
            subtract(ab->row[i] + c, t + c, ab->cols - c, ab->row[i][c], p);
            *work += ab->cols - c;
        }
        pivot[rank++] = c;
    }
    return rank;
}

/* From the echelon form: columns of B in the order pivots, then the others less F times the pivots. */
static void to_plant(const struct grid *ab, int n, const int *pivot, int rank, struct plant *g)
{
    SGA_FREED char *is_pivot = sga_calloc((size_t)n + 1, 1);
    int u = rank;
    g->q = rank;
    g->s = ab->rows - rank;
    g->k = n - rank;
    grid_init(&g->m, ab->rows, n);
    for (int t = 0; t < rank; t++) {
        is_pivot[pivot[t]] = 1;
        for (int i = 0; i < ab->rows; i++)
            g->m.row[i][t] = ab->row[i][n + pivot[t]];
    }
    for (int c = 0; c < n; c++) {
        if (is_pivot[c])
            continue;
        for (int i = 0; i < ab->rows; i++)
            g->m.row[i][u] = ab->row[i][n + c];
        for (int t = 0; t < rank; t++) {
            mp_limb_t f = ab->row[t][c];
            if (!f)
                continue;
            mp_limb_t w = n_mulmod_precomp_shoup(f, g->p);
            for (int i = 0; i < ab->rows; i++)
                g->m.row[i][u] = n_submod(g->m.row[i][u], n_mulmod_shoup(f, g->m.row[i][t], w, g->p), g->p);
            g->work += ab->rows;
        }
        u++;
    }
}

static bool start(const struct integral *p, struct plant *g, const struct sga_budget *budget, struct sga_error *err)
{
    SGA_ENDS(grid_clear) struct grid ab;
    SGA_FREED int *pivot = sga_calloc((size_t)p->cols + 1, sizeof *pivot);
    grid_init(&ab, p->rows, 2 * p->cols);
    for (int i = 0; i < p->entries; i++)
        ab.row[p->entry[i].row][p->entry[i].col + (p->entry[i].b ? p->cols : 0)] = fmpz_fdiv_ui(&p->entry[i].value, g->p);
    int rank = echelon(&ab, p->cols, pivot, g->p, &g->work, budget, err);
    if (rank >= 0)
        to_plant(&ab, p->cols, pivot, rank, g);
    return rank >= 0;
}

/* The step's elimination. w: the plant's rows with k more columns for the coefficients c_ji (by
 * place of the pivot). gone[i]: row i was a pivot. place[t]: the row of the t-th pivot above. */
struct elimination {
    struct grid w;
    char *gone;
    int *place;
    int above, below;              /* pivots among x' = .. and among 0 = .. */
};

static int find_pivot(const struct elimination *e, int from, int to, int col)
{
    int best = -1, least = 0;
    for (int i = from; i < to; i++) {
        if (e->gone[i] || !e->w.row[i][col])
            continue;
        int w = weight(e->w.row[i], e->w.cols);
        if (best < 0 || w < least) {
            best = i;
            least = w;
        }
    }
    return best;
}

static void eliminate(struct plant *g, struct elimination *e, int row, int col)
{
    mp_limb_t *t = e->w.row[row], inverse = n_invmod(t[col], g->p);
    e->gone[row] = 1;
    for (int i = 0; i < e->w.rows; i++) {
        if (e->gone[i] || !e->w.row[i][col])
            continue;
        subtract(e->w.row[i], t, e->w.cols, n_mulmod2(e->w.row[i][col], inverse, g->p), g->p);
        g->work += e->w.cols;
    }
}

static void pivots(struct plant *g, struct elimination *e)
{
    int n = g->q + g->k, rows = g->q + g->s;
    SGA_FREED char *done = sga_calloc((size_t)g->k + 1, 1);
    for (int c = 0; c < g->k; c++) {
        int i = find_pivot(e, g->q, rows, g->q + c);
        if (i < 0)
            continue;
        eliminate(g, e, i, g->q + c);
        done[c] = 1;
        e->below++;
    }
    for (int c = 0; c < g->k; c++) {
        int i = done[c] ? -1 : find_pivot(e, 0, g->q, g->q + c);
        if (i < 0)
            continue;
        e->w.row[i][n + e->above] = g->p - 1;      /* A's row is e_i: the coefficient of a pivot is -1 */
        e->place[e->above++] = i;
        eliminate(g, e, i, g->q + c);
    }
}

/* What is left, in the new coordinates. */
static void compact(struct plant *g, const struct elimination *e)
{
    int q = g->q - e->above, s = g->s - e->below, n = g->q + g->k, to = 0;
    SGA_FREED int *keep = sga_calloc((size_t)q + 1, sizeof *keep);
    struct grid m;
    for (int i = 0, j = 0; i < g->q; i++)
        if (!e->gone[i])
            keep[j++] = i;
    grid_init(&m, q + s, q + e->above);
    for (int i = 0; i < e->w.rows; i++) {
        if (e->gone[i])
            continue;
        const mp_limb_t *from = e->w.row[i];
        mp_limb_t *row = m.row[to++];
        for (int j = 0; j < q; j++)
            row[j] = from[keep[j]];
        for (int t = 0; t < e->above; t++)
            row[q + t] = from[e->place[t]];
        for (int j = 0; j < q && e->above; j++) {
            if (!row[j])
                continue;
            mp_limb_t w = n_mulmod_precomp_shoup(row[j], g->p);
            const mp_limb_t *c = e->w.row[keep[j]] + n;
            for (int t = 0; t < e->above; t++)
                row[q + t] = n_addmod(row[q + t], n_mulmod_shoup(row[j], c[t], w, g->p), g->p);
            g->work += e->above;
        }
    }
    grid_clear(&g->m);
    g->m = m;
    g->q = q;
    g->s = s;
    g->k = e->above;
}

static void step(struct plant *g, struct staircase *out)
{
    SGA_ARENA(mem);
    struct elimination e = { .above = 0 };
    int rows = g->q + g->s, n = g->q + g->k;
    grid_init(&e.w, rows, n + g->k);
    for (int i = 0; i < rows; i++)
        memcpy(e.w.row[i], g->m.row[i], (size_t)n * sizeof **e.w.row);
    e.gone = sga_zeros(&mem, (size_t)rows + 1, 1);
    e.place = sga_zeros(&mem, (size_t)g->k + 1, sizeof *e.place);
    pivots(g, &e);
    SGA_RESERVE(out->nullity, out->nullity_cap, (size_t)out->steps + 1);
    SGA_RESERVE(out->rank, out->rank_cap, (size_t)out->steps + 1);
    out->nullity[out->steps] = g->k;
    out->rank[out->steps++] = e.above + e.below;
    compact(g, &e);
    g->work += (double)rows * n;
    grid_clear(&e.w);
}

static bool deflate(struct plant *g, struct staircase *out, const struct sga_budget *budget, struct sga_error *err)
{
    while (g->k) {
        if (budget && !sga_budget_ok(budget, err))
            return false;
        step(g, out);
    }
    return true;
}

/* x' = T x, 0 = S x becomes x' = T^T x + S^T u. */
static void transpose(struct plant *g)
{
    struct grid m;
    grid_init(&m, g->q, g->q + g->s);
    for (int i = 0; i < g->q + g->s; i++)
        for (int j = 0; j < g->q; j++)
            m.row[j][i] = g->m.row[i][j];
    grid_clear(&g->m);
    g->m = m;
    g->k = g->s;
    g->s = 0;
}

bool structure_mod(const struct integral *p, mp_limb_t prime, struct structure_mod *m,
                   const struct sga_budget *budget, struct sga_error *err)
{
    struct plant g = { .p = prime };
    *m = (struct structure_mod){ .work = 0 };
    bool ok = start(p, &g, budget, err) && deflate(&g, &m->right, budget, err);
    if (ok) {
        transpose(&g);
        ok = deflate(&g, &m->left, budget, err);
    }
    nmod_mat_init(m->finite, ok ? g.q : 0, ok ? g.q : 0, prime);
    for (int i = 0; ok && i < g.q; i++)
        memcpy(m->finite->rows[i], g.m.row[i], (size_t)g.q * sizeof **m->finite->rows);
    m->work = g.work;
    grid_clear(&g.m);
    if (!ok)
        structure_mod_clear(m);
    return ok;
}

void structure_mod_clear(struct structure_mod *m)
{
    free(m->right.nullity);
    free(m->right.rank);
    free(m->left.nullity);
    free(m->left.rank);
    nmod_mat_clear(m->finite);
    *m = (struct structure_mod){ .work = 0 };
}

/* Both sequences fall as fast as they can in the generic structure. */
static int compare(const struct staircase *a, const struct staircase *b)
{
    for (int k = 0; k < a->steps || k < b->steps; k++) {
        int na = k < a->steps ? a->nullity[k] : 0, nb = k < b->steps ? b->nullity[k] : 0;
        int ra = k < a->steps ? a->rank[k] : 0, rb = k < b->steps ? b->rank[k] : 0;
        assert(na >= ra && nb >= rb);
        if (na != nb)
            return na < nb ? -1 : 1;
        if (ra != rb)
            return ra > rb ? -1 : 1;
    }
    return 0;
}

int structure_mod_compare(const struct structure_mod *a, const struct structure_mod *b)
{
    int c = compare(&a->right, &b->right);
    return c ? c : compare(&a->left, &b->left);
}
