/* Values modulo 2^61 - 1 at a point that depends on the symbols' numbers only. */
#include "probe.h"

#include <flint/fmpz.h>
#include <flint/ulong_extras.h>
#include <stdlib.h>

#include "mem.h"

static const uint64_t prime = ((uint64_t)1 << 61) - 1;

static uint64_t mul(uint64_t a, uint64_t b)
{
    unsigned __int128 w = (unsigned __int128)a * b;
    return (uint64_t)(w % prime);
}

static uint64_t power(uint64_t a, uint64_t n)
{
    uint64_t r = 1;
    for (; n; n >>= 1, a = mul(a, a))
        if (n & 1)
            r = mul(r, a);
    return r;
}

/* A value for what has none: mixed from the operator and its arguments' values. */
static uint64_t mix(uint64_t op, uint64_t a, uint64_t b)
{
    uint64_t h = op * 0x9E3779B97F4A7C15u + a * 0xC2B2AE3D27D4EB4Fu + b * 0x165667B19E3779F9u + 1;
    for (int k = 0; k < 3; k++) {
        h ^= h >> 29;
        h *= 0xBF58476D1CE4E5B9u;
        h ^= h >> 32;
    }
    return h % prime;
}

static uint64_t constant(const fmpq *q)
{
    uint64_t n = fmpz_fdiv_ui(fmpq_numref(q), prime), d = fmpz_fdiv_ui(fmpq_denref(q), prime);
    return mul(n, power(d, prime - 2));
}

static uint64_t apply(const struct expr_node *n, uint64_t a, uint64_t b)
{
    switch (n->op) {
    case EXPR_ADD:  return (a + b) % prime;
    case EXPR_SUB:  return (a + prime - b) % prime;
    case EXPR_NEG:  return (prime - a) % prime;
    case EXPR_MUL:  return mul(a, b);
    case EXPR_DIV:  return mul(a, power(b, prime - 2));
    case EXPR_POWI: {
        uint64_t m = (uint64_t)labs((long)n->b), r = power(a, m);
        return n->b < 0 ? power(r, prime - 2) : r;
    }
    default:        return mix(n->op, a, b);
    }
}

void form_probe_init(struct form_probe *p)
{
    *p = (struct form_probe){ 0 };
    expr_cone_init(&p->cone);
}

void form_probe_clear(struct form_probe *p)
{
    expr_cone_clear(&p->cone);
    free(p->value);
}

bool form_probe_zero(struct form_probe *p, const struct expr_store *st, expr_id e)
{
    const struct expr_cone *c = &p->cone;
    expr_cone_of(st, &p->cone, &e, 1);
    expr_cone_index(&p->cone);
    SGA_RESERVE(p->value, p->value_cap, c->count);
    for (int i = 0; i < c->count; i++) {
        const struct expr_node *n = st->node + c->list[i];
        if (n->op == EXPR_CONST) {
            p->value[i] = constant(expr_const_value(st, c->list[i]));
        } else if (n->op == EXPR_SYM || n->op == EXPR_SOLVE) {
            p->value[i] = mix(n->op, (uint64_t)n->a, (uint64_t)n->b);
        } else {
            int args = expr_op_args((enum expr_op)n->op);
            p->value[i] = apply(n, args > 0 ? p->value[c->place[n->a]] : 0, args > 1 ? p->value[c->place[n->b]] : 0);
        }
    }
    return c->count > 0 && p->value[c->count - 1] == 0;
}
