/* Eigenvalues as decimals, primes that mislead, limits. */
#include <math.h>
#include <string.h>

#include <flint/ulong_extras.h>

#include "budget.h"
#include "check.h"
#include "error.h"
#include "pencil.h"

/* One number of the pencil, from text. */
static void put(struct pencil_matrix *m, int row, int col, const char *text)
{
    fmpq_t q;
    fmpq_init(q);
    CHECK(fmpq_set_str(q, text, 10) == 0, "%s", text);
    pencil_add(m, row, col, q);
    fmpq_clear(q);
}

/* s I - B */
static void ordinary(struct pencil *p, int n, const char *const *b)
{
    pencil_init(p, n, n);
    for (int i = 0; i < n; i++) {
        put(&p->A, i, i, "1");
        for (int j = 0; j < n; j++)
            put(&p->B, i, j, b[i * n + j]);
    }
}

static bool solve(const struct pencil *p, double rtol, struct pencil_structure *s, struct pencil_eigenvalue **e, int *n)
{
    struct sga_error err = { 0 };
    struct pencil_options o = { .spectrum = true };
    bool ok = pencil_structure(p, &o, s, &err) && pencil_eigenvalues(s, rtol, NULL, e, n, &err);
    CHECK(ok, "%s", err.detail);
    return ok;
}

/* Real and imaginary parts in order, as texts. */
static void expect(int n, const char *const *b, double rtol, const char *const *should, int count)
{
    struct pencil p;
    struct pencil_structure s;
    struct pencil_eigenvalue *e;
    int found;
    ordinary(&p, n, b);
    if (!solve(&p, rtol, &s, &e, &found))
        return;
    CHECK(found == count, "%d", found);
    for (int i = 0; i < found && i < count; i++) {
        CHECK(strcmp(e[i].re, should[2 * i]) == 0, "%s, not %s", e[i].re, should[2 * i]);
        CHECK(strcmp(e[i].im, should[2 * i + 1]) == 0, "%s, not %s", e[i].im, should[2 * i + 1]);
    }
    pencil_eigenvalues_clear(e, found);
    pencil_structure_clear(&s);
    pencil_clear(&p);
}

static void decimals(void)
{
    static const char *const root2[] = { "0", "2", "1", "0" };
    static const char *const short2[] = { "-1.4142135623730951", "0", "1.4142135623730951", "0" };
    static const char *const long2[] = { "-1.414213562373095048801688724209698078570", "0",
                                         "1.414213562373095048801688724209698078570", "0" };
    expect(2, root2, 1e-8, short2, 2);
    expect(2, root2, 1e-39, long2, 2);
    static const char *const turn[] = { "0", "-1/4", "1", "0" };
    static const char *const half[] = { "0", "-0.5", "0", "0.5" };
    expect(2, turn, 1e-8, half, 2);
    static const char *const damped[] = { "0", "1", "-1", "-1" };
    static const char *const pair[] = { "-0.5", "-0.8660254037844386", "-0.5", "0.8660254037844386" };
    expect(2, damped, 1e-15, pair, 2);
    static const char *const three[] = { "0", "0", "0", "1", "0", "0", "0", "1", "0" };
    static const char *const zero[] = { "0", "0" };
    expect(3, three, 1e-8, zero, 1);
    /* exactly between two doubles: 1 + 2^-53 */
    static const char *const tie[] = { "9007199254740993/9007199254740992" };
    struct pencil p;
    struct pencil_structure s;
    struct pencil_eigenvalue *e;
    int n;
    ordinary(&p, 1, tie);
    if (solve(&p, 1e-8, &s, &e, &n)) {
        CHECK(n == 1 && fabs(atof(e[0].re) - 1) < 3e-16, "%s", e[0].re);
        pencil_eigenvalues_clear(e, n);
        pencil_structure_clear(&s);
    }
    pencil_clear(&p);
}

