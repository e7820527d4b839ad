/* Real zeros of polynomial systems: closed forms, Sturm's count for one variable, and systems whose zeros were chosen, seen through mixed equations. */
#include "real_zeros.h"

#include <flint/fmpz_poly.h>
#include <string.h>

#include "check.h"
#include "error.h"
#include "parse.h"

enum { MOST = 8 };

static struct expr_store st;
static const char *const NAME[] = { "x", "y", "z" };
static int symbol[3];
static unsigned long state;

static int random_below(int n)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (int)((state >> 40) % (unsigned long)n);
}

static expr_id parsed(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

static void counted(const char *const *text, int variables, enum poly_count should, long real)
{
    expr_id e[MOST];
    int n = 0;
    struct poly_real_zeros z;
    for (; n < MOST && text[n]; n++)
        e[n] = parsed(text[n]);
    enum poly_count got = poly_real_zeros(&st, e, n, symbol, variables, NULL, &z);
    CHECK(got == should && (should != POLY_COUNTED || z.real == real), "%s, ...: %d with %ld, not %d with %ld", text[0], got, z.real, should, real);
    if (z.over)
        CHECK(fmpz_poly_num_real_roots(z.root) == real, "%s, ...: by roots %ld, not %ld", text[0], (long)fmpz_poly_num_real_roots(z.root), real);
    else
        CHECK(got != POLY_COUNTED || real == 0, "%s, ...: no form tells the zeros from each other", text[0]);
    poly_real_zeros_clear(&z);
}

static void closed_forms(void)
{
    counted((const char *const[]){ "x^2 + 1", NULL }, 1, POLY_COUNTED, 0);
    counted((const char *const[]){ "(x - 1)^2*(x + 2)^3*(x^2 + x + 1)", NULL }, 1, POLY_COUNTED, 2);
    counted((const char *const[]){ "x^2 + y^2 - 1", "x - y", NULL }, 2, POLY_COUNTED, 2);
    counted((const char *const[]){ "x^2 + y^2 - 1", "x - 1", NULL }, 2, POLY_COUNTED, 1);          /* touches */
    counted((const char *const[]){ "x^2 + y^2 - 1", "x - 2", NULL }, 2, POLY_COUNTED, 0);
    counted((const char *const[]){ "x*y - 1", "x", NULL }, 2, POLY_COUNTED, 0);                    /* contradicts */
    counted((const char *const[]){ "x^2 + y^2", NULL }, 2, POLY_MANY, 0);                          /* one real point, lines over the complex numbers */
    counted((const char *const[]){ "x*(y - 1)", "y*(y - 1)", NULL }, 2, POLY_MANY, 0);
    counted((const char *const[]){ "x - y", "x - y", NULL }, 2, POLY_MANY, 0);
    counted((const char *const[]){ "x - 1", NULL }, 2, POLY_MANY, 0);                              /* y is in no equation */
    counted((const char *const[]){ "10*(y - x)", "x*(28 - z) - y", "x*y - 8/3*z", NULL }, 3, POLY_COUNTED, 3);     /* Lorenz (1963) */
    counted((const char *const[]){ "x + y + z", "x*y + y*z + z*x", "x*y*z - 1", NULL }, 3, POLY_COUNTED, 0);       /* cyclic 3: cube roots of 1 */
    counted((const char *const[]){ "x*y^2 + x*z^2 - 11/10*x + 1", "y*x^2 + y*z^2 - 11/10*y + 1", "z*x^2 + z*y^2 - 11/10*z + 1", NULL }, 3, POLY_COUNTED, 7);   /* Noonburg 3: SymPy's real roots */
    counted((const char *const[]){ "x*(1/x - 1)", "sin(x) - y", "y - 3", NULL }, 2, POLY_COUNTED, 1);              /* a numerator; and what is no polynomial only leaves more */
    counted((const char *const[]){ "sin(x)", NULL }, 1, POLY_MANY, 0);
    counted((const char *const[]){ "x^70 - 2", NULL }, 1, POLY_NOT_COUNTED, 0);                    /* a higher degree than is worked with */
    counted((const char *const[]){ "x^11 - 2", "y^10 + 1", NULL }, 2, POLY_NOT_COUNTED, 0);          /* more zeros */
    counted((const char *const[]){ "x^7 - 2", "y^8 - 1", NULL }, 2, POLY_COUNTED, 2);
}

/* A random polynomial of one variable, as text and as FLINT has it. */
static void against_sturm(void)
{
    fmpz_poly_t p, even, d;
    fmpz_poly_init(p);
    fmpz_poly_init(even);
    fmpz_poly_init(d);
    for (int round = 0; round < 60; round++) {
        int degree = 1 + random_below(7), roots = random_below(3);
        char text[400];
        size_t at = 0;
        fmpz_poly_zero(p);
        at += (size_t)snprintf(text + at, sizeof text - at, "(0");
        for (int k = 0; k <= degree; k++) {
            int c = random_below(21) - 10;
            fmpz_poly_set_coeff_si(p, k, c);
            at += (size_t)snprintf(text + at, sizeof text - at, " + (%d)*x^%d", c, k);
        }
        at += (size_t)snprintf(text + at, sizeof text - at, ")");
        for (int k = 0; k < roots; k++) {
            int r = random_below(7) - 3;
            fmpz_poly_zero(d);
            fmpz_poly_set_coeff_si(d, 1, 1);
            fmpz_poly_set_coeff_si(d, 0, -r);
            fmpz_poly_mul(p, p, d);
            at += (size_t)snprintf(text + at, sizeof text - at, "*(x - (%d))", r);
        }
        if (fmpz_poly_is_zero(p))
            continue;
        fmpz_poly_derivative(d, p);
        fmpz_poly_gcd(d, p, d);
        fmpz_poly_div(even, p, d);             /* each root once */
        counted((const char *const[]){ text, NULL }, 1, POLY_COUNTED, fmpz_poly_num_real_roots(even));
    }
    fmpz_poly_clear(p);
    fmpz_poly_clear(even);
    fmpz_poly_clear(d);
}

/* x among some numbers (and complex pairs), y a shift of x^2 among others: as many points as pairs; equations mixed by a matrix of determinant 1. */
static void chosen(void)
{
    for (int round = 0; round < 40; round++) {
        int many[2], a = random_below(5) - 2, b = random_below(5) - 2;
        char f[2][200], text[2][600];
        for (int k = 0; k < 2; k++) {
            int first = random_below(5) - 2;
            size_t at = 0;
            many[k] = random_below(3);
            at += (size_t)snprintf(f[k], sizeof f[k], "((%s)^2 + %d)", k ? "y - x^2" : "x", 1 + random_below(3));
            for (int r = 0; r < many[k]; r++)
                at += (size_t)snprintf(f[k] + at, sizeof f[k] - at, "*(%s - (%d))", k ? "y - x^2" : "x", first + r);
        }
        snprintf(text[0], sizeof text[0], "%s + (%d)*%s", f[0], a, f[1]);
        snprintf(text[1], sizeof text[1], "(%d)*%s + (%d)*%s", b, f[0], a * b + 1, f[1]);
        counted((const char *const[]){ text[0], text[1], NULL }, 2, POLY_COUNTED, (long)many[0] * many[1]);
    }
}

int main(void)
{
    expr_store_init(&st);
    state = check_seed(20261126);
    for (int k = 0; k < 3; k++) {
        expr_symbol_add(&st, NAME[k], EXPR_VARIABLE);
        symbol[k] = st.symbols - 1;
    }
    closed_forms();
    against_sturm();
    chosen();
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
