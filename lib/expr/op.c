/* The table of operators, as data. */
#include "op.h"

#include <assert.h>
#include <string.h>

enum interval {
#define X(sym, has_low, has_high, low, high, closed, angles, outside) sym,
    EXPR_INTERVAL_TABLE(X)
#undef X
    INTERVALS
};

static const struct expr_interval interval[INTERVALS] = {
#define X(sym, has_low, has_high, low, high, closed, angles, outside) [sym] = { has_low, has_high, low, high, closed, angles, outside },
    EXPR_INTERVAL_TABLE(X)
#undef X
};

static const struct {
    const char *text;
    int args;
    unsigned traits;
    enum expr_op undone;
    enum interval domain, values;
    struct expr_slope slope;
} op_table[EXPR_OP_COUNT] = {
#define SLOPE EXPR_SLOPE
#define SLOPE_IS EXPR_SLOPE_IS
#define NO_SLOPE EXPR_NO_SLOPE
#define X(sym, text, args, traits, undone, domain, values, slope) [EXPR_##sym] = { text, args, traits, EXPR_##undone, domain, values, slope },
    EXPR_OP_TABLE(X)
#undef X
};

const char *expr_op_text(enum expr_op op) { return op_table[op].text; }
int expr_op_args(enum expr_op op) { return op_table[op].args; }
unsigned expr_op_traits(enum expr_op op) { return op_table[op].traits; }
enum expr_op expr_op_undone(enum expr_op op) { return op_table[op].undone; }
const struct expr_interval *expr_op_domain(enum expr_op op) { return interval + op_table[op].domain; }
const struct expr_interval *expr_op_values(enum expr_op op) { return interval + op_table[op].values; }
const struct expr_slope *expr_op_slope(enum expr_op op) { return &op_table[op].slope; }

enum expr_op expr_function(const char *name, size_t len)
{
    for (int op = EXPR_SIN; op <= EXPR_MAX; op++)
        if (op_table[op].text[0] == name[0] && strlen(op_table[op].text) == len && memcmp(op_table[op].text, name, len) == 0)
            return (enum expr_op)op;
    return EXPR_UNDEF_OP;
}

expr_id expr_interval_end(struct expr_store *st, const struct expr_interval *i, bool high)
{
    assert(high ? i->has_high : i->has_low);
    int end = high ? i->high : i->low;
    return i->angles ? expr_mul(st, expr_rational(st, end, 2), expr_pi(st)) : expr_int(st, end);
}
