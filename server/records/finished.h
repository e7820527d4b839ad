/* A job that has ended, as finished text: built once, shared, never changed. */
#ifndef SERVER_FINISHED_H
#define SERVER_FINISHED_H

#include <stdatomic.h>
#include <stddef.h>

#include "job.h"
#include "json_scan.h"

struct finished {
    atomic_int refs;
    char id[ID_LENGTH + 1];
    enum job_status status;
    char etag[72];               /* strong, with its quotes */
    char *text;                  /* the job object, with "cached":false */
    char *block;                 /* what it is in, of spool_new */
    size_t len;
    size_t cached_at;            /* where that `false` begins */
    size_t head;                 /* bytes before the last member (result or request) or the last brace */
    struct slice result;         /* inside text; at is NULL where there is none */
    atomic_long *booked;         /* counts its bytes while it lives; NULL: nothing does */
};

/* From a row that has ended, and its result or, where it is not done, its request (at is
 * NULL where it is not known). One reference is the caller's. NULL when memory ends. Cost:
 * one copy of the text. */
struct finished *finished_make(const struct job_row *row, struct slice text);
/* The same of a text of spool_new, which is taken over (*text becomes NULL) and does not move. NULL when memory ends: then it is still the
 * caller's. */
struct finished *finished_take(const struct job_row *row, char **text, size_t length);
/* Counts its bytes in *bytes from now on, until it is freed. Once, before it is shared. */
void finished_book(struct finished *f, atomic_long *bytes);
struct finished *finished_ref(struct finished *f);
void finished_unref(struct finished *f);      /* NULL is allowed */

#endif
