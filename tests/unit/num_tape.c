/* The tape against a plain walk over the nodes in long double, and its constants
 * against the rounding of strtod. */
#include "check.h"

#include <float.h>
#include <flint/fmpq.h>
#include <flint/fmpz.h>
#include <math.h>
#include <string.h>

#include "error.h"
#include "expr_rows.h"
#include "lu.h"
#include "random_expr.h"
#include "tape.h"

#define POOL 60
#define SYMBOLS 5

static struct random_source rng;

/* Gauss-Jordan with partial pivoting: x of the solve, into sol. */
static void solve_ld(const struct expr_solve *s, const long double *v, long double *sol)
{
    long double a[8][9];
    int m = s->m;
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < m; j++)
            a[i][j] = expr_rows_at(&s->matrix, i, j) ? v[expr_rows_at(&s->matrix, i, j)] : 0;
        a[i][m] = v[s->rhs[i]];
    }
    for (int k = 0; k < m; k++) {
        int p = k;
        for (int i = k; i < m; i++)
            if (fabsl(a[i][k]) > fabsl(a[p][k]))
                p = i;
        for (int j = 0; j <= m; j++) {
            long double t = a[k][j];
            a[k][j] = a[p][j];
            a[p][j] = t;
        }
        for (int i = 0; i < m; i++) {
            long double f = i == k ? 0 : a[i][k] / a[k][k];
            for (int j = k; j <= m; j++)
                a[i][j] -= f * a[k][j];
        }
    }
    for (int i = 0; i < m; i++)
        sol[i] = a[i][m] / a[i][i];
}

static long double walk_node(const struct expr_store *st, const struct expr_node *n, const long double *v, const double *in)
{
    long double x = v[n->a < st->nodes && n->a >= 0 ? n->a : 0];
    long double y = v[n->b < st->nodes && n->b >= 0 ? n->b : 0];
    switch ((enum expr_op)n->op) {
    case EXPR_CONST: {
        const fmpq *q = st->constant + n->a;    /* small in these tests */
        return (long double)fmpz_get_d(fmpq_numref(q)) / (long double)fmpz_get_d(fmpq_denref(q));
    }
    case EXPR_PI:   return acosl(-1);
    case EXPR_SYM:  return in[n->a];
    case EXPR_ADD:  return x + y;
    case EXPR_SUB:  return x - y;
    case EXPR_MUL:  return x * y;
    case EXPR_DIV:  return x / y;
    case EXPR_NEG:  return -x;
    case EXPR_POWI: return powl(x, n->b);
    case EXPR_POW:  return powl(x, y);
    case EXPR_SIN:  return sinl(x);
    case EXPR_COS:  return cosl(x);
    case EXPR_TAN:  return tanl(x);
    case EXPR_ASIN: return asinl(x);
    case EXPR_ACOS: return acosl(x);
    case EXPR_ATAN: return atanl(x);
    case EXPR_ATAN2: return atan2l(x, y);
    case EXPR_SINH: return sinhl(x);
    case EXPR_COSH: return coshl(x);
    case EXPR_TANH: return tanhl(x);
    case EXPR_ASINH: return asinhl(x);
    case EXPR_ACOSH: return acoshl(x);
    case EXPR_ATANH: return atanhl(x);
    case EXPR_EXP:  return expl(x);
    case EXPR_LOG:  return logl(x);
    case EXPR_SQRT: return sqrtl(x);
    case EXPR_CBRT: return cbrtl(x);
    case EXPR_ABS:  return fabsl(x);
    case EXPR_SIGN: return (x > 0) - (x < 0);
    case EXPR_MIN:  return x < y ? x : y;
    case EXPR_MAX:  return x > y ? x : y;
    case EXPR_SOLVE: {
        long double sol[8];
        solve_ld(st->solve + n->a, v, sol);
        return sol[n->b];
    }
    default: return NAN;
    }
}

static bool close_to(double got, long double want, double tol)
{
    return fabsl(got - want) <= tol * (1 + fabsl(want));
}

/* Keeps values moderate, so that errors stay near the last digit: bounded functions of
 * arguments in their domains. */
