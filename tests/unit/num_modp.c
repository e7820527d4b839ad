/* The oracle modulo p against exact rational evaluation reduced modulo p, and the
 * identities that its kernels promise. */
#include "check.h"

#include <flint/fmpq.h>
#include <flint/fmpz.h>
#include <flint/ulong_extras.h>
#include <string.h>

#include "modp.h"
#include "random_expr.h"

static struct random_source rng;

/* Exact values by a plain walk; defined[e] false after a division by zero. */
static void walk(const struct expr_store *st, const fmpq *in, fmpq *v, bool *defined)
{
    for (expr_id e = 1; e < st->nodes; e++) {
        const struct expr_node *n = st->node + e;
        int args = expr_op_args((enum expr_op)n->op);
        defined[e] = (args < 1 || defined[n->a]) && (args < 2 || defined[n->b]);
        if (!defined[e])
            continue;
        switch ((enum expr_op)n->op) {
        case EXPR_CONST: fmpq_set(v + e, st->constant + n->a); break;
        case EXPR_SYM: fmpq_set(v + e, in + n->a); break;
        case EXPR_ADD: fmpq_add(v + e, v + n->a, v + n->b); break;
        case EXPR_SUB: fmpq_sub(v + e, v + n->a, v + n->b); break;
        case EXPR_MUL: fmpq_mul(v + e, v + n->a, v + n->b); break;
        case EXPR_NEG: fmpq_neg(v + e, v + n->a); break;
        case EXPR_DIV:
            defined[e] = !fmpq_is_zero(v + n->b);
            if (defined[e])
                fmpq_div(v + e, v + n->a, v + n->b);
            break;
        case EXPR_POWI:
            defined[e] = n->b > 0 || !fmpq_is_zero(v + n->a);
            if (defined[e])
                fmpq_pow_si(v + e, v + n->a, n->b);
            break;
        default: defined[e] = false; break;
        }
    }
}

static void against_rationals(int prime)
{
    enum { SYMBOLS = 4, NODES = 18 };
    struct expr_store st;
    struct num_modp m;
    expr_id pool[SYMBOLS + NODES];
    fmpq in[SYMBOLS];
    int n = 0;
    expr_store_init(&st);
    num_modp_init(&m, &st, random_next(&rng), prime);
    for (; n < SYMBOLS; n++) {
        char name[8];
        sprintf(name, "x%d", n);
        pool[n] = expr_symbol_add(&st, name, EXPR_VARIABLE);
        fmpq_init(in + n);
        fmpq_set_si(in + n, random_below(&rng, 41) - 20, (ulong)random_below(&rng, 9) + 1);
        mp_limb_t r;
        CHECK(num_modp_fmpq(&m, in + n, &r), "small denominators");
        num_modp_set(&m, n, r);
    }
    for (; n < SYMBOLS + NODES && expr_store_ok(&st); n++) {
        expr_id e = random_rational(&rng, &st, pool, n);
        pool[n] = e ? e : pool[0];
        num_modp_extend(&m);    /* lazily, as the store grows */
    }
    fmpq *v = calloc((size_t)st.nodes, sizeof *v);
    bool *defined = calloc((size_t)st.nodes, sizeof *defined);
    for (int e = 0; e < st.nodes; e++)
        fmpq_init(v + e);
    walk(&st, in, v, defined);
    CHECK(m.nodes == st.nodes, "%d of %d nodes", m.nodes, st.nodes);
    for (expr_id e = 1; e < st.nodes; e++) {
        mp_limb_t want = 0;
        bool good = defined[e] && num_modp_fmpq(&m, v + e, &want);
        CHECK(num_modp_bad(&m, e) == !good && (!good || num_modp_value(&m, e) == want), "node %d", e);
        CHECK(!num_modp_kernel(&m, e) && !num_modp_branch(&m, e), "node %d", e);
    }
    for (int e = 0; e < st.nodes; e++)
        fmpq_clear(v + e);
    for (int i = 0; i < SYMBOLS; i++)
        fmpq_clear(in + i);
    free(v);
    free(defined);
    num_modp_clear(&m);
    expr_store_clear(&st);
}

