/* How each language writes places and statements: the one table beside that of the operators. */
#ifndef SGA_EXPORT_DIALECT_H
#define SGA_EXPORT_DIALECT_H

#include <stddef.h>

#include "export.h"

/* Patterns of printf. In print (LaTeX, MathML) names stand for places, and `list` is NULL. */
struct export_dialect {
    int first;                              /* of the counting: 0 or 1 */
    const char *variable, *argument, *gauge;/* the k-th variable, free parameter, gauge function */
    const char *constant;                   /* the k-th parameter that has a value; NULL: P_ and its name */
    const char *list, *grid;                /* place of an array: its name, k; its name, row, column; grid NULL: a list by rows */
    const char *part;                       /* the k-th shared part */
    const char *named, *assigned;           /* statements of a shared part and of a place: left side, value */
    const char *open, *close;               /* brackets */
    size_t shared, most;                    /* characters from which on a shared part, and any part, gets a name */
};

const struct export_dialect *export_dialect(enum export_language l);
/* Whether it is read by people alone: exact numbers, names as in books. */
bool export_is_print(enum export_language l);

#endif
