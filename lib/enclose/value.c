/* The value of one step of a program, in real balls. */
#include "enc_tables.h"
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
#define X(sym, name) case EXPR_##sym: arb_##name(r, x, p); break;
    EXPR_ELEMENTARY_TABLE(X)
#undef X
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
    case ENC_PIECE: arb_set_round(r, program->tables->piece + c->a, p); break;
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
