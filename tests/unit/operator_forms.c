/* Operators over Q(t): identities of the ring, and the forms of random systems by two routes. */
#include "check.h"

#include <stdint.h>
#include <stdlib.h>

#include <flint/fmpq.h>

#include "error.h"
#include "operator.h"
#include "popov.h"

static uint64_t state;

#define REQUIRE(cond) do { bool ok_ = (cond); CHECK(ok_, #cond); if (!ok_) exit(1); } while (0)

static int draw(int n)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (int)((state >> 33) % (uint64_t)n);
}

static void random_ratio(fmpz_poly_q_t a, int degree, bool denominator)
{
    fmpz_poly_q_zero(a);
    for (int k = 0; k <= degree; k++)
        fmpz_poly_set_coeff_si(fmpz_poly_q_numref(a), k, draw(7) - 3);
    if (denominator && draw(3) == 0) {
        fmpz_poly_set_coeff_si(fmpz_poly_q_denref(a), 0, 1 + draw(3));
        fmpz_poly_set_coeff_si(fmpz_poly_q_denref(a), 1, draw(3));
    }
    fmpz_poly_q_canonicalise(a);
}

static void random_ore(struct ore *x, int order, int degree)
{
    fmpz_poly_q_t a;
    fmpz_poly_q_init(a);
    ore_zero(x);
    for (int k = 0; k <= order; k++) {
        random_ratio(a, degree, true);
        ore_add_term(x, a, k);
    }
    fmpz_poly_q_clear(a);
}

static void test_ring(void)
{
    struct ore a, b, c, x, y, z, u, v, m;
    struct ore *all[] = { &a, &b, &c, &x, &y, &z, &u, &v, &m };
    for (int k = 0; k < 9; k++)
        ore_init(all[k]);
    fmpz_poly_q_t t, one;
    fmpz_poly_q_init(t);
    fmpz_poly_q_init(one);
    fmpz_poly_q_one(one);
    fmpz_poly_set_coeff_si(fmpz_poly_q_numref(t), 1, 1);
    ore_add_term(&a, one, 1);
    ore_add_term(&b, t, 0);
    ore_mul(&x, &a, &b);                       /* D t = t D + 1 */
    ore_mul(&y, &b, &a);
    ore_sub(&z, &x, &y);
    ore_one(&c);
    CHECK(ore_equal(&z, &c));
    for (int round = 0; round < 60; round++) {
        random_ore(&a, draw(4), 2);
        random_ore(&b, draw(3), 2);
        random_ore(&c, draw(3), 1);
        ore_mul(&x, &a, &b);
        ore_mul(&x, &x, &c);
        ore_mul(&y, &b, &c);
        ore_mul(&y, &a, &y);
        CHECK(ore_equal(&x, &y));              /* associative */
        ore_adjoint(&x, &a);
        ore_adjoint(&x, &x);
        CHECK(ore_equal(&x, &a));
        ore_mul(&x, &a, &b);
        ore_adjoint(&x, &x);
        ore_adjoint(&y, &a);
        ore_adjoint(&z, &b);
        ore_mul(&z, &z, &y);
        CHECK(ore_equal(&x, &z));              /* (a b)* = b* a* */
        if (ore_is_zero(&b))
            continue;
        ore_divide_right(&x, &y, &a, &b);
        ore_mul(&z, &x, &b);
        ore_add(&z, &z, &y);
        CHECK(ore_equal(&z, &a) && ore_order(&y) < ore_order(&b));
        ore_divide_left(&x, &y, &a, &b);
        ore_mul(&z, &b, &x);
        ore_add(&z, &z, &y);
        CHECK(ore_equal(&z, &a) && ore_order(&y) < ore_order(&b));
        if (ore_is_zero(&a) || ore_is_zero(&c))
            continue;
        ore_mul(&a, &a, &c);                   /* c divides both on the right */
        ore_mul(&b, &b, &c);
        ore_gcrd(&x, &u, &v, &m, &a, &b);
        ore_mul(&y, &u, &a);
        ore_mul(&z, &v, &b);
        ore_add(&y, &y, &z);
        CHECK(ore_equal(&x, &y));
        CHECK(ore_order(&x) >= ore_order(&c));
        ore_divide_right(&u, &y, &x, &c);
        CHECK(ore_is_zero(&y));
        ore_divide_right(&u, &y, &a, &x);
        CHECK(ore_is_zero(&y));
        ore_divide_right(&u, &y, &m, &a);
        CHECK(ore_is_zero(&y));
        ore_divide_right(&u, &y, &m, &b);
        CHECK(ore_is_zero(&y));
        CHECK(ore_order(&m) == ore_order(&a) + ore_order(&b) - ore_order(&x));
    }
    fmpz_poly_q_clear(t);
    fmpz_poly_q_clear(one);
    for (int k = 0; k < 9; k++)
        ore_clear(all[k]);
}