static void primes(void)
{
    struct expr_store st;
    expr_store_init(&st);
    ulong last = UWORD(1) << 60;
    for (int k = 0; k < NUM_MODP_PRIMES; k++) {
        struct num_modp m;
        num_modp_init(&m, &st, 1, k);
        ulong p = m.mod.n;
        CHECK(n_is_prime(p) && n_is_prime((p - 1) / 2) && p % 12 == 11 && p > last, "%lu", p);
        for (ulong q = n_nextprime(last, 0); q < p; q = n_nextprime(q, 0))
            CHECK(q % 12 != 11 || !n_is_prime((q - 1) / 2), "%lu was left out", q);
        last = p;
        num_modp_clear(&m);
    }
    expr_store_clear(&st);
}

/* One point, with names for what the identities need. */
struct point {
    struct expr_store st;
    struct num_modp m;
    expr_id x, y, one;
};

static void point_init(struct point *p)
{
    expr_store_init(&p->st);
    num_modp_init(&p->m, &p->st, random_next(&rng), random_below(&rng, NUM_MODP_PRIMES));
    p->x = expr_symbol_add(&p->st, "x", EXPR_VARIABLE);
    p->y = expr_symbol_add(&p->st, "y", EXPR_VARIABLE);
    p->one = expr_int(&p->st, 1);
    num_modp_set(&p->m, 0, num_modp_random(&p->m, 1));
    num_modp_set(&p->m, 1, num_modp_random(&p->m, 2));
}

static void point_clear(struct point *p)
{
    num_modp_clear(&p->m);
    expr_store_clear(&p->st);
}

static bool vanishes(struct point *p, expr_id e)
{
    num_modp_extend(&p->m);
    return !num_modp_bad(&p->m, e) && num_modp_value(&p->m, e) == 0;
}

static expr_id fun(struct point *p, enum expr_op op, expr_id a) { return expr_fun(&p->st, op, a); }

#define SAME(a, b) CHECK(vanishes(&p, expr_sub(st, (a), (b))), "identity")
#define DIFFERENT(a, b) CHECK(!vanishes(&p, expr_sub(st, (a), (b))), "no identity")

/* Arguments: u, and v of the same value by another expression. */
static void kernel_identities(void)
{
    struct point p;
    struct expr_store *st = &p.st;
    point_init(&p);
    expr_id u = expr_powi(st, expr_add(st, p.x, p.y), 2);
    expr_id v = expr_add(st, expr_add(st, expr_powi(st, p.x, 2), expr_powi(st, p.y, 2)), expr_mul(st, expr_int(st, 2), expr_mul(st, p.x, p.y)));
    expr_id w = expr_sub(st, expr_sub(st, expr_int(st, 0), expr_mul(st, p.x, p.x)), expr_mul(st, p.y, expr_add(st, p.y, expr_add(st, p.x, p.x))));
    expr_id zero = expr_sub(st, u, v);
    CHECK(zero != expr_int(st, 0) && u != v, "the expressions must differ");
    for (int op = EXPR_SIN; op <= EXPR_CBRT; op++) {
        if (op == EXPR_ATAN2)
            continue;
        expr_id f = fun(&p, (enum expr_op)op, u);
        SAME(f, fun(&p, (enum expr_op)op, v));    /* u is a square: sqrt exists */
        num_modp_extend(&p.m);
        CHECK(num_modp_kernel(&p.m, f) == (op != EXPR_SQRT && op != EXPR_CBRT), "%s", expr_op_text((enum expr_op)op));
        CHECK(num_modp_branch(&p.m, f) == (op == EXPR_SQRT), "%s", expr_op_text((enum expr_op)op));
    }
    expr_id s = fun(&p, EXPR_SIN, u), c = fun(&p, EXPR_COS, v), e = fun(&p, EXPR_EXP, u);
    SAME(expr_add(st, expr_powi(st, s, 2), expr_powi(st, c, 2)), p.one);
    SAME(fun(&p, EXPR_TAN, v), expr_div(st, s, c));
    SAME(expr_sub(st, expr_powi(st, fun(&p, EXPR_COSH, u), 2), expr_powi(st, fun(&p, EXPR_SINH, v), 2)), p.one);
    SAME(expr_add(st, fun(&p, EXPR_COSH, u), fun(&p, EXPR_SINH, v)), e);
    SAME(fun(&p, EXPR_TANH, u), expr_div(st, fun(&p, EXPR_SINH, v), fun(&p, EXPR_COSH, v)));
    SAME(expr_mul(st, e, fun(&p, EXPR_EXP, w)), p.one);
    SAME(expr_add(st, s, fun(&p, EXPR_SIN, w)), zero);
    SAME(c, fun(&p, EXPR_COS, w));
    SAME(expr_add(st, fun(&p, EXPR_LOG, u), fun(&p, EXPR_LOG, expr_div(st, p.one, v))), zero);
    SAME(expr_add(st, fun(&p, EXPR_ASIN, u), fun(&p, EXPR_ACOS, v)), expr_div(st, expr_pi(st), expr_int(st, 2)));
    static const enum expr_op odd[] = { EXPR_ASIN, EXPR_ATAN, EXPR_SINH, EXPR_TANH, EXPR_ASINH, EXPR_ATANH, EXPR_CBRT, EXPR_SIGN, EXPR_TAN };
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        SAME(expr_add(st, fun(&p, odd[i], u), fun(&p, odd[i], w)), zero);
        CHECK(vanishes(&p, fun(&p, odd[i], zero)), "%s 0", expr_op_text(odd[i]));
    }
    SAME(fun(&p, EXPR_ABS, u), fun(&p, EXPR_ABS, w));
    SAME(fun(&p, EXPR_ABS, u), expr_mul(st, u, fun(&p, EXPR_SIGN, v)));
    SAME(expr_add(st, expr_fun2(st, EXPR_MIN, u, p.x), expr_fun2(st, EXPR_MAX, p.x, v)), expr_add(st, u, p.x));
    SAME(expr_fun2(st, EXPR_MIN, u, v), u);
    SAME(fun(&p, EXPR_EXP, zero), p.one);
    SAME(fun(&p, EXPR_COS, zero), p.one);
    SAME(fun(&p, EXPR_LOG, expr_add(st, p.one, zero)), zero);
    SAME(expr_powi(st, fun(&p, EXPR_CBRT, u), 3), v);
    SAME(fun(&p, EXPR_CBRT, expr_mul(st, p.x, p.y)), expr_mul(st, fun(&p, EXPR_CBRT, p.x), fun(&p, EXPR_CBRT, p.y)));
    DIFFERENT(s, fun(&p, EXPR_SIN, p.x));
    DIFFERENT(fun(&p, EXPR_ASIN, u), fun(&p, EXPR_ATAN, u));
    DIFFERENT(fun(&p, EXPR_ABS, u), u);
    DIFFERENT(e, fun(&p, EXPR_EXP, expr_add(st, u, p.one)));
    DIFFERENT(expr_fun2(st, EXPR_ATAN2, p.x, p.y), expr_fun2(st, EXPR_ATAN2, p.y, p.x));
    point_clear(&p);
}

