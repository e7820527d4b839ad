/* The evaluation of a program on a complex box.
 *
 * Every operator must be holomorphic on what its operands can be. Boxes are centred on real
 * points and all operators are real on the reals, so that each operand's enclosure meets the real line;
 * a branch cut on the real line is avoided if and only if the real part is. */
#include "disc.h"

#include <acb_mat.h>

enum { BITS = ENC_BOX_BITS };

/* low < real part < high. */
static bool between(const acb_t z, slong low, slong high)
{
    arb_t e;
    arb_init(e);
    arb_sub_si(e, acb_realref(z), low, BITS);
    bool ok = arb_is_positive(e);
    arb_sub_si(e, acb_realref(z), high, BITS);
    ok = ok && arb_is_negative(e);
    arb_clear(e);
    return ok;
}

/* |imaginary part| < 1 or real part not 0: off the cuts of atan and asinh (of z / i). */
static bool off_axis(const arb_t re, const arb_t im)
{
    arb_t e;
    arb_init(e);
    arb_abs(e, im);
    arb_sub_si(e, e, 1, BITS);
    bool ok = arb_is_negative(e) || !arb_contains_zero(re);
    arb_clear(e);
    return ok;
}

/* z^(1/k), by exp and log: Arb's roots are loose on wide balls. */
static void root(acb_t r, const acb_t z, ulong k)
{
    bool negative = k == 3 && arb_is_negative(acb_realref(z));
    acb_t w;
    acb_init(w);
    acb_set(w, z);
    if (negative)
        acb_neg(w, w);
    if (arb_is_positive(acb_realref(w))) {
        acb_log(w, w, BITS);
        acb_div_ui(w, w, k, BITS);
        acb_exp(r, w, BITS);
        if (negative)
            acb_neg(r, r);
    } else {
        acb_indeterminate(r);
    }
    acb_clear(w);
}

static void power(acb_t r, const acb_t z, const acb_t w)
{
    acb_t e;
    acb_init(e);
    acb_log(e, z, BITS);
    acb_mul(e, e, w, BITS);
    acb_exp(r, e, BITS);
    acb_clear(e);
}

static void function(acb_t r, enum expr_op f, const acb_t z, const acb_t w)
{
    arb_srcptr re = acb_realref(z), im = acb_imagref(z);
    bool ok = true;
    switch (f) {
    case EXPR_ASIN: case EXPR_ACOS: case EXPR_ATANH: ok = between(z, -1, 1); break;
    case EXPR_ACOSH: ok = between(z, 1, WORD_MAX); break;
    case EXPR_LOG: case EXPR_POW: ok = arb_is_positive(re); break;
    case EXPR_ATAN: ok = off_axis(re, im); break;
    case EXPR_ASINH: ok = off_axis(re, im); break;
    default: break;
    }
    if (!ok) {
        acb_indeterminate(r);
        return;
    }
    switch (f) {
    case EXPR_SIN:   acb_sin(r, z, BITS); break;
    case EXPR_COS:   acb_cos(r, z, BITS); break;
    case EXPR_TAN:   acb_tan(r, z, BITS); break;
    case EXPR_ASIN:  acb_asin(r, z, BITS); break;
    case EXPR_ACOS:  acb_acos(r, z, BITS); break;
    case EXPR_ATAN:  acb_atan(r, z, BITS); break;
    case EXPR_SINH:  acb_sinh(r, z, BITS); break;
    case EXPR_COSH:  acb_cosh(r, z, BITS); break;
    case EXPR_TANH:  acb_tanh(r, z, BITS); break;
    case EXPR_ASINH: acb_asinh(r, z, BITS); break;
    case EXPR_ACOSH: acb_acosh(r, z, BITS); break;
    case EXPR_ATANH: acb_atanh(r, z, BITS); break;
    case EXPR_EXP:   acb_exp(r, z, BITS); break;
    case EXPR_LOG:   acb_log(r, z, BITS); break;
    case EXPR_CBRT:  root(r, z, 3); break;
    case EXPR_POW:   power(r, z, w); break;
    default:         acb_indeterminate(r); break;
    }
}

