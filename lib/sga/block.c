/* Dense blocks: pivots by value, solutions as SOLVE nodes. */
#include "block_parts.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "ball_matrix.h"
#include "budget.h"
#include "expr_rows.h"
#include "least_singular.h"
#include "lin_sparse.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "points_random.h"
#include "seeds.h"
#include "sparse.h"
#include "system.h"

/* Of a row's entries in doubles: what is left below this part is taken for none. */
static const double NOTHING = 1e-10;

static void gather(struct block *b, const struct echelon *e, const struct ech_row *row, const int *index, int m)
{
    SGA_FREED int *place = sga_malloc((size_t)e->cols * sizeof *place);
    *b = (struct block){ .m = m };
    b->col = sga_malloc((size_t)e->cols * sizeof *b->col);
    for (int j = 0; j < e->cols; j++)
        place[j] = -1;
    for (int i = 0; i < m; i++)
        for (int k = 0; k < row[index[i]].entries; k++) {
            int j = row[index[i]].entry[k].col;
            if (place[j] < 0) {
                place[j] = b->n;
                b->col[b->n++] = j;
            }
        }
    int entries = 0;
    for (int i = 0; i < m; i++)
        entries += row[index[i]].entries;
    b->at = expr_rows_new(m, entries);
    entries = 0;
    for (int i = 0; i < m; i++) {
        for (int k = 0; k < row[index[i]].entries; k++) {
            b->at.column[entries] = place[row[index[i]].entry[k].col];
            b->at.entry[entries++] = row[index[i]].entry[k].value;
        }
        b->at.start[i + 1] = entries;
    }
    expr_rows_sort(&b->at, m, b->n);
    b->rows = sga_malloc((size_t)m * sizeof *b->rows);
    b->cols = sga_malloc((size_t)m * sizeof *b->cols);
    b->row_used = sga_calloc((size_t)m, 1);
    b->col_used = sga_calloc((size_t)b->n, 1);
}

/* The pivots of an elimination in doubles, in their order. */
static struct lin_sparse *pivots_of(struct block *b, const struct lin_sparse *B)
{
    struct points_row *row = sga_calloc((size_t)b->m + 1, sizeof *row);
    for (int i = 0; i < b->m; i++) {
        int len = row[i].len = row[i].cap = B->ptr[i + 1] - B->ptr[i];
        row[i].col = memcpy(sga_malloc(((size_t)len + 1) * sizeof(int)), B->col + B->ptr[i], (size_t)len * sizeof(int));
        row[i].val = memcpy(sga_malloc(((size_t)len + 1) * sizeof(double)), B->val + B->ptr[i], (size_t)len * sizeof(double));
    }
    struct points_lu lu;
    points_lu_factor(&lu, row, b->m, b->n, NOTHING);
    SGA_ARENA(mem);
    int *place = sga_zeros(&mem, (size_t)b->n + 1, sizeof *place), *ptr = sga_zeros(&mem, (size_t)lu.rank + 1, sizeof *ptr), count = 0;
    int *col = sga_take(&mem, ((size_t)B->ptr[b->m] + 1) * sizeof *col);
    double *value = sga_take(&mem, ((size_t)B->ptr[b->m] + 1) * sizeof *value);
    for (int k = 0; k < lu.rank; k++)
        place[lu.pivot_col[k]] = k + 1;
    for (int k = 0; k < lu.rank; k++) {
        int i = b->rows[k] = lu.pivot_row[k];
        b->cols[k] = lu.pivot_col[k];
        for (int q = B->ptr[i]; q < B->ptr[i + 1]; q++)
            if (place[B->col[q]]) {
                col[count] = place[B->col[q]] - 1;
                value[count++] = B->val[q];
            }
        ptr[k + 1] = count;
    }
    struct lin_sparse *S = lin_sparse_new(lu.rank, lu.rank, ptr, col);
    memcpy(S->val, value, (size_t)count * sizeof *value);
    points_lu_clear(&lu);
    return S;
}

/* Of a large sparse block: pivots in doubles, and a proof that these rows and columns are regular at the first point, so in general. A row that depends
 * on them in doubles alone is no loss: rewrite looks at what is left of it. False: no proof, fewer than `least`, or not a large sparse one; b is as it was. */
static bool choose_sparse(struct block *b, const struct ech_context *c, int least)
{
    struct num_ball_matrix v;
    bool ok = num_ball_matrix_init(&v, &c->oracle->real[0].ball, b->m, b->n, &b->at);
    if (ok && b->m == b->n && num_least_singular(v.B, c->budget) > v.error * (1 + 1e-9)) {
        b->rank = b->m;
        for (int k = 0; k < b->rank; k++)
            b->rows[k] = b->cols[k] = k;
    } else if (ok) {
        struct lin_sparse *S = pivots_of(b, v.B);
        ok = S->rows >= least && num_least_singular(S, c->budget) > v.error * (1 + 1e-9);
        b->rank = ok ? S->rows : 0;
        lin_sparse_free(S);
    }
    num_ball_matrix_clear(&v);
    for (int k = 0; k < b->rank; k++)
        b->row_used[b->rows[k]] = b->col_used[b->cols[k]] = 1;
    return ok;
}

