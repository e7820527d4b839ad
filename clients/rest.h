/* What a text for people shows of an object without a form of its own: nothing of an answer is left out in silence. */
#ifndef CLIENTS_REST_H
#define CLIENTS_REST_H

#include "buf.h"
#include "json_scan.h"

/* Names; the last is NULL. */
struct rest_names {
    const char *const *shown;      /* that stand elsewhere in the text */
    const char *const *seldom;     /* long and seldom read: their names alone are told, with how to get them */
};

/* Each other member that is neither null nor empty, under `before` and its name: texts and numbers in a line, objects and lists as indented JSON. Lists are
 * cut after REST_ELEMENTS, which is said. Linear cost. */
enum { REST_ELEMENTS = 21 };
void rest_put(struct sga_buf *out, struct slice object, const char *before, struct rest_names names);

#endif
