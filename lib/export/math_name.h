/* Names as books have them: Greek letters, a number at the end as an index, primes. */
#ifndef SGA_EXPORT_MATH_NAME_H
#define SGA_EXPORT_MATH_NAME_H

#include "export.h"

struct sga_arena;

/* The name in LaTeX or MathML, another one than those taken (NULL among them is none): where two names would look the same, the later one
 * stands as it is written. In mem. */
const char *math_name(struct sga_arena *mem, enum export_language l, const char *const *taken, int count, const char *name);

#endif
