/* The table of operators: each trait against values of the function, at many arguments. */
#include <math.h>

#include "check.h"
#include "expr.h"
#include "op.h"
#include "value.h"

static double at(enum expr_op op, double x)
{
    return op == EXPR_POW ? pow(x, 0.5) : expr_function_value(op, x);
}

static void one(enum expr_op op, double x)
{
    unsigned is = expr_op_traits(op);
    const char *name = expr_op_text(op);
    double v = at(op, x), w = at(op, -x), near = 1e-12 * (1 + fabs(v));
    CHECK(!(is & EXPR_IS_TOTAL) || isfinite(v), "%s(%g) has no value", name, x);
    if (!isfinite(v))
        return;
    CHECK(!(is & EXPR_IS_ODD) || fabs(v + w) <= near, "%s(-%g)", name, x);
    CHECK(!(is & EXPR_IS_EVEN) || fabs(v - w) <= near, "%s(-%g)", name, x);
    CHECK(!(is & EXPR_IS_RISING) || (v > 0) - (v < 0) == (x > 0) - (x < 0), "%s(%g) has another sign", name, x);
    CHECK(!(is & EXPR_IS_ABOVE) || v >= 0, "%s(%g) < 0", name, x);
    CHECK(!(is & EXPR_IS_NOT_ZERO) || v != 0, "%s(%g) = 0", name, x);
    enum expr_op undone = expr_op_undone(op);
    CHECK(!undone || fabs(at(undone, v) - x) <= 1e-9 * (1 + fabs(x)), "%s undoes %s at %g", expr_op_text(undone), name, x);
}

/* Where it ends: some argument has a value, and another has none. */
static void end(enum expr_op op)
{
    bool some = false, none = false;
    for (double x = -4; x <= 4; x += 0.125) {
        some |= isfinite(at(op, x));
        none |= !isfinite(at(op, x));
    }
    CHECK(some, "%s has values", expr_op_text(op));
    CHECK(((expr_op_traits(op) & EXPR_HAS_END) != 0) == none || op == EXPR_TAN, "%s: an end", expr_op_text(op));
}

/* Slopes at the ends of arguments, and at 0, against those a little inside. */
static void steep(enum expr_op op)
{
    static const double places[] = { -1, 0, 1 };
    bool found = false;
    for (int i = 0; i < 3; i++)
        for (int side = -1; side <= 1; side += 2) {
            double h = 1e-10 * side, d = (at(op, places[i] + h) - at(op, places[i])) / h, v = at(op, places[i]);
            found |= isfinite(v) && fabs(d) > 1e4;
        }
    unsigned is = expr_op_traits(op);
    CHECK(((is & EXPR_IS_STEEP) != 0) == found || op == EXPR_SIGN, "%s: steep", expr_op_text(op));
}

/* Two analytic functions that meet at 0, or jump there; one of several roots: what undoes it comes back to another one. */
static void branches(enum expr_op op)
{
    static const double h = 1e-10;
    unsigned is = expr_op_traits(op);
    double up = at(op, h), down = at(op, -h), bend = (up + down - 2 * at(op, 0)) / h;
    bool meet = isfinite(bend) && (fabs(up - down) > 0.1 || fabs(bend) > 0.1), other = op == EXPR_SQRT;
    CHECK(((is & EXPR_HAS_BRANCHES) != 0) == meet, "%s: branches", expr_op_text(op));
    for (double x = -4; x <= 4 && expr_op_undone(op); x += 0.125) {
        double back = at(op, at(expr_op_undone(op), x));
        other |= isfinite(back) && fabs(back - x) > 1e-6;
    }
    CHECK(!(is & EXPR_FOLDS) || other, "%s: one of several roots", expr_op_text(op));
}

static bool inside(const struct expr_interval *i, double x)
{
    double unit = i->angles ? acos(0) : 1, low = i->has_low ? unit * i->low : -INFINITY, high = i->has_high ? unit * i->high : INFINITY;
    return i->closed ? low <= x && x <= high : low < x && x < high;
}

/* It has a value just where the table says, one of those that the table says, and reaches near to their ends. */
static void intervals(enum expr_op op)
{
    const struct expr_interval *domain = expr_op_domain(op), *values = expr_op_values(op);
    double least = INFINITY, most = -INFINITY, unit = values->angles ? acos(0) : 1;
    for (double x = -40; x <= 40; x += 0.015625) {
        double v = at(op, x);
        CHECK(inside(domain, x) == (isfinite(v) != 0), "%s(%g)", expr_op_text(op), x);
        if (!isfinite(v))
            continue;
        CHECK(inside(values, v) || fabs(x) > 18, "%s(%g) = %g", expr_op_text(op), x, v);     /* tanh rounds to 1 */
        least = fmin(least, v);
        most = fmax(most, v);
    }
    CHECK(values->has_low ? least - unit * values->low < 0.05 : least < -2, "%s: least %g", expr_op_text(op), least);
    CHECK(values->has_high ? unit * values->high - most < 0.05 : most > 2, "%s: most %g", expr_op_text(op), most);
    CHECK(((expr_op_traits(op) & EXPR_IS_1_AT_0) != 0) == (at(op, 0) == 1), "%s(0)", expr_op_text(op));
}

/* The derivative of the table against differences, and whether it grows. */
static void slopes(enum expr_op op)
{
    const struct expr_slope *s = expr_op_slope(op);
    const double h = 1e-5;
    bool grows = true;
    for (double x = -3.96; x < 4; x += 0.07) {
        double up = at(op, x + h), down = at(op, x - h), v = at(op, x), w = s->of == EXPR_OF_VALUE ? v : x;
        double d = s->of == EXPR_OF_NOTHING ? 0 : s->of == EXPR_OF_FUNCTION ? s->sign * at(s->function, x)
            : s->sign * pow(s->shift + s->factor * pow(w, s->power), s->halves / 2.0);
        if (!isfinite(up) || !isfinite(down))
            continue;
        double difference = (up - down) / (2 * h);
        CHECK(fabs(d - difference) <= 1e-6 * (1 + pow(fabs(difference), 3)), "%s'(%g) = %g, %g", expr_op_text(op), x, d, difference);
        grows = grows && up > down;
    }
    CHECK(((expr_op_traits(op) & EXPR_GROWS) != 0) == grows || op == EXPR_TAN, "%s grows", expr_op_text(op));
}

int main(void)
{
    int functions = 0;
    for (int op = EXPR_SIN; op < EXPR_SOLVE; op++) {
        if (expr_op_args((enum expr_op)op) != 1)
            continue;
        functions++;
        for (double x = -3.875; x < 4; x += 0.0625)
            one((enum expr_op)op, x);
        end((enum expr_op)op);
        steep((enum expr_op)op);
        branches((enum expr_op)op);
        intervals((enum expr_op)op);
        slopes((enum expr_op)op);
    }
    CHECK(functions == 18, "%d functions", functions);
    end(EXPR_POW);
    steep(EXPR_POW);
    return CHECK_END();
}
