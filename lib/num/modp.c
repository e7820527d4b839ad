/* Forward evaluation modulo p. */
#include "modp_kernel.h"

#include <flint/fmpq.h>
#include <flint/fmpz.h>
#include <flint/ulong_extras.h>
#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "mem.h"
#include "watch.h"

enum { BATCH = 1 << 12 };      /* nodes between looks at the clock */

/* The least safe primes above 2^60 that are 11 modulo 12, less 2^60: -1 is no square
 * and every residue has one cube root. The unit test proves them. */
static const int prime_offset[NUM_MODP_PRIMES] = {
    2731, 7207, 8647, 10183, 11047, 13591, 15331, 26167, 26407, 27043, 31687, 34963,
    42751, 44683, 51451, 53323, 55963, 56131, 57367, 61051, 61147, 64807, 73291, 75223,
    77863, 81163, 83287, 83851, 93871, 96163, 106123, 109687, 111763, 111907, 112543, 114847,
    117367, 121027, 121111, 121171, 128671, 128767, 134851, 138967, 139423, 141403, 142243, 143503
};

struct num_modp_solution {
    mp_limb_t *y;     /* NULL: not computed */
    uint8_t flags;
};

static void init(struct num_modp *m, const struct expr_store *st, uint64_t seed, mp_limb_t p, int power)
{
    *m = (struct num_modp){ .st = st, .seed = seed, .p = p, .power = power };
    mp_limb_t below = n_pow(p, (ulong)power - 1);
    nmod_init(&m->mod, below * p);
    m->squares = below * ((p - 1) / 2);
}

void num_modp_init(struct num_modp *m, const struct expr_store *st, uint64_t seed, int prime)
{
    assert(prime >= 0 && prime < NUM_MODP_PRIMES);
    init(m, st, seed, (UWORD(1) << 60) + (mp_limb_t)prime_offset[prime], 1);
}

void num_modp_init_power(struct num_modp *m, const struct expr_store *st, uint64_t seed, mp_limb_t p)
{
    int power = 1;
    for (mp_limb_t n = p; n < (UWORD(1) << 63) / p; n *= p)
        power++;
    init(m, st, seed, p, power);
    assert(power >= 1 && power < 64);
}

void num_modp_forget(struct num_modp *m)
{
    for (int i = 0; i < m->solutions; i++)
        free(m->solution[i].y);
    m->solutions = 0;
    m->nodes = 0;
}

void num_modp_clear(struct num_modp *m)
{
    num_modp_forget(m);
    free(m->symbol);
    free(m->value);
    free(m->flags);
    free(m->solution);
    *m = (struct num_modp){ 0 };
}

void num_modp_set(struct num_modp *m, int symbol, mp_limb_t residue)
{
    assert(residue < m->mod.n);
    SGA_RESERVE(m->symbol, m->symbol_cap, symbol + 1);
    while (m->symbols <= symbol)
        m->symbol[m->symbols++] = 0;
    m->symbol[symbol] = residue;
}

static void cover(struct num_modp *m)
{
    SGA_RESERVE(m->value, m->value_cap, m->st->nodes);
    SGA_RESERVE(m->flags, m->flags_cap, m->st->nodes);
    SGA_RESERVE(m->solution, m->solution_cap, m->st->solves);
    while (m->solutions < m->st->solves)
        m->solution[m->solutions++] = (struct num_modp_solution){ .y = NULL };
    if (m->symbols < m->st->symbols)
        num_modp_set(m, m->st->symbols - 1, 0);
}

bool num_modp_fmpq(const struct num_modp *m, const fmpq *q, mp_limb_t *residue)
{
    mp_limb_t n = fmpz_fdiv_ui(fmpq_numref(q), m->mod.n), d = fmpz_fdiv_ui(fmpq_denref(q), m->mod.n);
    *residue = 0;
    if (!num_modp_unit(m, d))
        return false;
    *residue = d == 1 ? n : nmod_mul(n, n_invmod(d, m->mod.n), m->mod);
    assert(*residue < m->mod.n);
    return true;
}

/* a y = r by elimination with pivots that are units; a (n rows of n) and r are overwritten, r by y. */
static bool eliminate(const struct num_modp *m, mp_limb_t **a, mp_limb_t *r, int n)
{
    for (int j = 0; j < n; j++) {
        int k = j;
        while (k < n && !num_modp_unit(m, a[k][j]))
            k++;
        if (k == n)
            return false;
        mp_limb_t *row = a[k], right = r[k], inverse = n_invmod(row[j], m->mod.n);
        a[k] = a[j];
        r[k] = r[j];
        a[j] = row;
        r[j] = nmod_mul(right, inverse, m->mod);
        _nmod_vec_scalar_mul_nmod(row + j, row + j, n - j, inverse, m->mod);
        for (int i = 0; i < n; i++) {
            mp_limb_t f = i == j ? 0 : nmod_neg(a[i][j], m->mod);
            if (!f)
                continue;
            _nmod_vec_scalar_addmul_nmod(a[i] + j, row + j, n - j, f, m->mod);
            r[i] = nmod_add(r[i], nmod_mul(f, r[j], m->mod), m->mod);
        }
    }
    return true;
}

bool num_modp_solve(const struct num_modp *m, mp_limb_t *a, mp_limb_t *r, int n)
{
    SGA_FREED mp_limb_t **row = sga_malloc((size_t)(n + 1) * sizeof *row);
    for (int i = 0; i < n; i++)
        row[i] = a + (size_t)i * (size_t)n;
    return eliminate(m, row, r, n);
}

