/* Values in double arithmetic. */
#ifndef SGA_EXPR_VALUE_H
#define SGA_EXPR_VALUE_H

#include <flint/fmpq.h>

#include "expr.h"

/* A function of the operator table with one argument; NaN outside of its domain, and for every
 * other operator. */
double expr_function_value(enum expr_op op, double a);
/* The double nearest to q, also where it is subnormal. */
double expr_nearest_double(const fmpq *q);
/* Its numerator and denominator are doubles. */
bool expr_short_fraction(const fmpq *q);

#endif
