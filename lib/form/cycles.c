/* The differential of a 2-form, component by component:
 * (d omega)_ijk = d_i omega_jk + d_j omega_ki + d_k omega_ij, for i < j < k. */
#include <stdlib.h>

#include "arena.h"
#include "derive.h"
#include "form.h"
#include "mem.h"

struct piece {
    int i, j, k;               /* increasing */
    expr_id term;
};

static int by_place(const void *a, const void *b)
{
    const struct piece *x = a, *y = b;
    int d = x->i != y->i ? x->i - y->i : x->j != y->j ? x->j - y->j : x->k - y->k;
    return d;
}

static int place_of(const int *variable, int variables, int symbol)
{
    for (int i = 0; i < variables; i++)
        if (variable[i] == symbol)
            return i;
    return -1;
}

/* d_m of entry (r, c), r < c: it stands in the place {m, r, c} with the sign of that order. */
static struct piece place(struct expr_store *st, int m, int r, int c, expr_id value)
{
    if (m < r)
        return (struct piece){ m, r, c, value };
    return m < c ? (struct piece){ r, m, c, expr_neg(st, value) } : (struct piece){ r, c, m, value };
}

bool form_cycles(struct expr_store *st, const int *variable, int variables, const struct form_matrix *omega, int most,
                 struct form_cycle **cycle, int *cycles)
{
    SGA_FREED struct piece *piece = NULL;
    SGA_FREED struct expr_term *term = NULL;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    size_t pieces = 0, cap = 0, term_cap = 0;
    SGA_FREED unsigned char *active = sga_calloc((size_t)st->symbols + 1, 1);
    for (int i = 0; i < variables; i++)
        active[variable[i]] = 1;
    expr_cone_init(&cone);
    for (size_t e = 0; e < omega->entries && pieces <= 3 * (size_t)most; e++) {
        int r = omega->entry[e].row, c = omega->entry[e].col;
        if (r >= c || expr_is_const(st, omega->entry[e].value))
            continue;
        int n = expr_gradient(st, &cone, omega->entry[e].value, active, &term, &term_cap);
        for (int k = 0; k < n; k++) {
            int m = place_of(variable, variables, term[k].symbol);
            if (m == r || m == c)
                continue;
            SGA_RESERVE(piece, cap, pieces + 1);
            piece[pieces++] = place(st, m, r, c, term[k].value);
        }
    }
    if (pieces)
        qsort(piece, pieces, sizeof *piece, by_place);
    *cycle = sga_malloc((pieces + 1) * sizeof **cycle);
    *cycles = 0;
    for (size_t a = 0; a < pieces; a++) {
        if (a && by_place(piece + a, piece + a - 1) == 0) {
            struct form_cycle *last = *cycle + *cycles - 1;
            last->sum = expr_add(st, last->sum, piece[a].term);
        } else {
            (*cycle)[(*cycles)++] = (struct form_cycle){ piece[a].i, piece[a].j, piece[a].k, piece[a].term };
        }
    }
    return pieces <= 3 * (size_t)most;
}
