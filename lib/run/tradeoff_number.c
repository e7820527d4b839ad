/* Decimal text to more digits than a double has. */
#define _GNU_SOURCE    /* strtof128, strfromf128 */
#include "tradeoff.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

_Float128 tradeoff_number(const char *text)
{
    return strtof128(text, NULL);
}

void tradeoff_text(_Float128 v, char text[TRADEOFF_TEXT])
{
    if (isfinite((double)v))
        strfromf128(text, TRADEOFF_TEXT, "%.34g", v);
    else
        strcpy(text, "null");
}
