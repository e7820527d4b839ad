/* The one table of how operators are written: for each language a pattern.
 *
 * In a pattern `$a` is the first argument, in brackets where it binds less than the operator; `$A` and `$b` are the first and the second,
 * in brackets where they do not bind more; `$c` is the second in
 * brackets where it binds less; `$x` and `$y` are the two without brackets; `$n` is a whole exponent; `$*` is the sign of a
 * product in TeX: a space, and a dot where a digit follows. */
#ifndef SGA_EXPORT_OPERATORS_H
#define SGA_EXPORT_OPERATORS_H

#include "export.h"
#include "expr.h"

/* How strongly texts bind. */
enum { BINDS_SUM = 1, BINDS_PRODUCT = 2, BINDS_SIGN = 3, BINDS_POWER = 4, BINDS_ALL = 5 };

struct export_pattern {
    int binds;
    const char *text;             /* NULL: the operator is none of the grammar's, or has no pattern (constants and symbols) */
};
struct export_pattern export_pattern(enum export_language l, enum expr_op op);

#endif
