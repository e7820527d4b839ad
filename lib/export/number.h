/* Exact rationals as literals of C and Python: decimals with all their digits, quotients of two whole doubles, else 17 digits. */
#ifndef SGA_EXPORT_NUMBER_H
#define SGA_EXPORT_NUMBER_H

#include <flint/fmpq.h>

#include "buf.h"

/* Appends it; the value that a compiler makes of it is the double nearest to q. *binds: how strongly the text binds (operators.h). False,
 * with nothing appended: q is outside of the doubles, or so small that it would be 0. */
bool export_number(const fmpq_t q, struct sga_buf *out, int *binds);

#endif
