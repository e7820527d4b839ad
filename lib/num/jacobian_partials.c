/* Partial derivatives of each instruction, from the values on the tape. */
#include "jacobian_plan.h"

#include <math.h>

#include "op.h"

/* Here too, so that the compiler sees its constants: these are hot. */
static const struct expr_slope column[EXPR_OP_COUNT] = {
#define SLOPE EXPR_SLOPE
#define SLOPE_IS EXPR_SLOPE_IS
#define NO_SLOPE EXPR_NO_SLOPE
#define X(sym, text, args, traits, undone, domain, values, slope) [EXPR_##sym] = slope,
    EXPR_OP_TABLE(X)
#undef X
};

static double sign(double x) { return isnan(x) ? x : (x > 0) - (x < 0); }

/* Of min (max: with x and y exchanged) by its first argument. */
static double step_below(double x, double y) { return (1 - sign(x - y)) / 2; }

static void binary(struct jacobian_step *s, double x, double y, double u, bool by_b)
{
    switch (s->op) {
    case EXPR_ADD: s->pa = 1; s->pb = 1; break;
    case EXPR_SUB: s->pa = 1; s->pb = -1; break;
    case EXPR_MUL: s->pa = y; s->pb = x; break;
    case EXPR_DIV: s->pa = 1 / y; s->pb = -u / y; break;
    case EXPR_POW:
        s->pa = x < 0 ? NAN : y * pow(x, y - 1);
        s->pb = by_b ? u * log(x) : 0;
        break;
    case EXPR_ATAN2:
        s->pa = y / (x * x + y * y);
        s->pb = -x / (x * x + y * y);
        break;
    case EXPR_MIN: s->pa = step_below(x, y); s->pb = step_below(y, x); break;
    default:       s->pa = step_below(y, x); s->pb = step_below(x, y); break;    /* EXPR_MAX */
    }
}

static inline double of_function(enum expr_op f, double x)
{
    switch (f) {
#define X(sym, name) case EXPR_##sym: return name(x);
    EXPR_ELEMENTARY_TABLE(X)
#undef X
    default: return sign(x);
    }
}

/* Of constants from the table: nothing of it is left but the formula. Written so that it keeps its digits where it is small or large. */
static inline double slope(struct expr_slope s, double x, double u)
{
    double w = s.of == EXPR_OF_VALUE ? u : x, r;
    if (s.of == EXPR_OF_NOTHING)
        return isnan(x) ? x : 0;
    if (s.of == EXPR_OF_FUNCTION)
        return s.sign * of_function(s.function, x);
    if (s.power == 1)
        r = s.factor * w;
    else if (s.shift == 1 && s.factor == -1)
        r = (1 - w) * (1 + w);
    else if (s.shift == -1 && s.factor == 1)
        r = (w - 1) * (w + 1);
    else if (s.shift == 1 && s.factor == 1 && s.halves == -1)
        return s.sign / hypot(1, w);
    else
        r = s.shift + s.factor * w * w;
    return s.halves == -1 ? s.sign / sqrt(r) : s.halves < 0 ? s.sign / r : s.sign * r;
}

/* u: where the value stands; its neighbours serve sine and cosine pairs. */
static double unary(int op, double x, const double *u, int n)
{
    switch (op) {
    case EXPR_NEG:     return -1;
    case TAPE_SQUARE:  return 2 * x;
    case TAPE_CUBE:    return 3 * x * x;
    case EXPR_POWI:    return n * tape_power(x, n - 1);
    case TAPE_SINCOS:  return u[1];
    case TAPE_PAIRED:  return -u[-1];
#define X(sym, name) case EXPR_##sym: return slope(column[EXPR_##sym], x, u[0]);
    EXPR_ELEMENTARY_TABLE(X)
#undef X
    case EXPR_SQRT:    return slope(column[EXPR_SQRT], x, u[0]);
    case EXPR_CBRT:    return slope(column[EXPR_CBRT], x, u[0]);
    default:           return slope(column[op], x, u[0]);    /* EXPR_ABS, EXPR_SIGN */
    }
}

static bool two_operands(struct jacobian_step *s, const struct tape_code *c, const double *v, bool by_b)
{
    if (!tape_reads_two(s->op))
        return false;
    binary(s, v[c->a], v[c->b], v[s->slot], by_b);
    return true;
}

void jacobian_partials(struct num_jacobian_plan *p)
{
    const struct num_tape *t = p->tape;
    const double *v = t->value;
    for (struct jacobian_step *s = p->step, *end = s + p->steps; s < end; s++) {
        const struct tape_code *c = t->code + s->slot - t->code_slot;
        if (s->op == TAPE_FACTOR || s->op == TAPE_COMPONENT)
            continue;
        if (s->op == TAPE_SIGNAL)
            s->pa = tape_signal(t, c, 1);
        else if (!two_operands(s, c, v, s->b != p->sink))
            s->pa = unary(s->op, v[s->op == TAPE_PAIRED ? c[-1].a : c->a], v + s->slot, c->b);
    }
}

double tape_slope(const struct num_tape *t, int slot, bool by_second)
{
    const struct tape_code *c = t->code + slot - t->code_slot;
    struct jacobian_step s = { .op = c->op, .slot = slot };
    if (c->op == TAPE_SIGNAL)
        return tape_signal(t, c, 1);
    if (two_operands(&s, c, t->value, true))
        return by_second ? s.pb : s.pa;
    return unary(c->op, t->value[c->a], t->value + slot, c->b);
}
