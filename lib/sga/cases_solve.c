/* One irreducible condition solved for a parameter: f = a u^2 + b u + c or a u + c, u a power of it. */
#include "cases_solve.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "ball.h"
#include "cases.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "system.h"

enum { BITS = 256, ENOUGH = 100000 };

struct cases_space cases_space_of(const struct sys_system *system, const struct sga_budget *budget)
{
    return (struct cases_space){
        .st = system->store, .system = system,
        .limits = poly_limits_of(POLY_MODEST, budget),
    };
}

expr_id cases_at(struct expr_store *st, expr_id e, const struct cases_put *put, int puts)
{
    struct sga_error before = *st->error;
    if (!e || !puts)
        return e;
    SGA_FREED expr_id *map = sga_calloc((size_t)st->symbols, sizeof *map);
    for (int i = 0; i < puts; i++)
        map[put[i].symbol] = put[i].value;
    expr_substitute(st, &e, 1, map);
    if (st->error->code == SGA_E_EXPR_UNDEFINED) {     /* a denominator vanishes there */
        *st->error = before;
        return EXPR_UNDEF;
    }
    return e;
}

expr_id cases_replace(const struct cases_space *s, expr_id e, const struct cases_put *put, int puts)
{
    expr_id from = e;
    e = cases_at(s->st, e, put, puts);
    if (e && e != from)
        poly_normal(s->st, e, &s->limits, &e);
    return e;
}

/* The sign of a number: 1, -1, or 0 where it is not known, or no number. */
static int sign_of(const struct cases_space *s, expr_id e)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    int sign = 0;
    bool number = e != EXPR_UNDEF;
    expr_cone_init(&cone);
    expr_cone_of(s->st, &cone, &e, 1);
    for (int i = 0; i < cone.count; i++)
        number = number && expr_op_of(s->st, cone.list[i]) != EXPR_SYM;
    if (number) {
        SGA_ENDS(num_ball_clear) struct num_ball b;
        num_ball_init(&b, s->st, BITS);
        num_ball_list(&b, cone.list, cone.count);
        arb_srcptr v = num_ball_value(&b, e);
        sign = !arb_is_finite(v) ? 0 : arb_is_positive(v) ? 1 : arb_is_negative(v) ? -1 : 0;
    }
    return sign;
}

enum cases_truth cases_zero(const struct cases_space *s, expr_id e)
{
    if (!e)
        return CASES_NEVER;          /* no value there */
    if (expr_is_zero(s->st, e))
        return CASES_ZERO;
    return sign_of(s, e) ? CASES_NEVER : CASES_OPEN;
}

/* f as a polynomial in one parameter, by the powers that occur. */
struct shape {
    int symbol, degree, step;        /* powers are multiples of step */
    expr_id *k;
};

static bool shape_of(const struct expr_store *st, struct poly_numerator *n, int symbol, struct shape *out)
{
    *out = (struct shape){ .symbol = symbol };
    if (!poly_powers_of(n, st->symbol[symbol].node, &out->k, &out->degree))
        return false;
    for (int i = 1; i <= out->degree; i++) {
        if (expr_is_zero(st, out->k[i]))
            continue;
        int x = out->step, y = i;
        while (x) {
            int r = y % x;
            y = x;
            x = r;
        }
        out->step = y;
    }
    return true;
}

static bool rational(const struct expr_store *st, const struct shape *p)
{
    bool all = true;
    for (int i = 0; i <= p->degree; i++)
        all = all && expr_is_const(st, p->k[i]);
    return all;
}

/* Affine with a number before plain powers before anything with a coefficient that may vanish. */
static long cost_of(const struct cases_space *s, const struct shape *p)
{
    long order = p->step ? p->degree / p->step : 0;
    bool number = sign_of(s, p->k[p->degree]) != 0;
    if (order == 3 && p->step == 1 && rational(s->st, p))
        return 1000;
    if (order < 1 || order > 2)
        return ENOUGH;
    return (order == 1 && p->step == 1 ? 0 : 100 * p->degree) + (number ? 0 : 10);
}