static expr_id tame(struct expr_store *st, const expr_id *pool, int n)
{
    expr_id a = pool[random_below(&rng, n)], b = pool[random_below(&rng, n)];
    expr_id one = expr_int(st, 1), aa = expr_add(st, expr_mul(st, a, a), one);
    expr_id unit = expr_div(st, a, aa);    /* in [-1/2, 1/2] */
    switch (random_below(&rng, 22)) {
    case 0: return expr_add(st, unit, b);
    case 1: return expr_sub(st, a, b);
    case 2: return expr_mul(st, unit, b);
    case 3: return expr_div(st, b, aa);
    case 4: return expr_powi(st, aa, -1 - random_below(&rng, 5));
    case 5: return expr_powi(st, unit, 2 + random_below(&rng, 6));
    case 6: return expr_pow(st, expr_div(st, one, aa), expr_rational(st, 1 + random_below(&rng, 5), 7));
    case 7: return expr_fun(st, EXPR_SIN, a);
    case 8: return expr_fun(st, EXPR_COS, a);
    case 9: return expr_fun(st, (enum expr_op)(EXPR_ASIN + random_below(&rng, 3)), unit);
    case 10: return expr_fun2(st, EXPR_ATAN2, b, aa);
    case 11: return expr_fun(st, (enum expr_op)(EXPR_SINH + random_below(&rng, 3)), unit);
    case 12: return expr_fun(st, EXPR_ASINH, a);
    case 13: return expr_fun(st, EXPR_ACOSH, expr_add(st, aa, one));
    case 14: return expr_fun(st, EXPR_ATANH, unit);
    case 15: return expr_fun(st, EXPR_EXP, unit);
    case 16: return expr_fun(st, EXPR_LOG, aa);
    case 17: return expr_fun(st, EXPR_SQRT, aa);
    case 18: return expr_fun(st, EXPR_CBRT, expr_add(st, aa, b));
    case 19: return expr_fun(st, EXPR_ABS, a);
    case 20: return expr_fun2(st, random_below(&rng, 2) ? EXPR_MIN : EXPR_MAX, a, b);
    default: return expr_fun(st, EXPR_TAN, unit);
    }
}

/* A dominant diagonal: a solve that is far from singular; gives one component. */
static expr_id tame_solve(struct expr_store *st, const expr_id *pool, int n)
{
    enum { M = 4 };
    expr_id a[M * M], r[M];
    for (int i = 0; i < M * M; i++)
        a[i] = expr_fun(st, EXPR_SIN, pool[random_below(&rng, n)]);
    for (int i = 0; i < M; i++) {
        a[i * M + (i + 1) % M] = expr_add(st, a[i * M + (i + 1) % M], expr_int(st, 9));    /* rows out of order */
        r[i] = pool[random_below(&rng, n)];
    }
    int s = expr_solve_add(st, M, a, r);
    return expr_add(st, expr_solution(st, s, random_below(&rng, M)), expr_solution(st, s, random_below(&rng, M)));
}

static void random_tape(void)
{
    struct expr_store st;
    expr_id pool[POOL];
    int inputs[SYMBOLS], n = 0;
    double in[SYMBOLS], out[POOL], by_symbol[SYMBOLS];
    expr_store_init(&st);
    for (; n < SYMBOLS; n++) {
        char name[8];
        sprintf(name, "x%d", n);
        pool[n] = expr_symbol_add(&st, name, EXPR_VARIABLE);
        inputs[n] = SYMBOLS - 1 - n;    /* an order of its own */
    }
    pool[n++] = expr_rational(&st, 1, 3);
    pool[n++] = expr_pi(&st);
    for (; n < POOL; n++)
        pool[n] = n % 20 == 19 ? tame_solve(&st, pool, n) : tame(&st, pool, n);
    struct sga_error err = { 0 };
    struct num_tape *t = num_tape_new(&st, pool, POOL, inputs, SYMBOLS, &err);
    CHECK(t && num_tape_inputs(t) == SYMBOLS && num_tape_roots(t) == POOL, "%s", err.detail);
    long double *v = calloc((size_t)st.nodes, sizeof *v);
    for (int point = 0; t && point < 5; point++) {
        for (int i = 0; i < SYMBOLS; i++)
            by_symbol[inputs[i]] = in[i] = random_unit(&rng) * 2;
        for (expr_id e = 1; e < st.nodes; e++)
            v[e] = walk_node(&st, st.node + e, v, by_symbol);
        num_tape_eval(t, in, out);
        for (int i = 0; i < POOL; i++)
            if (isfinite((double)v[pool[i]]))
                CHECK(close_to(out[i], v[pool[i]], 1e-9), "root %d: %.17g, %.17Lg", i, out[i], v[pool[i]]);
    }
    free(v);
    num_tape_free(t);
    expr_store_clear(&st);
}

