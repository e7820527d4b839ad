/* Kernels modulo p: generators that depend on the residue of the argument only. */
#include "modp_kernel.h"

#include <flint/fmpq.h>
#include <flint/fmpz.h>
#include <flint/ulong_extras.h>

/* S. Vigna's splitmix64 finaliser, one round */
static uint64_t mix(uint64_t z)
{
    z += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

/* A unit that depends on the seed, the function and its arguments. */
static mp_limb_t generator(const struct num_modp *m, uint64_t op, mp_limb_t x, mp_limb_t y)
{
    uint64_t h = mix(mix(mix(m->seed ^ mix(op)) ^ x) ^ y);
    while (!num_modp_unit(m, h % m->mod.n))
        h = mix(h);
    return h % m->mod.n;
}

mp_limb_t num_modp_random(const struct num_modp *m, uint64_t key)
{
    return mix(mix(m->seed ^ mix(EXPR_OP_COUNT)) ^ key) % m->mod.n;
}

mp_limb_t modp_pi(const struct num_modp *m)
{
    return generator(m, EXPR_PI, 0, 0);
}

static mp_limb_t invert(const struct num_modp *m, mp_limb_t x)
{
    return n_invmod(x, m->mod.n);
}

/* The representative of {x, -x}; *minus says whether it is -x. */
static mp_limb_t up_to_sign(const struct num_modp *m, mp_limb_t x, bool *minus)
{
    mp_limb_t other = nmod_neg(x, m->mod);
    *minus = other < x;
    return *minus ? other : x;
}

/* f(-x) = -f(x), f(0) = 0 */
static mp_limb_t odd(const struct num_modp *m, enum expr_op op, mp_limb_t x)
{
    bool minus;
    if (x == 0)
        return 0;
    x = up_to_sign(m, x, &minus);
    mp_limb_t r = generator(m, op, x, 0);
    if (op == EXPR_ASIN && (x == 1 || x == m->mod.n - 1)) {       /* pi/2 */
        r = nmod_mul(modp_pi(m), (m->mod.n + 1) / 2, m->mod);
        minus ^= x != 1;
    }
    return minus ? nmod_neg(r, m->mod) : r;
}

/* sin = 2t/(1+t^2), cos = (1-t^2)/(1+t^2); -1 is no square here, so 1+t^2 != 0 */
static void sine_cosine(const struct num_modp *m, mp_limb_t x, mp_limb_t *s, mp_limb_t *c)
{
    mp_limb_t t = odd(m, EXPR_SIN, x), tt = nmod_mul(t, t, m->mod);
    mp_limb_t d = invert(m, nmod_add(1, tt, m->mod));
    *s = nmod_mul(nmod_add(t, t, m->mod), d, m->mod);
    *c = nmod_mul(nmod_sub(1, tt, m->mod), d, m->mod);
}

static mp_limb_t exponential(const struct num_modp *m, mp_limb_t x)
{
    bool minus;
    if (x == 0)
        return 1;
    mp_limb_t r = generator(m, EXPR_EXP, up_to_sign(m, x, &minus), 0);
    return minus ? invert(m, r) : r;
}

static bool logarithm(const struct num_modp *m, mp_limb_t x, mp_limb_t *r)
{
    if (!num_modp_unit(m, x))
        return false;
    *r = 0;
    if (x == 1)
        return true;
    mp_limb_t other = invert(m, x);
    *r = generator(m, EXPR_LOG, other < x ? other : x, 0);
    if (other < x)
        *r = nmod_neg(*r, m->mod);
    return true;
}

static bool hyperbolic(const struct num_modp *m, enum expr_op op, mp_limb_t x, mp_limb_t *r)
{
    mp_limb_t e = exponential(m, x), f = invert(m, e);
    mp_limb_t s = nmod_sub(e, f, m->mod), c = nmod_add(e, f, m->mod);
    if (op == EXPR_TANH) {
        bool unit = num_modp_unit(m, c);
        *r = unit ? nmod_mul(s, invert(m, c), m->mod) : 0;
        return unit;
    }
    *r = nmod_mul(op == EXPR_SINH ? s : c, (m->mod.n + 1) / 2, m->mod);
    return true;
}

static mp_limb_t least(const struct num_modp *m, mp_limb_t x, mp_limb_t y)
{
    if (x == y)
        return x;
    return x < y ? generator(m, EXPR_MIN, x, y) : generator(m, EXPR_MIN, y, x);
}

/* sqrt, by the power that inverts squaring on the group of squares, is itself a square. */
static bool square_root(const struct num_modp *m, mp_limb_t x, mp_limb_t *r)
{
    *r = nmod_pow_ui(x, (m->squares + 1) / 2, m->mod);
    return nmod_mul(*r, *r, m->mod) == x;
}

static bool cube_root(const struct num_modp *m, mp_limb_t x, mp_limb_t *r)
{
    *r = nmod_pow_ui(x, n_invmod(3, 2 * m->squares), m->mod);
    return x == 0 || num_modp_unit(m, x);
}

bool modp_rational_power(const struct num_modp *m, mp_limb_t x, const fmpq *exponent, mp_limb_t *r)
{
    ulong q = m->squares;
    *r = 0;
    if (x == 0)
        return fmpq_sgn(exponent) > 0;
    if (!num_modp_unit(m, x) || n_jacobi((slong)(x % m->p), m->p) != 1)
        return false;
    ulong n = fmpz_fdiv_ui(fmpq_numref(exponent), q), d = fmpz_fdiv_ui(fmpq_denref(exponent), q);
    if (n_gcd(d, q) != 1)
        return false;
    *r = nmod_pow_ui(x, n_mulmod2(n, n_invmod(d, q), q), m->mod);
    return true;
}

static bool one_argument(const struct num_modp *m, enum expr_op op, mp_limb_t x, mp_limb_t *r)
{
    mp_limb_t s, c;
    switch (op) {
    case EXPR_SIN: case EXPR_COS: case EXPR_TAN:
        sine_cosine(m, x, &s, &c);
        bool unit = num_modp_unit(m, c);
        if (op == EXPR_TAN && unit)
            s = nmod_mul(s, invert(m, c), m->mod);
        *r = op == EXPR_COS ? c : s;
        return op != EXPR_TAN || unit;
    case EXPR_EXP:  *r = exponential(m, x); return true;
    case EXPR_SINH: case EXPR_COSH: case EXPR_TANH:
        return hyperbolic(m, op, x, r);
    case EXPR_LOG:  return logarithm(m, x, r);
    case EXPR_SQRT: return square_root(m, x, r);
    case EXPR_CBRT: return cube_root(m, x, r);
    case EXPR_ACOS:    /* pi/2 - asin */
        *r = nmod_sub(nmod_mul(modp_pi(m), (m->mod.n + 1) / 2, m->mod), odd(m, EXPR_ASIN, x), m->mod);
        return true;
    case EXPR_ABS:  *r = nmod_mul(x, odd(m, EXPR_SIGN, x), m->mod); return true;
    default:        *r = expr_op_traits(op) & EXPR_IS_ODD ? odd(m, op, x) : x == 1 ? 0 : generator(m, op, x, 0); return true;
    }
}

bool modp_kernel(const struct num_modp *m, enum expr_op op, mp_limb_t x, mp_limb_t y, mp_limb_t *r)
{
    switch (op) {
    case EXPR_POW:    /* of a base and an exponent that are both functions */
        *r = y == 0 || x == 1 ? 1 : generator(m, op, x, y);
        return x != 0;
    case EXPR_ATAN2:
        *r = x == 0 && y == 0 ? 0 : generator(m, op, x, y);
        return x != 0 || y != 0;
    case EXPR_MIN: *r = least(m, x, y); return true;
    case EXPR_MAX: *r = nmod_sub(nmod_add(x, y, m->mod), least(m, x, y), m->mod); return true;
    default:       return one_argument(m, op, x, r);
    }
}