static expr_id root(const struct cases_space *s, expr_id u, int n)
{
    struct expr_store *st = s->st;
    for (; n % 2 == 0; n /= 2)
        u = expr_fun(st, EXPR_SQRT, u);
    for (; n % 3 == 0; n /= 3)
        u = expr_fun(st, EXPR_CBRT, u);
    if (n == 1)
        return u;
    int sign = sign_of(s, u);
    expr_id part = expr_rational(st, 1, n);
    if (sign)
        return sign > 0 ? expr_pow(st, u, part) : expr_neg(st, expr_pow(st, expr_neg(st, u), part));
    return expr_mul(st, expr_fun(st, EXPR_SIGN, u), expr_pow(st, expr_fun(st, EXPR_ABS, u), part));
}

/* The real roots of x^n = u. */
static void add_roots(const struct cases_space *s, struct cases_roots *r, expr_id u, int n)
{
    struct expr_store *st = s->st;
    poly_normal(st, u, &s->limits, &u);
    if (n % 2 == 0 && sign_of(s, u) < 0)
        return;
    expr_id x = root(s, u, n);
    poly_normal(st, x, &s->limits, &x);
    r->value[r->count++] = x;
    if (n % 2 == 0)
        r->value[r->count++] = expr_neg(st, x);
}

static void third_of(fmpq_t out, const fmpq_t x)
{
    SGA_ENDS(fmpz_end) fmpz_t three;
    fmpz_init_set_ui(three, 3);
    fmpq_div_fmpz(out, x, three);
}

/* The real roots of a cubic with rational coefficients, x = u - b/(3 a): Cardano's where there is one, Viete's where there
 * are three. */
static void solve_cubic(const struct cases_space *s, const struct shape *p, struct cases_roots *r)
{
    struct expr_store *st = s->st;
    fmpq_t a[3];
    SGA_ENDS(fmpq_end) fmpq_t P = { { 0, 1 } }, Q = { { 0, 1 } }, D = { { 0, 1 } }, t = { { 0, 1 } };
    for (int i = 0; i < 3; i++) {
        fmpq_init(a[i]);
        fmpq_div(a[i], expr_const_value(st, p->k[i]), expr_const_value(st, p->k[3]));
    }
    third_of(t, a[2]);                    /* x^3 + a2 x^2 + a1 x + a0, t = a2/3: P = a1 - 3 t^2, Q = 2 t^3 - t a1 + a0 */
    fmpq_mul(D, t, t);
    fmpq_mul_si(P, D, -3);
    fmpq_add(P, P, a[1]);
    fmpq_mul(Q, D, t);
    fmpq_mul_si(Q, Q, 2);
    fmpq_submul(Q, t, a[1]);
    fmpq_add(Q, Q, a[0]);
    third_of(P, P);                       /* u^3 + 3 P u + 2 Q, D = Q^2 + P^3 */
    fmpq_div_2exp(Q, Q, 1);
    fmpq_mul(D, P, P);
    fmpq_mul(D, D, P);
    fmpq_addmul(D, Q, Q);
    expr_id shift = expr_fmpq(st, t), q = expr_fmpq(st, Q), minus = expr_neg(st, expr_fmpq(st, P));
    if (fmpq_sgn(D) >= 0) {
        expr_id root = expr_fun(st, EXPR_SQRT, expr_fmpq(st, D));
        expr_id u = expr_sub(st, expr_fun(st, EXPR_CBRT, expr_sub(st, root, q)), expr_fun(st, EXPR_CBRT, expr_add(st, root, q)));
        r->value[r->count++] = expr_sub(st, u, shift);
    } else {
        expr_id size = expr_fun(st, EXPR_SQRT, minus);
        expr_id angle = expr_fun(st, EXPR_ACOS, expr_neg(st, expr_div(st, q, expr_mul(st, minus, size))));
        for (int k = 0; k < 3; k++) {
            expr_id part = expr_div(st, expr_add(st, angle, expr_mul(st, expr_int(st, 2 * k), expr_pi(st))), expr_int(st, 3));
            r->value[r->count++] = expr_sub(st, expr_mul(st, expr_mul(st, expr_int(st, 2), size), expr_fun(st, EXPR_COS, part)), shift);
        }
    }
    for (int i = 0; i < 3; i++)
        fmpq_clear(a[i]);
}