/* Roots: exactly the squares have them, and on squares all rational powers fit together. */
static bool roots(void)
{
    struct point p;
    struct expr_store *st = &p.st;
    point_init(&p);
    expr_id rx = fun(&p, EXPR_SQRT, p.x), a = expr_powi(st, p.x, 2), b = expr_powi(st, p.y, 2);
    num_modp_extend(&p.m);
    bool square = n_jacobi((slong)num_modp_value(&p.m, p.x), p.m.mod.n) == 1;
    CHECK(num_modp_bad(&p.m, rx) == !square, "a root where there is none, or none where there is one");
    expr_id above = expr_add(st, expr_mul(st, rx, p.y), p.one);
    num_modp_extend(&p.m);
    CHECK(num_modp_bad(&p.m, above) == !square && num_modp_branch(&p.m, above), "poison reaches the parents");
    expr_id ra = fun(&p, EXPR_SQRT, a), rb = fun(&p, EXPR_SQRT, b);
    SAME(expr_mul(st, ra, ra), a);
    SAME(expr_mul(st, ra, rb), fun(&p, EXPR_SQRT, expr_mul(st, a, b)));
    SAME(expr_powi(st, fun(&p, EXPR_SQRT, ra), 4), a);
    if (square) {
        SAME(ra, p.x);
        expr_id third = expr_rational(st, 1, 3), f = expr_rational(st, -5, 7), g = expr_rational(st, 12, 7);
        SAME(expr_pow(st, p.x, third), fun(&p, EXPR_CBRT, p.x));
        SAME(expr_mul(st, expr_pow(st, p.x, f), expr_pow(st, p.x, g)), p.x);
        SAME(expr_pow(st, expr_mul(st, p.x, a), f), expr_mul(st, expr_pow(st, p.x, f), expr_pow(st, a, f)));
        SAME(expr_powi(st, expr_pow(st, p.x, expr_rational(st, 3, 4)), 4), expr_powi(st, p.x, 3));
    } else {
        DIFFERENT(ra, p.x);
    }
    point_clear(&p);
    return square;
}

