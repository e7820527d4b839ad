/* Tables in balls: the polynomials that are in use. */
#include "enc_tables.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"

void enc_tables_init(struct enc_tables *t, struct expr_table *const *table, int count)
{
    size_t n = (size_t)count;
    *t = (struct enc_tables){ .count = count, .table = sga_calloc(n + 1, sizeof *t->table), .balls = sga_calloc(n + 1, sizeof *t->balls),
                              .piece = _arb_vec_init((slong)count * NUM_TABLE_PIECE) };
    for (int k = 0; k < count; k++)
        t->table[k] = table[k];
}

static void drop(struct enc_tables *t)
{
    for (int k = 0; k < t->count; k++)
        num_table_balls_clear(t->balls + k);
}

void enc_tables_clear(struct enc_tables *t)
{
    if (!t->table)
        return;
    drop(t);
    _arb_vec_clear(t->piece, (slong)t->count * NUM_TABLE_PIECE);
    free(t->table);
    free(t->balls);
    *t = (struct enc_tables){ 0 };
}

void enc_tables_round(struct enc_tables *t, slong prec)
{
    assert(prec > 1);
    drop(t);
    for (int k = 0; k < t->count; k++)
        num_table_balls_init(t->balls + k, t->table[k], prec);
}

void enc_tables_enter(struct enc_tables *t)
{
    for (int k = 0; k < t->count; k++) {
        assert(t->table[k]->at >= 0 && t->balls[k].value);
        num_table_balls_piece(t->balls + k, t->table[k]->at, t->piece + (size_t)k * NUM_TABLE_PIECE);
    }
}

int enc_tables_find(const struct enc_tables *t, const struct expr_table *u)
{
    int found = -1;
    for (int k = 0; t && k < t->count && found < 0; k++)
        found = t->table[k] == u ? k : -1;
    return found;
}
