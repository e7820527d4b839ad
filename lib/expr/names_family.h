/* Names that differ in their indices: x[1], x[2], ... */
#ifndef SGA_EXPR_NAMES_FAMILY_H
#define SGA_EXPR_NAMES_FAMILY_H

#include "expr.h"

/* What there is where a name is not known: "x has the indices x[1], ..., x[10]", "x has no index". False: nothing to say. Linear in
 * the symbols. */
#define NAMES_FAMILY 300
bool names_family(const struct expr_store *st, const char *name, size_t length, char out[NAMES_FAMILY]);

#endif
