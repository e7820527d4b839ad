/* Exact rationals as literals of C and Python: decimals with all their digits, quotients of two whole doubles, else 17 digits. */
#ifndef SGA_EXPORT_NUMBER_H
#define SGA_EXPORT_NUMBER_H

#include <flint/fmpq.h>

#include "export.h"

/* Appends it; the value that a compiler makes of it is the double nearest to q. *binds: how strongly the text binds (operators.h). False,
 * with nothing appended: q is outside of the doubles, or so small that it would be 0. */
bool export_number(const fmpq_t q, struct sga_buf *out, int *binds);
/* Appends it as print has it, exactly: whole numbers, decimals, and fractions where they are shorter or there is no decimal. */
void export_print_number(const fmpq_t q, enum export_language l, struct sga_buf *out, int *binds);

#endif
