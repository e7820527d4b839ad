/* What an export needs of an answer, asked for by its own command. */
#ifndef SGA_CLIENTS_CODE_WANT_H
#define SGA_CLIENTS_CODE_WANT_H

#include "buf.h"

#include <stdbool.h>
#include <stddef.h>

/* Appends the request with `constraints`, `vector_field` and `gauge` added to what it wants; as it stands where it says nothing of that
 * (they are what is computed then), or cannot be read. start: what has a trajectory is asked for its start, too. Cost: linear. */
void code_want(const char *request, size_t length, bool start, struct sga_buf *out);

#endif