static void solve(struct num_modp *m, int index)
{
    const struct expr_solve *s = m->st->solve + index;
    struct num_modp_solution *q = m->solution + index;
    SGA_FREED mp_limb_t *a = sga_calloc((size_t)s->m * (size_t)s->m, sizeof *a);
    q->y = sga_calloc((size_t)s->m, sizeof *q->y);
    q->flags = 0;
    for (int i = 0; i < s->m; i++) {
        q->y[i] = m->value[s->rhs[i]];
        q->flags |= m->flags[s->rhs[i]];
        for (int k = s->matrix.start[i]; k < s->matrix.start[i + 1]; k++) {
            a[i * s->m + s->matrix.column[k]] = m->value[s->matrix.entry[k]];
            q->flags |= m->flags[s->matrix.entry[k]];
        }
    }
    if (!(q->flags & NUM_MODP_BAD) && !num_modp_solve(m, a, q->y, s->m))
        q->flags |= NUM_MODP_BAD;
}

static bool divide(const struct num_modp *m, mp_limb_t x, mp_limb_t y, mp_limb_t *r)
{
    bool unit = num_modp_unit(m, y);
    *r = unit ? nmod_mul(x, n_invmod(y, m->mod.n), m->mod) : 0;
    return unit;
}

static bool integer_power(const struct num_modp *m, mp_limb_t x, long n, mp_limb_t *r)
{
    *r = nmod_pow_ui(x, (ulong)labs(n), m->mod);
    return n >= 0 || divide(m, 1, *r, r);
}

/* What an operator adds to the flags of its arguments. */
static uint8_t own_flags(const struct num_modp *m, const struct expr_node *n)
{
    switch ((enum expr_op)n->op) {
    case EXPR_SQRT: return NUM_MODP_BRANCH;
    case EXPR_POW:  return expr_is_const(m->st, n->b) ? NUM_MODP_BRANCH : NUM_MODP_KERNEL;
    case EXPR_PI:   return NUM_MODP_KERNEL;
    default:        return n->op >= EXPR_SIN && n->op <= EXPR_MAX && n->op != EXPR_CBRT ? NUM_MODP_KERNEL : 0;
    }
}

/* The value of a node that has arguments x, y without flaw; false if it has none. */
static bool apply(struct num_modp *m, const struct expr_node *n, mp_limb_t x, mp_limb_t y, mp_limb_t *r)
{
    switch ((enum expr_op)n->op) {
    case EXPR_UNDEF_OP: return false;
    case EXPR_CONST: return num_modp_fmpq(m, m->st->constant + n->a, r);
    case EXPR_PI:   *r = modp_pi(m); return true;
    case EXPR_SYM:  *r = m->symbol[n->a]; return true;
    case EXPR_ADD:  *r = nmod_add(x, y, m->mod); return true;
    case EXPR_SUB:  *r = nmod_sub(x, y, m->mod); return true;
    case EXPR_MUL:  *r = nmod_mul(x, y, m->mod); return true;
    case EXPR_NEG:  *r = nmod_neg(x, m->mod); return true;
    case EXPR_DIV:  return divide(m, x, y, r);
    case EXPR_POWI: return integer_power(m, x, n->b, r);
    case EXPR_POW:
        if (expr_is_const(m->st, n->b))
            return modp_rational_power(m, x, expr_const_value(m->st, n->b), r);
        return modp_kernel(m, EXPR_POW, x, y, r);
    default:
        return modp_kernel(m, (enum expr_op)n->op, x, y, r);
    }
}

static void eval(struct num_modp *m, expr_id e)
{
    const struct expr_node *n = m->st->node + e;
    m->value[e] = 0;
    if (n->op == EXPR_SOLVE) {
        if (!m->solution[n->a].y)
            solve(m, n->a);
        m->value[e] = m->solution[n->a].y[n->b];
        m->flags[e] = m->solution[n->a].flags;
        return;
    }
    int args = expr_op_args((enum expr_op)n->op);
    expr_id a = args > 0 ? n->a : 0, b = args > 1 ? n->b : 0;
    uint8_t flags = own_flags(m, n) | (args > 0 ? m->flags[a] : 0) | (args > 1 ? m->flags[b] : 0);
    mp_limb_t x = args > 0 ? m->value[a] : 0, y = args > 1 ? m->value[b] : 0;
    if ((flags & NUM_MODP_BAD) || !apply(m, n, x, y, m->value + e)) {
        flags |= NUM_MODP_BAD;
        m->value[e] = 0;
    }
    m->flags[e] = flags;
}

void num_modp_extend(struct num_modp *m)
{
    cover(m);
    while (m->nodes < m->st->nodes) {
        int upto = m->st->nodes - m->nodes > BATCH ? m->nodes + BATCH : m->st->nodes;
        sga_watch_count(SGA_COUNT_MODULAR, upto - m->nodes);
        for (; m->nodes < upto; m->nodes++)
            eval(m, m->nodes);
    }
    assert(m->nodes == m->st->nodes);
}

void num_modp_list(struct num_modp *m, const expr_id *list, int count)
{
    cover(m);
    for (int i = 0; i < count; i++)
        if (expr_op_of(m->st, list[i]) == EXPR_SOLVE) {
            struct num_modp_solution *q = m->solution + m->st->node[list[i]].a;
            free(q->y);
            q->y = NULL;
        }
    for (int from = 0; from < count; from += BATCH) {
        int upto = count - from > BATCH ? from + BATCH : count;
        sga_watch_count(SGA_COUNT_MODULAR, upto - from);
        for (int i = from; i < upto; i++)
            eval(m, list[i]);
    }
}
