/* Results for people: indented JSON, and a text that reads like a page. */
#ifndef CLIENTS_PRETTY_H
#define CLIENTS_PRETTY_H

#include "buf.h"
#include "json_scan.h"

/* The same JSON with line breaks; lists of plain values stay on one line. No digit changes. */
void pretty_json(struct slice value, struct sga_buf *out);
/* Verdict, dimensions, constraints by generation, vector field, gauge, strata, samples. */
void pretty_text(struct slice result, struct sga_buf *out);

#endif