static void new_system(struct op_system *s, int p, int q, int order)
{
    *s = (struct op_system){ .unknowns = p, .sources = q, .order = order };
    s->A = calloc((size_t)order + 1, sizeof *s->A);
    for (int k = 0; k <= order; k++)
        ratio_matrix_init(s->A + k, p, p);
    ratio_matrix_init(&s->B, p, q);
}

static void set_poly(const struct ratio_matrix *m, int i, int j, int c0, int c1, int c2)
{
    fmpz_poly_struct *p = fmpz_poly_q_numref(ratio_at(m, i, j));
    fmpz_poly_set_coeff_si(p, 0, c0);
    fmpz_poly_set_coeff_si(p, 1, c1);
    fmpz_poly_set_coeff_si(p, 2, c2);
}

struct found { int rank, n, index, nu0; };

/* All forms of a system, each checked by itself and against the others. */
static struct found analyse(const struct op_system *s, bool jacobson)
{
    struct found r = { 0 };
    struct ore_matrix P;
    struct op_popov p;
    struct op_state x;
    struct op_laurent g;
    struct op_jacobson f;
    struct op_limits limits = { 0 };
    struct sga_error err = { 0 };
    op_system_matrix(s, &P);
    REQUIRE(op_popov_weak(&p, &P, true, &limits, &err));
    r.rank = p.rank;
    struct ore_matrix m = { 0 };
    ore_matrix_mul(&m, &p.U, &P);
    CHECK(ore_matrix_equal(&m, &p.R));
    ore_matrix_mul(&m, &p.U, &p.inverse);
    CHECK(ore_matrix_is_identity(&m));
    ore_matrix_clear(&m);
    if (p.rank == s->unknowns) {
        int nu0 = 0;
        struct ratio_matrix leading;
        struct op_popov full;
        REQUIRE(op_popov_weak(&full, &P, false, &limits, &err) && op_popov_finish(&full, &limits, &err));
        REQUIRE(op_state_form(&x, s, &full, &limits, &err));
        bool any = op_state_leading(&x, &nu0, &leading);
        REQUIRE(op_laurent_series(&g, s, &p, nu0, 3, &limits, &err));
        CHECK(any == (g.terms > 0));
        if (any) {
            CHECK(g.first == nu0);
            CHECK(ratio_matrix_equal(g.coefficient, &leading));
            ratio_matrix_clear(&leading);
        }
        r.n = x.n;
        r.nu0 = nu0;
        r.index = x.degree + 1;
        CHECK(r.index == (1 - nu0 > 0 ? 1 - nu0 : 0));
        if (jacobson) {
            REQUIRE(op_jacobson_form(&f, s, &full, &x, &limits, &err));
            CHECK(f.rank == r.rank && ore_order(&f.e) == r.n);
            op_jacobson_clear(&f);
        }
        op_laurent_clear(&g);
        op_state_clear(&x);
        op_popov_clear(&full);
    }
    if (jacobson) {                           /* the way of any rank */
        bool ok = op_jacobson_form(&f, s, NULL, NULL, &limits, &err);
        if (!ok)
            printf("%s\n", err.detail);
        REQUIRE(ok);
        CHECK(f.rank == r.rank);
        if (r.rank == s->unknowns)
            CHECK(ore_order(&f.e) == r.n);
        op_jacobson_clear(&f);
    }
    op_popov_clear(&p);
    ore_matrix_clear(&P);
    return r;
}

/* [[0, 0], [1, -t]] y' + [[1, -t], [0, 0]] y = e: singular pencil at every t, yet solvable;
 * y2 = e1' - e2, y1 = e1 - t e2 + t e1'. */
static void test_source_example(void)
{
    struct op_system s;
    new_system(&s, 2, 2, 1);
    set_poly(&s.A[1], 1, 0, 1, 0, 0);
    set_poly(&s.A[1], 1, 1, 0, -1, 0);
    set_poly(&s.A[0], 0, 0, 1, 0, 0);
    set_poly(&s.A[0], 0, 1, 0, -1, 0);
    set_poly(&s.B, 0, 0, 1, 0, 0);
    set_poly(&s.B, 1, 1, 1, 0, 0);
    struct found r = analyse(&s, true);
    CHECK(r.rank == 2 && r.n == 0 && r.index == 2 && r.nu0 == -1);
    op_system_clear(&s);
}

