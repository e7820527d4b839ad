/* Rows modulo a prime in echelon form, kept by pivot column. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "sym_work.h"

void sym_space_init(struct sym_space *s, int cols, nmod_t mod)
{
    *s = (struct sym_space){ .cols = cols, .mod = mod, .row = sga_calloc((size_t)cols + 1, sizeof *s->row) };
}

void sym_space_clear(struct sym_space *s)
{
    for (int j = 0; j < s->cols && s->row; j++)
        free(s->row[j]);
    free(s->row);
    *s = (struct sym_space){ 0 };
}

static void subtract(const struct sym_space *s, mp_limb_t *v, int col, int from)
{
    _nmod_vec_scalar_addmul_nmod(v + from, s->row[col] + from, s->cols - from, nmod_neg(v[col], s->mod), s->mod);
}

void sym_space_reduce(const struct sym_space *s, mp_limb_t *v)
{
    for (int j = 0; j < s->cols; j++)
        if (v[j] && s->row[j])
            subtract(s, v, j, j);
}

bool sym_space_insert(struct sym_space *s, mp_limb_t *v)
{
    for (int j = 0; j < s->cols; j++) {
        if (!v[j])
            continue;
        if (s->row[j]) {
            subtract(s, v, j, j);
            continue;
        }
        s->row[j] = sga_calloc((size_t)s->cols, sizeof **s->row);
        _nmod_vec_scalar_mul_nmod(s->row[j] + j, v + j, s->cols - j, nmod_inv(v[j], s->mod), s->mod);
        s->rank++;
        return true;
    }
    return false;
}

bool sym_space_sane(const struct sym_space *s)
{
    int rank = 0;
    bool sane = true;
    for (int j = 0; j < s->cols && sane; j++) {
        rank += s->row[j] != NULL;
        sane = !s->row[j] || s->row[j][j] == 1;
    }
    return sane && rank == s->rank;
}

void sym_space_finish(struct sym_space *s)
{
    for (int j = s->cols - 1; j >= 0; j--)
        for (int k = j + 1; k < s->cols && s->row[j]; k++)
            if (s->row[k] && s->row[j][k])
                subtract(s, s->row[j], k, k);
    assert(sym_space_sane(s));
}

void sym_space_kernel(const struct sym_space *s, struct sym_space *out)
{
    assert(sym_space_sane(s));
    SGA_FREED mp_limb_t *v = sga_malloc(((size_t)s->cols + 1) * sizeof *v);
    sym_space_init(out, s->cols, s->mod);
    for (int f = 0; f < s->cols; f++) {
        if (s->row[f])
            continue;
        memset(v, 0, (size_t)s->cols * sizeof *v);
        v[f] = 1;
        for (int j = 0; j < f; j++)
            if (s->row[j])
                v[j] = nmod_neg(s->row[j][f], s->mod);
        sym_space_insert(out, v);
    }
    sym_space_finish(out);
    assert(sym_space_sane(out) && out->rank == s->cols - s->rank);
}