static void undefined(void)
{
    struct point p;
    struct expr_store *st = &p.st;
    point_init(&p);
    expr_id u = expr_powi(st, expr_add(st, p.x, p.one), 2);
    expr_id zero = expr_sub(st, expr_sub(st, u, expr_powi(st, p.x, 2)), expr_add(st, p.x, expr_add(st, p.x, p.one)));
    expr_id bad[] = { expr_div(st, p.x, zero), expr_powi(st, zero, -2), fun(&p, EXPR_LOG, zero),
                      expr_fun2(st, EXPR_ATAN2, zero, zero), expr_pow(st, zero, expr_rational(st, -1, 2)) };
    expr_id fine[] = { expr_div(st, zero, p.x), expr_powi(st, zero, 3), fun(&p, EXPR_SQRT, zero), fun(&p, EXPR_CBRT, zero),
                       expr_pow(st, zero, expr_rational(st, 1, 2)) };
    for (size_t i = 0; i < sizeof fine / sizeof *fine; i++)
        CHECK(vanishes(&p, fine[i]), "%zu", i);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        expr_id parent = fun(&p, EXPR_SIN, bad[i]);
        num_modp_extend(&p.m);
        CHECK(num_modp_bad(&p.m, bad[i]) && num_modp_bad(&p.m, parent) && num_modp_value(&p.m, bad[i]) == 0, "%zu", i);
    }
    CHECK(num_modp_bad(&p.m, EXPR_UNDEF), "node 0 has no value");
    fmpq_t q;
    fmpq_init(q);
    fmpz_set_ui(fmpq_denref(q), p.m.mod.n);
    fmpz_set_ui(fmpq_numref(q), 1);
    mp_limb_t r;
    CHECK(!num_modp_fmpq(&p.m, q, &r), "1/p");
    fmpq_clear(q);
    point_clear(&p);
}

/* S y = r by residuals; a singular one is bad; recomputing a cone follows the symbols. */
static int singular_powers;      /* random systems without a solution modulo a small prime */

static void solves_and_lists(void)
{
    enum { M = 5 };
    struct point p;
    struct expr_store *st = &p.st;
    point_init(&p);
    expr_id a[M * M], r[M], y[M];
    for (int i = 0; i < M * M; i++)
        a[i] = expr_add(st, expr_mul(st, p.x, expr_int(st, random_below(&rng, 50))), expr_int(st, random_below(&rng, 50)));
    for (int i = 0; i < M; i++)
        r[i] = fun(&p, EXPR_SIN, expr_mul(st, p.y, expr_int(st, i + 1)));
    int s = expr_solve_add(st, M, a, r);
    for (int i = 0; i < M; i++)
        y[i] = expr_solution(st, s, i);
    expr_id residual[M], same[4] = { p.x, p.x, p.x, p.x }, two[2] = { p.x, p.y };
    for (int i = 0; i < M; i++) {
        residual[i] = expr_neg(st, r[i]);
        for (int k = 0; k < M; k++)
            residual[i] = expr_add(st, residual[i], expr_mul(st, a[i * M + k], y[k]));
    }
    expr_id singular = expr_solution(st, expr_solve_add(st, 2, same, two), 0);
    num_modp_extend(&p.m);
    CHECK(num_modp_bad(&p.m, singular), "a singular solve");
    CHECK(num_modp_kernel(&p.m, y[2]) && num_modp_value(&p.m, y[2]) != 0, "the kernel of the right-hand side");
    for (int i = 0; i < M; i++)
        CHECK(vanishes(&p, residual[i]), "row %d", i);

    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, residual, M);
    num_modp_set(&p.m, 0, 12345);
    num_modp_set(&p.m, 1, 678);
    mp_limb_t before = num_modp_value(&p.m, y[0]);
    num_modp_list(&p.m, cone.list, cone.count);
    CHECK(num_modp_value(&p.m, y[0]) != before, "the solve was computed again");
    for (int i = 0; i < M; i++)
        CHECK(vanishes(&p, residual[i]), "row %d after a change", i);
    struct num_modp other;
    num_modp_init(&other, st, p.m.seed, 0);
    other.mod = p.m.mod;
    num_modp_set(&other, 1, 678);
    num_modp_set(&other, 0, 12345);
    num_modp_list(&other, cone.list, cone.count);    /* before any extend: the cone is whole */
    for (int i = 0; i < cone.count; i++)
        CHECK(num_modp_value(&other, cone.list[i]) == num_modp_value(&p.m, cone.list[i]), "same seed, same value");
    num_modp_forget(&other);
    num_modp_extend(&other);
    for (int i = 0; i < cone.count; i++)
        CHECK(num_modp_value(&other, cone.list[i]) == num_modp_value(&p.m, cone.list[i]), "after forgetting");
    num_modp_clear(&other);
    expr_cone_clear(&cone);
    point_clear(&p);
}

