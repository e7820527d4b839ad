/* Random expressions for the tests of evaluation: nodes on top of nodes of a store. */
#ifndef TESTS_UNIT_RANDOM_EXPR_H
#define TESTS_UNIT_RANDOM_EXPR_H

#include <stdint.h>

#include "expr.h"

struct random_source { uint64_t state; };

static inline uint64_t random_next(struct random_source *r)
{
    uint64_t z = (r->state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static inline int random_below(struct random_source *r, int n)
{
    return (int)(random_next(r) % (uint64_t)n);
}

/* In (-1, 1). */
static inline double random_unit(struct random_source *r)
{
    return (double)(int64_t)random_next(r) / 9223372036854775808.0;
}

/* One more rational node over two of pool[0..n). */
static inline expr_id random_rational(struct random_source *r, struct expr_store *st, const expr_id *pool, int n)
{
    expr_id a = pool[random_below(r, n)], b = pool[random_below(r, n)];
    switch (random_below(r, 8)) {
    case 0: case 1: return expr_add(st, a, b);
    case 2: return expr_sub(st, a, b);
    case 3: case 4: return expr_mul(st, a, b);
    case 5: return expr_is_zero(st, b) ? a : expr_div(st, a, b);
    case 6: return expr_is_zero(st, a) ? b : expr_powi(st, a, random_below(r, 9) - 4);
    default: return expr_add(st, expr_neg(st, a), expr_rational(st, 1 + random_below(r, 9), 1 + random_below(r, 7)));
    }
}

#endif