/* t y' = y + e: index 0, pole of the leading matrix 1/t at 0; (t^2 - 2) y = e: index 1. */
static void test_singular_times(void)
{
    struct op_system s;
    struct ratio_matrix leading;
    struct op_singular_times found;
    new_system(&s, 1, 1, 1);
    set_poly(&s.A[1], 0, 0, 0, 1, 0);
    set_poly(&s.A[0], 0, 0, -1, 0, 0);
    set_poly(&s.B, 0, 0, 1, 0, 0);
    struct found r = analyse(&s, true);
    CHECK(r.rank == 1 && r.n == 1 && r.index == 0 && r.nu0 == 1);
    op_system_clear(&s);
    ratio_matrix_init(&leading, 1, 2);
    fmpz_poly_q_set_str(ratio_at(&leading, 0, 0), "1  1/3  -2 0 1");
    fmpz_poly_q_set_str(ratio_at(&leading, 0, 1), "2  0 1/3  9 -6 1");
    op_singular_find(&found, &leading);
    CHECK(found.count == 3);
    CHECK(found.at[0].t == -1.4142135623730951 && found.at[1].t == 1.4142135623730951 && found.at[2].t == 3);
    CHECK(found.at[2].order == 2 && found.at[2].lost == OP_POLE);
    CHECK(fmpq_equal(found.at[2].low, found.at[2].high));
    op_singular_clear(&found);
    ratio_matrix_clear(&leading);
}

static void random_system(struct op_system *s, int p, int order, int degree, int density)
{
    new_system(s, p, p, order);
    for (int k = 0; k <= order; k++)
        for (int q = 0; q < p * p; q++)
            if (draw(100) < density / (k + 1))
                random_ratio(s->A[k].e + q, draw(degree + 1), false);
    for (int i = 0; i < p; i++)
        set_poly(&s->B, i, i, 1, 0, 0);
}

/* y = T z, P T z = e: the index does not change (proposition 4 of the source). */
static void transform(struct op_system *to, const struct op_system *s)
{
    struct ore_matrix P, T, m = { 0 };
    int p = s->unknowns;
    op_system_matrix(s, &P);
    ore_matrix_init(&T, p, p);
    fmpz_poly_q_t a;
    fmpz_poly_q_init(a);
    for (int i = 0; i < p; i++)
        for (int j = 0; j <= i; j++) {
            if (i == j)
                fmpz_poly_q_one(a);
            else
                random_ratio(a, 1, false);
            ore_add_term(ore_at(&T, i, j), a, 0);
        }
    ore_matrix_mul(&m, &P, &T);
    int order = ore_matrix_order(&m);
    new_system(to, p, p, order < 0 ? 0 : order);
    for (int q = 0; q < p * p; q++)
        for (int k = 0; k < m.e[q].len; k++)
            fmpz_poly_q_set(to->A[k].e + q, m.e[q].a + k);
    for (int i = 0; i < p; i++)
        set_poly(&to->B, i, i, 1, 0, 0);
    fmpz_poly_q_clear(a);
    ore_matrix_clear(&P);
    ore_matrix_clear(&T);
    ore_matrix_clear(&m);
}

static void test_random(void)
{
    int full = 0, high = 0, lower = 0;
    for (int round = 0; round < check_scale(120); round++) {
        struct op_system s, moved;
        int p = 1 + draw(4);
        random_system(&s, p, 1 + draw(2), 2, 30 + draw(60));
        struct found r = analyse(&s, p < 4 || round % 4 == 0);
        transform(&moved, &s);
        struct found m = analyse(&moved, false);
        CHECK(r.rank == m.rank && r.n == m.n && r.index == m.index);
        full += r.rank == p;
        high += r.index >= 2;
        lower += r.rank < p;
        op_system_clear(&s);
        op_system_clear(&moved);
    }
    if (check_scale(120) >= 120)
        CHECK(full > 20 && high > 5 && lower > 5);
}

/* x' parts and a nilpotent chain behind a time-dependent change: index 4, two states. */
static void test_planted_index(void)
{
    struct op_system s, moved;
    new_system(&s, 6, 6, 1);
    set_poly(&s.A[1], 0, 0, 1, 0, 0);
    set_poly(&s.A[0], 0, 1, 0, 1, 0);
    set_poly(&s.A[1], 1, 1, 1, 0, 0);
    set_poly(&s.A[0], 1, 0, 1, 0, 0);
    for (int i = 2; i < 6; i++) {
        set_poly(&s.A[0], i, i, 1, 0, 0);
        if (i < 5)
            set_poly(&s.A[1], i, i + 1, 1, 0, 0);
    }
    for (int i = 0; i < 6; i++)
        set_poly(&s.B, i, i, 1, 0, 0);
    struct found r = analyse(&s, true);
    CHECK(r.rank == 6 && r.n == 2 && r.index == 4);
    transform(&moved, &s);
    r = analyse(&moved, false);
    CHECK(r.rank == 6 && r.n == 2 && r.index == 4);
    op_system_clear(&s);
    op_system_clear(&moved);
}

int main(void)
{
    state = check_seed(20260711);
    test_ring();
    test_source_example();
    test_singular_times();
    test_random();
    test_planted_index();
    flint_cleanup();
    return CHECK_END();
}
