/* The table of patterns. A row for each operator and a column for each language: the size of the enumeration is asserted, so that a new
 * operator does not compile before it has a row. Functions that a language lacks, or has with other values at the ends, are helpers of
 * its head. */
#include "operators.h"

#include <stddef.h>

#define F(name) { BINDS_ALL, name "($x)" }
#define G(name) { BINDS_ALL, name "($x, $y)" }
#define T(name) { BINDS_ALL, name "\\left($x\\right)" }                                     /* functions as TeX and MathML set them */
#define U(name) { BINDS_ALL, name "\\left($x, $y\\right)" }
#define M(name) { BINDS_ALL, "<mi>" name "</mi><mo>&#x2061;</mo><mrow><mo>(</mo>$x<mo>)</mo></mrow>" }
#define K(name) { BINDS_ALL, "<mi>" name "</mi><mo>&#x2061;</mo><mrow><mo>(</mo>$x<mo>,</mo>$y<mo>)</mo></mrow>" }
#define OP(name) "\\operatorname{" name "}"
#define S(text) { BINDS_SUM, text }
#define P(text) { BINDS_PRODUCT, text }
#define N(text) { BINDS_SIGN, text }
#define W(text) { BINDS_POWER, text }
#define A(text) { BINDS_ALL, text }
#define NONE { 0, NULL }
#define NOWHERE NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE
#define SAME(cell) cell, cell, cell, cell, cell, cell
#define PI_DIGITS "3.14159265358979323846"
#define SQUARE_ROOT "<msqrt><mrow>$x</mrow></msqrt>"

