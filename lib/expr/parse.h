/* Reading the expression grammar.
 *
 *   expr   := term (('+'|'-') term)*        term := unary (('*'|'/') unary)*
 *   unary  := ('-'|'+') unary | power       power := primary (('^'|'**') unary)?
 *   primary:= number | name | name "'"* | name '(' expr (',' expr)* ')' | '(' expr ')'
 * Names are [A-Za-z_][A-Za-z_0-9]*, perhaps with indices ([7], [2,13]: lex_indices); `der(x)`, `der(x, 2)` and x', x'' are derivatives, and where the grammar
 * has `total` so are `der(x*y)` and `der(x^2, 2)`.
 * Decimals are exact rationals (0.1 is 1/10). -x^2 is -(x^2); 2^-3 is allowed;
 * ^ associates to the right. min and max take two or more arguments. No recursion:
 * the parser keeps its own stack. */
#ifndef SGA_EXPR_PARSE_H
#define SGA_EXPR_PARSE_H

#include "expr.h"

struct expr_grammar {
    /* How to read a derivative of order >= 1 of a symbol: returns the node, or
     * EXPR_UNDEF where it is not allowed (then DERIVATIVE is reported).
     * NULL: derivatives are never allowed. */
    expr_id (*derivative)(void *ctx, int symbol, int order);
    /* The total derivative of an expression with respect to time, EXPR_UNDEF where it needs one that is
     * not allowed. NULL: der takes the name of a variable only. */
    expr_id (*total)(void *ctx, expr_id e);
    void *ctx;
    const expr_id *value; /* symbols i < values with value[i] != 0 are read as that node */
    int values;
    int max_length;      /* bytes; 0: 1 MiB */
    int max_depth;       /* of parentheses, signs and powers; 0: 1000 */
    long max_exponent;   /* |n| in x^n; 0: 10000 */
    int max_digits;      /* of one literal; 0: 5000. Decimal exponents are limited to +-5000 too */
};

/* True if the name cannot be a variable's or a parameter's: a function, pi, der. */
bool expr_reserved(const char *name);

/* Read text into the store. Returns EXPR_UNDEF and fills err (code, detail, line,
 * column; pointer is the caller's) on failure. Symbols must exist already. A limit or
 * a division by zero that the store meets on the way is moved into err with its
 * place, and the store stays usable. A NULL grammar is one of zeros. Cost: linear in
 * the text, times the look-up of a name. */
expr_id expr_parse(struct expr_store *st, const char *text, const struct expr_grammar *g,
                   struct sga_error *err);

/* Read `left = right` (also `==` and `~`); gives left - right. A text without a
 * sign of equality is an error. */
expr_id expr_parse_equation(struct expr_store *st, const char *text, const struct expr_grammar *g,
                            struct sga_error *err);

#endif
