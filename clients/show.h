/* What a command prints of an answer. */
#ifndef CLIENTS_SHOW_H
#define CLIENTS_SHOW_H

#include "arguments.h"
#include "json_scan.h"
#include "solve.h"

/* Whether people read it: asked for, or on a terminal. */
bool show_readable(const struct arguments *args);
/* Makes the file that --output names standard output, where one is named; false, said, if it cannot. To be called once there is something to
 * print. */
bool show_open(const struct arguments *args);
/* A JSON value with line breaks, on standard output; DONE or FAILED. */
int show_json(struct slice value);
int show_text(const struct sga_buf *text);
/* The result in a: in the form asked for, and the tradeoff into its files. DONE or FAILED. */
int show_result(const struct arguments *args, const struct answer *a);
/* Why there is none, with the place in the request (its `at` may be NULL). Programs get the problem object. */
void show_problem(const struct answer *a, struct slice request);

#endif