static void constants(void)
{
    static const char *const text[] = {
        "0.1", "1e-5", "3.14159265358979323846264338327950288", "5e-324", "2.4703282292062328e-324",
        "2.4703282292062327e-324", "2.2250738585072011e-308", "1.7976931348623157e308", "-9007199254740993",
        "9007199254740993", "9007199254740995", "123456789012345678901234567890", "-1e-320", "7.4109846876186981626485318930233205854758970392148714663837852375101326090531312779794975454245398856969484704316857659638998506553390969459816219401617281718945106978546710679176872575177347315553307795408549809608457500958111373034747658096871009590975442271004757307809711118935784838675653998783503015228055934046593739791790738723868299395818481660169122019456499931289798411362062484498678713572180352209017023903285791732520220528974020802906854021606612375549983402671300035812486479041385743401875520901590172592547146296175134159774938718574737870961645638908718119841271673056017045493004705269590165763776884908267986972573366521765567941072508764337560846003984904972149117463085539556354188641513168478436313080237596295773983001708984374999999e-324"
    };
    struct expr_store st;
    expr_store_init(&st);
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        /* digits and exponent to an exact rational */
        char digits[1200];
        int n = 0, scale = 0, point = 0;
        const char *s = text[i];
        for (; *s && *s != 'e'; s++) {
            if (*s == '.') {
                point = 1;
                continue;
            }
            digits[n++] = *s;
            scale += point && *s != '-';
        }
        digits[n] = 0;
        long exponent = (*s ? atol(s + 1) : 0) - scale;
        fmpq_t q;
        fmpz_t ten;
        fmpq_init(q);
        fmpz_init(ten);
        fmpz_set_str(fmpq_numref(q), digits, 10);
        fmpz_set_ui(ten, 10);
        fmpz_pow_ui(ten, ten, (ulong)labs(exponent));
        if (exponent < 0)
            fmpq_div_fmpz(q, q, ten);
        else
            fmpq_mul_fmpz(q, q, ten);
        expr_id e = expr_fmpq(&st, q);
        double out, want = strtod(text[i], NULL);
        struct num_tape *t = num_tape_new(&st, &e, 1, NULL, 0, NULL);
        CHECK(num_tape_eval(t, NULL, &out) && out == want, "%.30s: %.17g, %.17g", text[i], out, want);
        CHECK(num_tape_length(t) == 0, "a constant has no code");
        num_tape_free(t);
        fmpz_clear(ten);
        fmpq_clear(q);
    }
    expr_store_clear(&st);
}

static void refusals_and_domain(void)
{
    struct expr_store st;
    expr_store_init(&st);
    expr_id x = expr_symbol_add(&st, "x", EXPR_VARIABLE), y = expr_symbol_add(&st, "y", EXPR_VARIABLE);
    expr_id one = expr_int(&st, 1), wide = expr_add(&st, x, one);    /* zero: (x+1)^2 - x^2 - (2x+1) */
    expr_id zero = expr_sub(&st, expr_sub(&st, expr_powi(&st, wide, 2), expr_powi(&st, x, 2)), expr_add(&st, wide, x));
    expr_id matrix[4] = { x, x, x, expr_add(&st, x, zero) }, rhs[2] = { x, y };
    int solve = expr_solve_add(&st, 2, matrix, rhs), both[2] = { 0, 1 };
    expr_id root[8] = {
        expr_fun(&st, EXPR_LOG, x), expr_fun(&st, EXPR_SQRT, x), expr_pow(&st, x, y), expr_fun(&st, EXPR_ASIN, expr_sub(&st, x, expr_int(&st, 2))),
        expr_div(&st, y, zero), expr_solution(&st, solve, 0), expr_fun2(&st, EXPR_MIN, expr_fun(&st, EXPR_LOG, x), y),
        expr_fun2(&st, EXPR_MAX, y, expr_fun(&st, EXPR_LOG, x))
    };
    struct sga_error err = { 0 };
    CHECK(!num_tape_new(&st, root, 3, both, 1, &err) && err.code == SGA_E_EXPR_NAME, "%s", err.detail);
    err = (struct sga_error){ 0 };
    expr_id nothing = EXPR_UNDEF;
    CHECK(!num_tape_new(&st, &nothing, 1, both, 2, &err) && err.code == SGA_E_EXPR_UNDEFINED, "%s", err.detail);
    double in[2] = { -1, 0.5 }, out[8];
    for (int i = 0; i < 8; i++) {
        struct num_tape *t = num_tape_new(&st, root + i, 1, both, 2, NULL);
        CHECK(t && !num_tape_eval(t, in, out), "root %d: %g", i, out[0]);
        CHECK(i == 4 ? isinf(out[0]) : isnan(out[0]), "root %d: %g", i, out[0]);
        num_tape_free(t);
    }
    struct num_tape *t = num_tape_new(&st, root, 3, both, 2, NULL);
    in[0] = 2;
    CHECK(num_tape_eval(t, in, out) && out[1] == sqrt(2) && out[2] == pow(2, 0.5), "%g", out[0]);
    num_tape_free(t);
    t = num_tape_new(&st, NULL, 0, both, 2, NULL);
    CHECK(t && num_tape_eval(t, in, out), "no roots");
    num_tape_free(t);
    expr_store_clear(&st);
}