/*    operator, C, Python, MATLAB, Julia, CasADi, Modelica, LaTeX, MathML. A sign is a sum's in Modelica and in print: a*-b is none there. */
#define PATTERNS(X) \
    X(UNDEF_OP, NOWHERE) X(CONST, NOWHERE) X(SYM, NOWHERE) X(SOLVE, NOWHERE) \
    X(PI, A(PI_DIGITS), A("math.pi"), A("pi"), A("Float64(pi)"), A("math.pi"), A(PI_DIGITS), A("\\pi"), A("<mi>&#x3C0;</mi>")) \
    X(ADD, SAME(S("$a + $b")), S("$a + $b"), S("$a<mo>+</mo>$b")) \
    X(SUB, SAME(S("$a - $b")), S("$a - $b"), S("$a<mo>-</mo>$b")) \
    X(MUL, SAME(P("$a*$b")), P("$a $*$c"), P("$a<mo>&#x22C5;</mo>$c")) \
    X(DIV, SAME(P("$a/$b")), W("\\frac{$x}{$y}"), W("<mfrac><mrow>$x</mrow><mrow>$y</mrow></mfrac>")) \
    X(NEG, N("-$A"), N("-$A"), N("-$A"), N("-$A"), N("-$A"), S("-$A"), S("-$A"), S("<mo>-</mo>$A")) \
    X(POWI, A("pow($x, $n)"), W("$A**$n"), W("$A^($n)"), W("$A^($n)"), W("$A**$n"), W("$A^($n)"), W("{$A}^{$n}"), \
      W("<msup><mrow>$A</mrow><mn>$n</mn></msup>")) \
    X(POW, G("sga_power"), G("_power"), G("power_"), G("_power"), G("_power"), G("power"), W("{$A}^{$y}"), \
      W("<msup><mrow>$A</mrow><mrow>$y</mrow></msup>")) \
    X(SIN, F("sin"), F("math.sin"), F("sin"), F("sin"), F("casadi.sin"), F("sin"), T("\\sin"), M("sin")) \
    X(COS, F("cos"), F("math.cos"), F("cos"), F("cos"), F("casadi.cos"), F("cos"), T("\\cos"), M("cos")) \
    X(TAN, F("tan"), F("math.tan"), F("tan"), F("tan"), F("casadi.tan"), F("tan"), T("\\tan"), M("tan")) \
    X(ASIN, F("asin"), F("math.asin"), F("asin_"), F("asin"), F("casadi.asin"), F("asin"), T("\\arcsin"), M("arcsin")) \
    X(ACOS, F("acos"), F("math.acos"), F("acos_"), F("acos"), F("casadi.acos"), F("acos"), T("\\arccos"), M("arccos")) \
    X(ATAN, F("atan"), F("math.atan"), F("atan"), F("atan"), F("casadi.atan"), F("atan"), T("\\arctan"), M("arctan")) \
    X(ATAN2, G("atan2"), G("math.atan2"), G("atan2"), G("atan"), G("casadi.atan2"), G("atan2"), U(OP("atan2")), K("atan2")) \
    X(SINH, F("sinh"), F("math.sinh"), F("sinh"), F("sinh"), F("casadi.sinh"), F("sinh"), T("\\sinh"), M("sinh")) \
    X(COSH, F("cosh"), F("math.cosh"), F("cosh"), F("cosh"), F("casadi.cosh"), F("cosh"), T("\\cosh"), M("cosh")) \
    X(TANH, F("tanh"), F("math.tanh"), F("tanh"), F("tanh"), F("casadi.tanh"), F("tanh"), T("\\tanh"), M("tanh")) \
    X(ASINH, F("asinh"), F("math.asinh"), F("asinh"), F("asinh"), F("casadi.asinh"), F("areaSine"), T(OP("arsinh")), M("arsinh")) \
    X(ACOSH, F("acosh"), F("math.acosh"), F("acosh_"), F("acosh"), F("casadi.acosh"), F("areaCosine"), T(OP("arcosh")), M("arcosh")) \
    X(ATANH, F("atanh"), F("math.atanh"), F("atanh_"), F("atanh"), F("casadi.atanh"), F("areaTangent"), T(OP("artanh")), M("artanh")) \
    X(EXP, F("exp"), F("math.exp"), F("exp"), F("exp"), F("casadi.exp"), F("exp"), W("e^{$x}"), W("<msup><mi>e</mi><mrow>$x</mrow></msup>")) \
    X(LOG, F("log"), F("math.log"), F("log_"), F("log"), F("casadi.log"), F("log"), T("\\ln"), M("ln")) \
    X(SQRT, F("sqrt"), F("math.sqrt"), F("sqrt_"), F("sqrt"), F("casadi.sqrt"), F("sqrt"), A("\\sqrt{$x}"), A(SQUARE_ROOT)) \
    X(CBRT, F("cbrt"), F("_cbrt"), F("cbrt_"), F("cbrt"), F("_cbrt"), F("cubeRoot"), A("\\sqrt[3]{$x}"), A("<mroot><mrow>$x</mrow><mn>3</mn></mroot>")) \
    X(ABS, F("fabs"), F("abs"), F("abs"), F("abs"), F("casadi.fabs"), F("abs"), A("\\left|$x\\right|"), A("<mrow><mo>|</mo>$x<mo>|</mo></mrow>")) \
    X(SIGN, F("sga_sign"), F("_sign"), F("sign"), F("sign"), F("casadi.sign"), F("sign"), T(OP("sign")), M("sign")) \
    X(MIN, G("sga_least"), G("min"), G("least_"), G("min"), G("casadi.fmin"), G("min"), U("\\min"), K("min")) \
    X(MAX, G("sga_greatest"), G("max"), G("greatest_"), G("max"), G("casadi.fmax"), G("max"), U("\\max"), K("max"))

static const struct export_pattern patterns[EXPR_OP_COUNT][EXPORT_LANGUAGES] = {
#define X(op, ...) [EXPR_##op] = { __VA_ARGS__ },
    PATTERNS(X)
#undef X
};

enum {
#define X(op, ...) ROW_##op,
    PATTERNS(X)
#undef X
    ROWS
};
_Static_assert((int)ROWS == (int)EXPR_OP_COUNT, "each operator has a row");
_Static_assert(EXPORT_MATHML + 1 == EXPORT_LANGUAGES && EXPORT_LATEX == 6 && EXPORT_C == 0, "the columns stand in the order of the languages");

struct export_pattern export_pattern(enum export_language l, enum expr_op op)
{
    return patterns[op][l];
}
