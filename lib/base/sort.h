/* Whole numbers in order: lists of ids, rows and columns, most of them short, which qsort spends its time on calls for. */
#ifndef SGA_BASE_SORT_H
#define SGA_BASE_SORT_H

#include <stddef.h>

/* Ascending. Cost: linear from some dozens on, by digits (Knuth, The Art of Computer Programming, volume 3, 5.2.5), with room for a copy. */
void sga_sort(int *list, size_t count);

#endif