/* Full pivoting on the values in balls at the first point: a pivot ball that excludes 0
 * shows that one more row and column are independent there, so in general. Large sparse ones as above, where that finds `least` pivots. */
static bool choose(struct block *b, const struct ech_context *c, int least)
{
    struct num_ball *ball = &c->oracle->real[0].ball;
    bool ok;
    num_ball_extend(ball);
    if (choose_sparse(b, c, least))
        return true;
    size_t size = (size_t)b->m * (size_t)b->n;
    SGA_ARENA(mem);
    arb_ptr v = arbs_take(&mem, (slong)size);
    SGA_ENDS(arb_end) arb_t f = { 0 };
    for (int i = 0; i < b->m; i++)
        for (int k = b->at.start[i]; k < b->at.start[i + 1]; k++)
            arb_set(v + (size_t)i * (size_t)b->n + (size_t)b->at.column[k], num_ball_value(ball, b->at.entry[k]));
    while ((ok = sga_budget_ok(c->budget, c->err))) {
        int p = -1, q = -1;
        for (int i = 0; i < b->m; i++)
            for (int j = 0; j < b->n && !b->row_used[i]; j++) {
                size_t k = (size_t)i * (size_t)b->n + (size_t)j;
                if (b->col_used[j] || arb_contains_zero(v + k) || !arb_is_finite(v + k))
                    continue;
                if (p < 0 || arf_cmpabs(arb_midref(v + k), arb_midref(v + (size_t)p * (size_t)b->n + (size_t)q)) > 0) {
                    p = i;
                    q = j;
                }
            }
        if (p < 0)
            break;
        b->row_used[p] = b->col_used[q] = 1;
        b->rows[b->rank] = p;
        b->cols[b->rank++] = q;
        arb_srcptr pivot = v + (size_t)p * (size_t)b->n;
        for (int i = 0; i < b->m; i++) {
            arb_ptr r = v + (size_t)i * (size_t)b->n;
            if (b->row_used[i] || arb_is_zero(r + q))
                continue;
            arb_div(f, r + q, pivot + q, ball->prec);
            for (int j = 0; j < b->n; j++)
                if (!b->col_used[j])
                    arb_submul(r + j, f, pivot + j, ball->prec);
        }
    }
    return ok;
}

bool ech_block(struct echelon *e, const struct ech_context *c, struct ech_row *row, const int *index, int rows, int generation)
{
    struct block b;
    gather(&b, e, row, index, rows);
    bool ok = choose(&b, c, 1) && block_rewrite(&b, e, c, row, index, generation);
    free(b.col);
    expr_rows_clear(&b.at);
    free(b.rows);
    free(b.cols);
    free(b.row_used);
    free(b.col_used);
    return ok && expr_store_ok(c->st);
}

/* Numbers without a pattern: -9 to 9, not 0. */
static expr_id border(struct expr_store *st, uint64_t *random)
{
    long v = 1 + (long)(points_random(random) % 9);
    return expr_int(st, points_random(random) & 1 ? v : -v);
}

expr_id ech_block_test(struct expr_store *st, const struct ech_dense *block, int *solve)
{
    int r = block->size, n = r + 1;
    uint64_t random = SGA_SEED_BLOCK;
    const struct expr_rows *S = &block->matrix;
    SGA_ENDS(expr_rows_clear) struct expr_rows T = expr_rows_new(n, S->start[r] + 2 * r);
    SGA_FREED expr_id *w = sga_malloc((size_t)n * sizeof *w);
    int count = 0;
    for (int i = 0; i < n; i++) {
        for (int k = i < r ? S->start[i] : 0; k < (i < r ? S->start[i + 1] : r); k++) {
            T.column[count] = i < r ? S->column[k] : k;
            T.entry[count++] = i < r ? S->entry[k] : border(st, &random);
        }
        if (i < r) {
            T.column[count] = r;
            T.entry[count++] = border(st, &random);
        }
        T.start[i + 1] = count;
        w[i] = expr_int(st, i == r);
    }
    *solve = expr_solve_add_rows(st, n, &T, w);
    return expr_solution(st, *solve, r);
}

bool ech_blocks_stand(const struct echelon *e, struct points_oracle *oracle)
{
    bool stand = true;
    for (int q = 0; q < e->blocks && stand && oracle->reals; q++) {
        int r = e->block[q].size;
        struct block b = { .m = r, .n = r, .at = e->block[q].matrix };
        b.rows = sga_malloc((size_t)r * sizeof *b.rows);
        b.cols = sga_malloc((size_t)r * sizeof *b.cols);
        b.row_used = sga_calloc((size_t)r, 1);
        b.col_used = sga_calloc((size_t)r, 1);
        struct ech_context c = { .oracle = oracle };
        stand = choose(&b, &c, r) && b.rank == r;
        free(b.rows);
        free(b.cols);
        free(b.row_used);
        free(b.col_used);
    }
    return stand;
}