/* Modulo powers of small primes: units in the place of what is not 0. */
static void powers(mp_limb_t small)
{
    struct point p;
    struct expr_store *st = &p.st;
    point_init(&p);
    num_modp_clear(&p.m);
    num_modp_init_power(&p.m, st, random_next(&rng), small);
    mp_limb_t n = p.m.mod.n, x, y = num_modp_random(&p.m, 5);
    CHECK(n == n_pow(p.m.p, (ulong)p.m.power) && n > UWORD(1) << 57 && n < UWORD(1) << 63 && n_is_prime(p.m.p), "modulus %lu", n);
    CHECK(p.m.p % 12 == 11 && n_is_prime((p.m.p - 1) / 2), "prime %lu", p.m.p);
    for (int key = 10; !num_modp_unit(&p.m, x = num_modp_random(&p.m, (uint64_t)key)); key++)
        ;
    num_modp_set(&p.m, 0, x);
    num_modp_set(&p.m, 1, y);
    expr_id three = expr_int(st, 3), square = expr_powi(st, p.x, 2), r = fun(&p, EXPR_SQRT, square), c = fun(&p, EXPR_CBRT, p.x);
    SAME(expr_powi(st, r, 2), square);
    SAME(expr_powi(st, c, 3), p.x);
    SAME(expr_powi(st, expr_pow(st, square, expr_rational(st, 2, 3)), 3), expr_powi(st, p.x, 4));
    SAME(expr_add(st, expr_powi(st, fun(&p, EXPR_SIN, p.y), 2), expr_powi(st, fun(&p, EXPR_COS, p.y), 2)), p.one);
    SAME(expr_mul(st, fun(&p, EXPR_EXP, p.y), fun(&p, EXPR_EXP, expr_neg(st, p.y))), p.one);
    SAME(expr_mul(st, expr_div(st, three, p.x), p.x), three);
    SAME(expr_mul(st, expr_powi(st, p.x, -3), expr_powi(st, p.x, 3)), p.one);
    DIFFERENT(expr_powi(st, r, 2), p.one);
    num_modp_set(&p.m, 0, nmod_mul(y, p.m.p, p.m.mod));      /* no unit any more */
    num_modp_forget(&p.m);
    num_modp_extend(&p.m);
    CHECK(num_modp_bad(&p.m, expr_div(st, three, p.x)) && num_modp_bad(&p.m, c), "divided by a multiple of the prime");
    enum { SIZE = 5 };
    mp_limb_t a[SIZE * SIZE], b[SIZE], right[SIZE], matrix[SIZE * SIZE];
    for (int i = 0; i < SIZE * SIZE; i++)
        a[i] = matrix[i] = num_modp_random(&p.m, 100 + (uint64_t)i);
    for (int i = 0; i < SIZE; i++)
        b[i] = right[i] = num_modp_random(&p.m, 200 + (uint64_t)i);
    if (num_modp_solve(&p.m, a, b, SIZE)) {
        for (int i = 0; i < SIZE; i++) {
            mp_limb_t sum = 0;
            for (int j = 0; j < SIZE; j++)
                sum = nmod_add(sum, nmod_mul(matrix[i * SIZE + j], b[j], p.m.mod), p.m.mod);
            CHECK(sum == right[i], "row %d", i);
        }
    } else {
        singular_powers++;
    }
    point_clear(&p);
}

int main(void)
{
    rng.state = check_seed(271828);
    static const mp_limb_t small[] = { 503, 107, 47, 23, 11 };
    int n = check_scale(300), squares = 0;
    for (int i = 0; i < n; i++)
        against_rationals(i % NUM_MODP_PRIMES);
    for (int i = 0; i < n; i++) {
        kernel_identities();
        squares += roots();
        solves_and_lists();
        powers(small[i % 5]);
    }
    CHECK(n < 50 || singular_powers < n / 8, "%d of %d systems are singular modulo a small prime", singular_powers, n);
    CHECK(n < 50 || (squares > n / 4 && squares < 3 * n / 4), "%d of %d random residues are squares", squares, n);
    primes();
    undefined();
    flint_cleanup();
    return CHECK_END();
}
