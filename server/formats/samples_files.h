/* Samples as files that other programs load. The same samples give the same bytes. */
#ifndef SERVER_SAMPLES_FILES_H
#define SERVER_SAMPLES_FILES_H

#include "samples.h"

struct sga_buf;

/* Appends an array of NumPy's format (.npy): one dimension, a field of '<f8' for each column. */
void samples_npy(const struct samples *s, struct sga_buf *out);
/* The bytes before its values, which are those of the rows one after the other, by little_doubles. */
void samples_npy_head(const struct samples *s, struct sga_buf *out);
/* Appends a MAT-file of level 5: `rows`, a matrix, and `columns`, a cell row of their names. False, with nothing appended: longer than the 2 GB
 * of that format. */
bool samples_mat(const struct samples *s, struct sga_buf *out);

#endif