/* sin and cos of one argument, one solve with all its components, constant parts. */
static void sharing(void)
{
    struct expr_store st;
    expr_store_init(&st);
    expr_id x = expr_symbol_add(&st, "x", EXPR_VARIABLE), two = expr_int(&st, 2);
    expr_id s = expr_fun(&st, EXPR_SIN, x), c = expr_fun(&st, EXPR_COS, x);
    expr_id matrix[4] = { s, c, expr_neg(&st, c), s }, rhs[2] = { x, two };
    int solve = expr_solve_add(&st, 2, matrix, rhs), input = 0;
    expr_id root[4] = { c, s, expr_solution(&st, solve, 0), expr_solution(&st, solve, 1) };
    struct num_tape *t = num_tape_new(&st, root, 4, &input, 1, NULL);
    double in = 0.7, out[4];
    CHECK(num_tape_length(t) == 2 + 1 + 1 + 2, "%d", num_tape_length(t));
    CHECK(num_tape_eval(t, &in, out) && out[0] == cos(in) && out[1] == sin(in), "%g", out[0]);
    CHECK(close_to(out[2], sin(in) * in - cos(in) * 2, 1e-15) && close_to(out[3], cos(in) * in + sin(in) * 2, 1e-15),
          "%g %g", out[2], out[3]);
    num_tape_free(t);
    expr_id still = expr_mul(&st, expr_fun(&st, EXPR_SQRT, two), expr_fun(&st, EXPR_SIN, two));
    expr_id sum = expr_add(&st, still, x);
    t = num_tape_new(&st, &sum, 1, &input, 1, NULL);
    CHECK(num_tape_length(t) == 1, "%d", num_tape_length(t));
    CHECK(num_tape_eval(t, &in, out) && out[0] == sqrt(2) * sin(2) + in, "%g", out[0]);
    num_tape_free(t);
    expr_store_clear(&st);
}

static void linear_solves(void)
{
    enum { M = 12 };
    double a[M * M], lu[M * M], b[M], x[M], y[M], w[M];
    int perm[M];
    for (int i = 0; i < M * M; i++)
        a[i] = lu[i] = random_below(&rng, 3) ? random_unit(&rng) : 0;
    for (int i = 0; i < M; i++)
        b[i] = w[i] = random_unit(&rng);
    if (!num_lu_factor(lu, perm, M))
        return;    /* zeros may make it singular */
    num_lu_solve(lu, perm, M, b, x);
    num_lu_solve_transposed(lu, perm, M, w, y);
    double r = 0, rt = 0, nx = 0, ny = 0;
    for (int i = 0; i < M; i++) {
        double s = -b[i], st = -b[i];
        for (int j = 0; j < M; j++) {
            s += a[i * M + j] * x[j];
            st += a[j * M + i] * y[j];
        }
        r = fmax(r, fabs(s));
        rt = fmax(rt, fabs(st));
        nx = fmax(nx, fabs(x[i]));
        ny = fmax(ny, fabs(y[i]));
    }
    CHECK(r < 1e-13 * (1 + nx) && rt < 1e-13 * (1 + ny), "%g %g", r, rt);
}

int main(void)
{
    rng.state = check_seed(4711);
    int n = check_scale(200);
    for (int i = 0; i < n; i++)
        random_tape();
    for (int i = 0; i < n; i++)
        linear_solves();
    constants();
    refusals_and_domain();
    sharing();
    flint_cleanup();
    return CHECK_END();
}