static void solve_shape(const struct cases_space *s, const struct shape *p, struct cases_roots *r)
{
    struct expr_store *st = s->st;
    expr_id a = p->k[p->degree], c = p->k[0];
    r->symbol = p->symbol;
    r->leading = sign_of(s, a) ? EXPR_UNDEF : a;
    if (p->degree == 3 * p->step) {
        solve_cubic(s, p, r);
        return;
    }
    if (p->degree == p->step) {
        add_roots(s, r, expr_neg(st, expr_div(st, c, a)), p->step);
        return;
    }
    expr_id b = p->k[p->step], d = expr_sub(st, expr_powi(st, b, 2), expr_mul(st, expr_int(st, 4), expr_mul(st, a, c)));
    poly_normal(st, d, &s->limits, &d);
    if (sign_of(s, d) < 0)
        return;
    expr_id q = expr_fun(st, EXPR_SQRT, d), two_a = expr_mul(st, expr_int(st, 2), a);
    add_roots(s, r, expr_div(st, expr_sub(st, q, b), two_a), p->step);
    add_roots(s, r, expr_div(st, expr_neg(st, expr_add(st, q, b)), two_a), p->step);
}

static int by_name(const struct expr_store *st, int a, int b)
{
    return strcmp(st->symbol[a].name, st->symbol[b].name);
}

/* What the argument of a function equals where the function equals w; EXPR_UNDEF: it cannot, or does at many values. *never: it
 * cannot. */
static expr_id inverse(const struct cases_space *s, enum expr_op op, expr_id w, bool *never)
{
    int sign = sign_of(s, w);
    bool zero = expr_is_zero(s->st, w);
    *never = (op == EXPR_EXP && (sign < 0 || zero)) || (op == EXPR_SQRT && sign < 0);
    if (*never || (op == EXPR_SQRT && !sign && !zero))
        return EXPR_UNDEF;
    return op == EXPR_EXP ? expr_fun(s->st, EXPR_LOG, w) : op == EXPR_LOG ? expr_fun(s->st, EXPR_EXP, w)
           : expr_powi(s->st, w, op == EXPR_SQRT ? 2 : 3);
}

/* f = a h(u) + b with a number a, h one of exp, log, sqrt and cbrt: then u is what is asked for. */
static bool solve_kernel(const struct cases_space *s, struct poly_numerator *n, expr_id f, struct cases_roots *r)
{
    struct expr_store *st = s->st;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    bool solved = false;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &f, 1);
    for (int i = 0; i < cone.count && n && !solved; i++) {
        const struct expr_node node = st->node[cone.list[i]];
        expr_id *k, u = EXPR_UNDEF;
        int degree;
        bool never = false;
        if ((node.op != EXPR_EXP && node.op != EXPR_LOG && node.op != EXPR_SQRT && node.op != EXPR_CBRT)
            || !poly_powers_of(n, cone.list[i], &k, &degree))
            continue;
        if (degree == 1 && sign_of(s, k[1])) {
            u = expr_neg(st, expr_div(st, k[0], k[1]));
            poly_normal(st, u, &s->limits, &u);
            u = inverse(s, (enum expr_op)node.op, u, &never);
        }
        if (u)
            r->instead = expr_sub(st, node.a, u);
        solved = u || never;
        free(k);
    }
    return solved;
}

bool cases_solve(const struct cases_space *s, expr_id f, struct cases_roots *roots)
{
    struct shape best = { .symbol = -1 };
    long least = ENOUGH;
    struct poly_numerator *n = poly_numerator_new(s->st, f, &s->limits);
    *roots = (struct cases_roots){ .function = n ? poly_numerator_shown(n) : f };
    for (int i = 0; i < s->system->parameters; i++) {
        struct shape p;
        if (!n || s->st->symbol[s->system->parameter[i]].kind != EXPR_PARAMETER || !shape_of(s->st, n, s->system->parameter[i], &p))
            continue;
        long cost = cost_of(s, &p);
        if (cost < least || (cost == least && least < ENOUGH && by_name(s->st, p.symbol, best.symbol) < 0)) {
            free(best.k);
            best = p;
            least = cost;
        } else {
            free(p.k);
        }
    }
    bool solved = least < ENOUGH;
    if (solved)
        solve_shape(s, &best, roots);
    else
        solved = solve_kernel(s, n, f, roots);
    poly_numerator_free(n);
    free(best.k);
    return solved;
}
