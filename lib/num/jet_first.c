/* Coefficients 0 of series, the values themselves, as acts. */
#include "jet_maker.h"

enum { A = JET_SPARE };

/* A function of coefficients 0 into a new register. */
static int call(struct jet_maker *m, enum expr_op op, int a, int b)
{
    jet_get(m, 0, a, 0);
    if (op == EXPR_POW) {
        jet_get(m, 1, b, 0);
        jet_do(m, ACT_REAL_POWER, 0, 0);
    } else {
        jet_do(m, ACT_CALL, 0, 0);
        m->act[m->count - 1].number = (short)op;
    }
    jet_forget(m);
    int r = jet_fresh(m);
    jet_do(m, ACT_MOVE, r, 0);
    return r;
}

static void both(struct jet_maker *m, const struct jet_code *c)
{
    if (c->sign > 0) {
        jet_put(m, call(m, EXPR_SINH, c->a, 0), c->w);
        jet_put(m, call(m, EXPR_COSH, c->a, 0), c->y);
        return;
    }
    jet_get(m, 0, c->a, 0);
    jet_at(m, ACT_SINCOS, 0, jet_slot(m, c->w, 0));
    m->act[m->count - 1].other = jet_slot(m, c->y, 0);
    jet_forget(m);
    for (int i = 0; i < 2; i++) {
        int r = jet_fresh(m), row = i ? c->y : c->w;
        jet_at(m, ACT_LOAD, r, jet_slot(m, row, 0));
        jet_put(m, r, row);
    }
}

static void reciprocal(struct jet_maker *m, int row, bool twice, int inverse)
{
    jet_at(m, ACT_LOAD, A, m->whole + 1);
    if (twice) {
        jet_get(m, 4, row, 0);
        jet_do(m, ACT_ADD, 4, 4);
        jet_at(m, ACT_STORE, 4, inverse + 1);
        jet_do(m, ACT_DIV, A, 4);
    } else {
        jet_with(m, ACT_DIV, A, row, 0);
    }
    jet_at(m, ACT_STORE, A, inverse);
}

bool jet_first(struct jet_maker *m, const struct jet_code *c, int inverse)
{
    int r;
    switch ((enum jet_op)c->op) {
    case JET_ADD: case JET_SUB: case JET_MUL: case JET_DIV:
        r = jet_fresh(m);
        jet_get(m, r, c->a, 0);
        jet_with(m, c->op == JET_ADD ? ACT_ADD : c->op == JET_SUB ? ACT_SUB : c->op == JET_MUL ? ACT_MUL : ACT_DIV, r, c->b, 0);
        if (c->op == JET_DIV)
            reciprocal(m, c->b, false, inverse);
        break;
    case JET_SQUARE:
        r = jet_fresh(m);
        jet_get(m, r, c->a, 0);
        jet_do(m, ACT_MUL, r, r);
        break;
    case JET_NEG: case JET_AFFINE:
        r = jet_fresh(m);
        jet_get(m, r, c->a, 0);
        if (c->op == JET_NEG || c->sign < 0)
            jet_do(m, ACT_NEGATE, r, 0);
        if (c->op == JET_AFFINE && c->shift)
            jet_at(m, c->shift > 0 ? ACT_ADD_SLOT : ACT_SUB_SLOT, r, m->whole + 1);
        break;
    case JET_INVERSE:
        r = jet_fresh(m);
        jet_at(m, ACT_LOAD, r, m->whole + 1);
        jet_with(m, ACT_DIV, r, c->a, 0);
        break;
    case JET_SQRT:
        r = jet_fresh(m);
        jet_get(m, A, c->a, 0);
        jet_do(m, ACT_SQRT, r, A);
        jet_put(m, r, c->w);
        reciprocal(m, c->w, true, inverse);
        return true;
    case JET_DERIVATIVE: return true;                     /* 0 */
    case JET_EXP:  r = call(m, EXPR_EXP, c->a, 0); break;
    case JET_TRIG: both(m, c); return true;
    case JET_TAN:
        r = call(m, c->function, c->a, 0);
        jet_put(m, r, c->w);
        jet_do(m, ACT_MOVE, A, r);
        jet_do(m, ACT_MUL, A, A);
        if (c->sign < 0)
            jet_do(m, ACT_NEGATE, A, 0);
        r = jet_fresh(m);
        jet_at(m, ACT_LOAD, r, m->whole + 1);
        jet_do(m, ACT_ADD, r, A);
        jet_put(m, r, c->y);
        return true;
    case JET_QUOTIENT:
        r = call(m, c->function, c->a, 0);
        reciprocal(m, c->x, false, inverse);
        break;
    case JET_POWER:
        r = call(m, c->shift == 3 ? EXPR_CBRT : EXPR_POW, c->a, c->b);
        reciprocal(m, c->a, false, inverse);
        break;
    default:
        return false;
    }
    jet_put(m, r, c->w);
    return true;
}
