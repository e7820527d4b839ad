/* Products for the printer: MUL, DIV, NEG and negative powers flattened into a sign, a
 * rational coefficient, and factors above and below the line.
 *
 * Nothing here changes where an expression is defined: a quotient that is divided by
 * stays in one piece, because a/(b/c) has no value at c = 0 and a*c/b has. */
#include "print_text.h"

#include <stdlib.h>

#include "arena.h"
#include "mem.h"

void print_product_init(struct print_product *p)
{
    *p = (struct print_product){ 0 };
    fmpq_init(p->coefficient);
}

void print_product_clear(struct print_product *p)
{
    fmpq_clear(p->coefficient);
    free(p->factor);
    free(p->work);
}

static void put_factor(struct print_product *p, expr_id e, int power, bool below)
{
    SGA_RESERVE(p->factor, p->cap, p->count + 1);
    p->factor[p->count++] = (struct print_factor){ e, power, below };
}

/* Takes e apart one level. Returns how many parts were put on the work stack at top. */
static int split(struct print_product *p, const struct expr_store *st, struct print_work w, size_t top)
{
    struct expr_node n = st->node[w.e];
    SGA_RESERVE(p->work, p->work_cap, top + 2);
    switch ((enum expr_op)n.op) {
    case EXPR_CONST:
        if (w.below)
            fmpq_div(p->coefficient, p->coefficient, st->constant + n.a);
        else
            fmpq_mul(p->coefficient, p->coefficient, st->constant + n.a);
        return 0;
    case EXPR_NEG:
        p->negative = !p->negative;
        p->work[top] = (struct print_work){ n.a, w.below };
        return 1;
    case EXPR_MUL:
        p->work[top] = (struct print_work){ n.b, w.below };
        p->work[top + 1] = (struct print_work){ n.a, w.below };
        return 2;
    case EXPR_DIV:
        if (w.below)
            break;
        p->work[top] = (struct print_work){ n.b, true };
        p->work[top + 1] = (struct print_work){ n.a, false };
        return 2;
    case EXPR_POWI:
        if (n.b >= 0 || w.below)
            break;
        put_factor(p, n.a, -n.b, true);
        return 0;
    default:
        break;
    }
    put_factor(p, w.e, 1, w.below);
    return 0;
}

bool print_product_of(struct print_product *p, const struct print_request *r, expr_id top, expr_id e, size_t max_factors)
{
    p->count = 0;
    p->negative = false;
    fmpq_set_si(p->coefficient, 1, 1);
    SGA_RESERVE(p->work, p->work_cap, 2);
    p->work[0] = (struct print_work){ e, false };
    size_t parts = 0;
    for (size_t n = 1; n > 0;) {
        struct print_work w = p->work[--n];
        if (++parts > max_factors)
            return false;
        if (r->name && r->name[w.e] && w.e != top)
            put_factor(p, w.e, 1, w.below);
        else
            n += (size_t)split(p, r->st, w, n);
    }
    if (fmpq_sgn(p->coefficient) < 0) {
        fmpq_neg(p->coefficient, p->coefficient);
        p->negative = !p->negative;
    }
    return true;
}

/* What a power is a power of, for sorting. */
static expr_id base_of(const struct expr_store *st, expr_id e)
{
    enum expr_op op = expr_op_of(st, e);
    return op == EXPR_POWI || op == EXPR_POW ? st->node[e].a : e;
}

/* Numbers, pi, parameters, other symbols, functions, sums. */
static int rank(const struct expr_store *st, expr_id e)
{
    switch (expr_op_of(st, e)) {
    case EXPR_CONST: return 0;
    case EXPR_PI:    return 1;
    case EXPR_SYM:   return st->symbol[st->node[e].a].kind == EXPR_PARAMETER ? 2 : 3;
    case EXPR_ADD: case EXPR_SUB: case EXPR_MUL: case EXPR_DIV: return 5;
    default:         return 4;
    }
}

static bool before(const struct expr_store *st, const struct print_factor *x, const struct print_factor *y)
{
    if (x->below != y->below)
        return y->below;
    expr_id a = base_of(st, x->e), b = base_of(st, y->e);
    int ra = rank(st, a), rb = rank(st, b);
    return ra != rb ? ra < rb : a < b;
}

/* Merge sort from runs of one: stable, and quick on products of any length. */
void print_product_sort(struct print_product *p, const struct expr_store *st)
{
    size_t n = (size_t)p->count;
    if (n < 2)
        return;
    SGA_FREED struct print_factor *other = sga_malloc(n * sizeof *other);
    for (size_t run = 1; run < n; run *= 2) {
        for (size_t low = 0; low < n; low += 2 * run) {
            size_t mid = low + run < n ? low + run : n, high = low + 2 * run < n ? low + 2 * run : n;
            for (size_t i = low, j = mid, k = low; k < high; k++)
                other[k] = i < mid && (j >= high || !before(st, p->factor + j, p->factor + i))
                    ? p->factor[i++] : p->factor[j++];
        }
        for (size_t k = 0; k < n; k++)
            p->factor[k] = other[k];
    }
}

void print_product_degrees(const struct print_product *p, const struct expr_store *st, long *variables, long *all)
{
    *variables = *all = 0;
    for (int i = 0; i < p->count; i++) {
        const struct print_factor *f = p->factor + i;
        expr_id b = base_of(st, f->e);
        long n = expr_op_of(st, f->e) == EXPR_POWI ? st->node[f->e].b : 1;
        n *= f->below ? -f->power : f->power;
        *all += n;
        if (rank(st, b) > 2)
            *variables += n;
    }
}
