/* The tradeoff of a result into files. */
#ifndef CLIENTS_SAVE_H
#define CLIENTS_SAVE_H

#include <stdbool.h>

#include "json_scan.h"

/* Writes it as CSV and as an SVG image, where a name is not NULL. False: the result has none, or a file
 * cannot be written; said on standard error. */
bool save_tradeoff(struct slice result, const char *csv, const char *svg);

#endif
