/* The table of patterns. A row for each operator: the size of the enumeration is asserted, so that a new operator does not compile
 * before it has one. Functions that a language lacks, or has with other values at the ends, are helpers of its head. */
#include "operators.h"

#include <stddef.h>

#define F(name) name "($x)"
#define G(name) name "($x, $y)"
/*    operator, how strongly it binds in C, C, in Python, Python */
#define PATTERNS(X) \
    X(UNDEF_OP, 0, NULL, 0, NULL) X(CONST, 0, NULL, 0, NULL) X(SYM, 0, NULL, 0, NULL) X(SOLVE, 0, NULL, 0, NULL) \
    X(PI, BINDS_ALL, "3.14159265358979323846", BINDS_ALL, "math.pi") \
    X(ADD, BINDS_SUM, "$a + $b", BINDS_SUM, "$a + $b") X(SUB, BINDS_SUM, "$a - $b", BINDS_SUM, "$a - $b") \
    X(MUL, BINDS_PRODUCT, "$a*$b", BINDS_PRODUCT, "$a*$b") X(DIV, BINDS_PRODUCT, "$a/$b", BINDS_PRODUCT, "$a/$b") \
    X(NEG, BINDS_SIGN, "-$A", BINDS_SIGN, "-$A") \
    X(POWI, BINDS_ALL, "pow($x, $n)", BINDS_POWER, "$A**$n") X(POW, BINDS_ALL, G("sga_power"), BINDS_ALL, G("_power")) \
    X(SIN, BINDS_ALL, F("sin"), BINDS_ALL, F("math.sin")) X(COS, BINDS_ALL, F("cos"), BINDS_ALL, F("math.cos")) \
    X(TAN, BINDS_ALL, F("tan"), BINDS_ALL, F("math.tan")) X(ASIN, BINDS_ALL, F("asin"), BINDS_ALL, F("math.asin")) \
    X(ACOS, BINDS_ALL, F("acos"), BINDS_ALL, F("math.acos")) X(ATAN, BINDS_ALL, F("atan"), BINDS_ALL, F("math.atan")) \
    X(ATAN2, BINDS_ALL, G("atan2"), BINDS_ALL, G("math.atan2")) X(SINH, BINDS_ALL, F("sinh"), BINDS_ALL, F("math.sinh")) \
    X(COSH, BINDS_ALL, F("cosh"), BINDS_ALL, F("math.cosh")) X(TANH, BINDS_ALL, F("tanh"), BINDS_ALL, F("math.tanh")) \
    X(ASINH, BINDS_ALL, F("asinh"), BINDS_ALL, F("math.asinh")) X(ACOSH, BINDS_ALL, F("acosh"), BINDS_ALL, F("math.acosh")) \
    X(ATANH, BINDS_ALL, F("atanh"), BINDS_ALL, F("math.atanh")) X(EXP, BINDS_ALL, F("exp"), BINDS_ALL, F("math.exp")) \
    X(LOG, BINDS_ALL, F("log"), BINDS_ALL, F("math.log")) X(SQRT, BINDS_ALL, F("sqrt"), BINDS_ALL, F("math.sqrt")) \
    X(CBRT, BINDS_ALL, F("cbrt"), BINDS_ALL, F("_cbrt")) X(ABS, BINDS_ALL, F("fabs"), BINDS_ALL, F("abs")) \
    X(SIGN, BINDS_ALL, F("sga_sign"), BINDS_ALL, F("_sign")) X(MIN, BINDS_ALL, G("sga_least"), BINDS_ALL, G("min")) \
    X(MAX, BINDS_ALL, G("sga_greatest"), BINDS_ALL, G("max"))

static const struct export_pattern patterns[EXPR_OP_COUNT][EXPORT_LANGUAGES] = {
#define X(op, c_binds, c, python_binds, python) [EXPR_##op] = { [EXPORT_C] = { c_binds, c }, [EXPORT_PYTHON] = { python_binds, python } },
    PATTERNS(X)
#undef X
};

enum {
#define X(op, c_binds, c, python_binds, python) ROW_##op,
    PATTERNS(X)
#undef X
    ROWS
};
_Static_assert((int)ROWS == (int)EXPR_OP_COUNT, "each operator has a row");

struct export_pattern export_pattern(enum export_language l, enum expr_op op)
{
    return patterns[op][l];
}
