/* Last words. */
#include "no_memory.h"

#include <stdio.h>
#include <stdlib.h>

void no_memory(const char *what)
{
    fprintf(stderr, "sgad: out of memory for %s\n", what);
    abort();
}
