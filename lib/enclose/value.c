/* The value of one step of a program, in real balls. */
#include "program.h"

/* x^(1/3), negative for negative x. */
static void cube_root(arb_t r, const arb_t x, slong prec)
{
    bool negative = arb_is_negative(x);
    arb_t a;
    arb_init(a);
    arb_set(a, x);
    if (negative)
        arb_neg(a, a);
    arb_root_ui(r, a, 3, prec);
    if (negative)
        arb_neg(r, r);
    arb_clear(a);
}

static void function(arb_t r, enum expr_op f, arb_srcptr x, arb_srcptr y, slong p)
{
    switch (f) {
    case EXPR_SIN:   arb_sin(r, x, p); break;
    case EXPR_COS:   arb_cos(r, x, p); break;
    case EXPR_TAN:   arb_tan(r, x, p); break;
    case EXPR_ASIN:  arb_asin(r, x, p); break;
    case EXPR_ACOS:  arb_acos(r, x, p); break;
    case EXPR_ATAN:  arb_atan(r, x, p); break;
    case EXPR_SINH:  arb_sinh(r, x, p); break;
    case EXPR_COSH:  arb_cosh(r, x, p); break;
    case EXPR_TANH:  arb_tanh(r, x, p); break;
    case EXPR_ASINH: arb_asinh(r, x, p); break;
    case EXPR_ACOSH: arb_acosh(r, x, p); break;
    case EXPR_ATANH: arb_atanh(r, x, p); break;
    case EXPR_EXP:   arb_exp(r, x, p); break;
    case EXPR_LOG:   arb_log(r, x, p); break;
    case EXPR_CBRT:  cube_root(r, x, p); break;
    case EXPR_POW:   arb_pow(r, x, y, p); break;
    case EXPR_ABS:   arb_abs(r, x); break;
    case EXPR_SIGN:  arb_sgn(r, x); break;
    case EXPR_MIN:   arb_min(r, x, y, p); break;
    case EXPR_MAX:   arb_max(r, x, y, p); break;
    default:         arb_indeterminate(r); break;
    }
}

void enc_value(arb_t r, const struct enc_program *program, const struct enc_code *c, arb_srcptr x, arb_srcptr y, slong p)
{
    switch (c->op) {
    case ENC_INTEGER: arb_set_si(r, c->a); break;
    case ENC_CONSTANT:
        if (c->a >= 0)
            arb_set_fmpq(r, program->st->constant + c->a, p);
        else
            arb_const_pi(r, p);
        break;
    case ENC_ADD:  arb_add(r, x, y, p); break;
    case ENC_SUB:  arb_sub(r, x, y, p); break;
    case ENC_NEG:  arb_neg(r, x); break;
    case ENC_MUL:  arb_mul(r, x, y, p); break;
    case ENC_DIV:  arb_div(r, x, y, p); break;
    case ENC_SQRT: arb_sqrt(r, x, p); break;
    case ENC_ATAN2: arb_atan2(r, x, y, p); break;
    case ENC_FUN: case ENC_CHOICE: function(r, c->fun, x, y, p); break;
    default:       arb_indeterminate(r); break;
    }
}