static void look_alikes(void)
{
    /* 1/3 and 1/3 + 10^-40; 10^400 */
    static const char *const b[] = { "1/3", "1", "0", "0",
        "10000000000000000000000000000000000000003/30000000000000000000000000000000000000000", "0", "0", "0", NULL };
    char huge[402] = "1";
    const char *full[9];
    struct pencil p;
    struct pencil_structure s;
    struct pencil_eigenvalue *e;
    int n;
    memset(huge + 1, '0', 400);
    for (int i = 0; i < 9; i++)
        full[i] = b[i] ? b[i] : huge;
    ordinary(&p, 3, full);
    if (solve(&p, 1e-8, &s, &e, &n)) {
        CHECK(n == 3 && s.factors == 1 && s.basis == PENCIL_PROVED);
        CHECK(strcmp(e[0].re, e[1].re) != 0, "%s %s", e[0].re, e[1].re);
        CHECK(strncmp(e[0].re, "0.3333333333333333", 18) == 0 && strlen(e[0].re) > 41, "%s", e[0].re);
        CHECK(strncmp(e[2].re, "1", 1) == 0 && strstr(e[2].re, "e+400"), "%s", e[2].re);
        pencil_eigenvalues_clear(e, n);
        pencil_structure_clear(&s);
    }
    pencil_clear(&p);
}

/* Entries made of the very primes that are used first: ranks drop there, Jordan blocks split. */
static void misleading(void)
{
    for (int primes = 1; primes <= 3; primes++) {
        struct pencil p;
        struct pencil_structure s;
        struct pencil_eigenvalue *e;
        mp_limb_t q = 1UL << 61;
        fmpz_t product, plus;
        int n;
        fmpz_init_set_ui(product, 1);
        fmpz_init(plus);
        for (int i = 0; i < primes; i++) {
            q = n_nextprime(q, 1);
            fmpz_mul_ui(product, product, q);
        }
        fmpz_add_ui(plus, product, 1);
        char *t = fmpz_get_str(NULL, 10, product), *u = fmpz_get_str(NULL, 10, plus);
        pencil_init(&p, 2, 2);                 /* A = (P + 1, 1; 1, 1), B = (1, 0; 0, 1) */
        put(&p.A, 0, 0, u), put(&p.A, 0, 1, "1"), put(&p.A, 1, 0, "1"), put(&p.A, 1, 1, "1");
        put(&p.B, 0, 0, "1"), put(&p.B, 1, 1, "1");
        if (solve(&p, 1e-8, &s, &e, &n)) {
            CHECK(s.finite == 2 && s.infinites == 0 && s.basis == PENCIL_PROVED, "%d", s.finite);
            pencil_eigenvalues_clear(e, n);
            pencil_structure_clear(&s);
        }
        pencil_clear(&p);
        const char *const block[] = { "2", t, "0", "2" };
        ordinary(&p, 2, block);
        if (solve(&p, 1e-8, &s, &e, &n)) {
            CHECK(n == 1 && s.factors == 1 && s.factor[0].blocks == 1 && s.factor[0].block[0] == 2, "%d", s.factor[0].blocks);
            pencil_eigenvalues_clear(e, n);
            pencil_structure_clear(&s);
        }
        pencil_clear(&p);
        pencil_init(&p, 1, 2);                 /* (P s - 1, s - P): a right index, modulo P an infinite block */
        put(&p.A, 0, 0, t), put(&p.A, 0, 1, "1"), put(&p.B, 0, 0, "1"), put(&p.B, 0, 1, t);
        if (solve(&p, 1e-8, &s, &e, &n)) {
            CHECK(s.rights == 1 && s.right[0] == 1 && s.finite == 0, "%d", s.rights);
            pencil_eigenvalues_clear(e, n);
            pencil_structure_clear(&s);
        }
        pencil_clear(&p);
        flint_free(t);
        flint_free(u);
        fmpz_clear(product);
        fmpz_clear(plus);
    }
}

static bool stop(void *ctx)
{
    (void)ctx;
    return true;
}

static void limits(void)
{
    struct pencil p;
    struct pencil_structure s;
    struct sga_error err = { 0 };
    struct sga_budget cancelled = { .cancelled = stop };
    struct pencil_options o = { .spectrum = true };
    pencil_init(&p, PENCIL_MAX + 1, 1);
    CHECK(!pencil_structure(&p, &o, &s, &err) && err.code == SGA_E_LIMIT_VARIABLES, "%s", err.detail);
    pencil_clear(&p);
    static const char *const one[] = { "1" };
    ordinary(&p, 1, one);
    o.budget = &cancelled;
    err = (struct sga_error){ 0 };
    CHECK(!pencil_structure(&p, &o, &s, &err) && err.code == SGA_E_CANCELLED, "%s", err.detail);
    pencil_clear(&p);
}

int main(void)
{
    decimals();
    look_alikes();
    misleading();
    limits();
    return CHECK_END();
}
