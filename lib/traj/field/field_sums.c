/* Entries of A that are 0 and do not look it: sums that cancel leave roundings, which would count as a row of the matrix. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "field.h"
#include "mem.h"
#include "system.h"
#include "tape.h"

/* Of what is added up. */
static const double ROUNDING = 1e-14;

enum { PARTS = 40 };

/* The sum of the sizes of what is added up in e, EXPR_UNDEF where it is no sum (times numbers). left: how many sums are still looked
 * into; shared ones are walked over each time. */
static expr_id size_of(struct expr_store *st, expr_id e, int *left)
{
    const struct expr_node n = st->node[e];
    expr_id a, b;
    if ((*left)-- <= 0)
        return EXPR_UNDEF;
    switch ((enum expr_op)n.op) {
    case EXPR_ADD: case EXPR_SUB:
        a = size_of(st, n.a, left);
        b = size_of(st, n.b, left);
        return expr_add(st, a ? a : expr_fun(st, EXPR_ABS, n.a), b ? b : expr_fun(st, EXPR_ABS, n.b));
    case EXPR_NEG:
        return size_of(st, n.a, left);
    case EXPR_MUL:
        a = expr_is_const(st, n.a) ? n.a : n.b;
        b = size_of(st, expr_is_const(st, n.a) ? n.b : n.a, left);
        return expr_is_const(st, a) && b ? expr_mul(st, expr_fun(st, EXPR_ABS, a), b) : EXPR_UNDEF;
    case EXPR_DIV:
        b = expr_is_const(st, n.b) ? size_of(st, n.a, left) : EXPR_UNDEF;
        return b ? expr_div(st, b, expr_fun(st, EXPR_ABS, n.b)) : EXPR_UNDEF;
    default:
        return EXPR_UNDEF;
    }
}

int field_sums_add(struct field *f, expr_id **root, int at)
{
    int place = 0, entries = 0;
    for (int i = 0; i < f->rows; i++)
        entries += f->sys->row[i].entries;
    f->sum = sga_malloc(((size_t)entries + 1) * sizeof *f->sum);
    *root = sga_realloc(*root, ((size_t)(at + entries) + 1) * sizeof **root);
    for (int i = 0; i < f->rows; i++, place++)
        for (int k = 0; k < f->sys->row[i].entries; k++, place++) {
            expr_id e = f->sys->row[i].entry[k].value;
            int left = PARTS;
            expr_id size = expr_is_const(f->sys->store, e) ? EXPR_UNDEF : size_of(f->sys->store, e, &left);
            if (!size)
                continue;
            f->sum[f->sums++] = (struct field_sum){ place, at };
            (*root)[at++] = size;
        }
    assert(at == place + f->rates + f->sums);       /* rates come between */
    return at;
}

bool field_general_values(struct field *f)
{
    double *out = f->general_out;
    if (!num_tape_eval(f->general, f->in, out))
        return false;
    for (int k = 0; k < f->sums; k++)
        if (fabs(out[f->sum[k].entry]) <= ROUNDING * out[f->sum[k].size])
            out[f->sum[k].entry] = 0;
    return true;
}