/* atan2(y, x) by the chart that holds the box: the argument of x + i y for real x, y. */
static void arc_tangent(acb_t r, const acb_t y, const acb_t x)
{
    acb_t q;
    arb_t half;
    acb_init(q);
    arb_init(half);
    int right = arb_is_positive(acb_realref(x)), up = arb_is_positive(acb_realref(y)), down = arb_is_negative(acb_realref(y));
    acb_indeterminate(r);
    if (right)
        acb_div(q, y, x, BITS);
    else
        acb_div(q, x, y, BITS);
    if ((right || up || down) && acb_is_finite(q) && off_axis(acb_realref(q), acb_imagref(q))) {
        acb_atan(r, q, BITS);
        if (!right) {
            arb_const_pi(half, BITS);
            arb_mul_2exp_si(half, half, -1);
            if (down)
                arb_neg(half, half);
            acb_sub_arb(r, r, half, BITS);
            acb_neg(r, r);
        }
    }
    acb_clear(q);
    arb_clear(half);
}

/* The branch must be the same on the whole box. */
static void choice(acb_t r, enum expr_op f, const acb_t z, const acb_t w)
{
    arb_t e;
    arb_init(e);
    if (f == EXPR_MIN || f == EXPR_MAX)
        arb_sub(e, acb_realref(z), acb_realref(w), BITS);
    else
        arb_set(e, acb_realref(z));
    int sign = arb_is_positive(e) ? 1 : arb_is_negative(e) ? -1 : 0;
    if (!sign)
        acb_indeterminate(r);
    else if (f == EXPR_SIGN)
        acb_set_si(r, sign);
    else if (f == EXPR_ABS)
        sign > 0 ? acb_set(r, z) : acb_neg(r, z);
    else
        acb_set(r, (sign > 0) == (f == EXPR_MAX) ? z : w);
    arb_clear(e);
}

static void solve(struct enc_disc *c, const struct enc_system *q)
{
    int m = q->m;
    acb_mat_t S, r, y;
    acb_mat_init(S, m, m);
    acb_mat_init(r, m, 1);
    acb_mat_init(y, m, 1);
    for (int i = 0; i < m; i++) {
        acb_set(acb_mat_entry(r, i, 0), c->value + q->rhs[i]);
        for (int j = 0; j < m; j++)
            acb_set(acb_mat_entry(S, i, j), c->value + q->matrix[i * m + j]);
    }
    bool ok = acb_mat_solve_precond(y, S, r, BITS) || acb_mat_solve_lu(y, S, r, BITS);
    for (int i = 0; i < m; i++) {
        acb_set(c->value + q->first + i, acb_mat_entry(y, i, 0));
        if (!ok)
            acb_indeterminate(c->value + q->first + i);
    }
    acb_mat_clear(S);
    acb_mat_clear(r);
    acb_mat_clear(y);
}

static void eval(struct enc_disc *c, int i)
{
    const struct enc_code *k = c->p->code + i;
    acb_ptr v = c->value, r = v + i;
    switch (k->op) {
    case ENC_INPUT: break;
    case ENC_ADD:  acb_add(r, v + k->a, v + k->b, BITS); break;
    case ENC_SUB:  acb_sub(r, v + k->a, v + k->b, BITS); break;
    case ENC_NEG:  acb_neg(r, v + k->a); break;
    case ENC_MUL:  k->a == k->b ? acb_sqr(r, v + k->a, BITS) : acb_mul(r, v + k->a, v + k->b, BITS); break;
    case ENC_DIV:  acb_div(r, v + k->a, v + k->b, BITS); break;
    case ENC_SQRT: root(r, v + k->a, 2); break;
    case ENC_FUN:    function(r, k->fun, v + k->a, v + k->b); break;
    case ENC_ATAN2:  arc_tangent(r, v + k->a, v + k->b); break;
    case ENC_CHOICE: choice(r, k->fun, v + k->a, v + k->b); break;
    case ENC_SOLVE:
        if (k->b == 0)
            solve(c, c->p->system + k->a);
        break;
    default: break;
    }
}

/* Constants need no domain around them. */
static void eval_constant(struct enc_disc *c, int i)
{
    const struct enc_code *k = c->p->code + i;
    acb_ptr r = c->value + i;
    arb_zero(acb_imagref(r));
    bool leaf = k->op == ENC_INTEGER || k->op == ENC_CONSTANT;
    acb_srcptr a = leaf ? r : c->value + k->a;
    enc_value(acb_realref(r), c->p, k, acb_realref(a), acb_realref(c->value + k->b), BITS);
}

bool enc_box_values(struct enc_disc *c)
{
    const struct enc_program *p = c->p;
    for (int i = p->n + 1; i < p->slots; i++) {
        if (p->code[i].aux)
            continue;
        if (p->code[i].varies || p->code[i].op == ENC_SOLVE)
            eval(c, i);
        else
            eval_constant(c, i);
        if (!acb_is_finite(c->value + i))
            return false;
    }
    return true;
}
