/* libsga: implicit differential systems A(x, t) x' = alpha(x, t), solved in process.
 *
 * A request is JSON, what the daemon takes by POST /v1/solve; an answer is JSON, what it gives
 * (schema/request.json and schema/result.json, installed beside the documentation). A call computes
 * nothing that its request does not want, keeps nothing, and writes no files.
 *
 *     sga_answer *a = sga_solve(text, strlen(text), NULL);
 *     if (sga_answer_ok(a))
 *         puts(sga_answer_text(a));
 *     else
 *         fprintf(stderr, "%s: %s\n", sga_answer_code(a), sga_answer_detail(a));
 *     sga_answer_free(a);
 *
 * Threads: several may call at once, each with a request of its own. The first call turns GSL's error
 * handler off for the process (it would end it); the allocators of GMP, FLINT and jansson stay what they are.
 *
 * Memory: options.memory ends a job between its steps. Where the system has no memory left the process is
 * aborted, with one line on standard error: GMP and FLINT can neither fail nor be left. A program that must
 * outlive that gives its requests to sgad, or to a child of its own.
 *
 * Time: options.seconds and a request's own limits.seconds end a job between its steps; a single factorisation
 * inside FLINT or KLU is not interrupted. */
#ifndef SGA_H
#define SGA_H

#include <stddef.h>

/* Of this header; sga_api() gives that of the library. Functions and members are added at the end; what is
 * taken away or changed raises the number, and the soname with it. */
#define SGA_API 1

#if defined(__GNUC__)
#define SGA_PUBLIC __attribute__((visibility("default")))
#else
#define SGA_PUBLIC
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* What a call may take, and what it tells meanwhile. Zero means the default; `size` is sizeof(sga_options), so
 * that members can be added. */
typedef struct sga_options {
    size_t size;
    double seconds;            /* at most, whatever the request says; 0: 3600 */
    size_t memory;             /* bytes by which the process may grow; 0: 16 GB */
    size_t result;             /* bytes of the answer's text; 0: 1 GB */
    int interpret_only;        /* make no machine code of formulas: the same answer to the bit, later */
    void (*progress)(void *context, const char *stage, double fraction);      /* fraction 0..1, from the calling thread; or NULL */
    int (*cancelled)(void *context);                                          /* not 0: the job ends, with code "cancelled"; asked often; or NULL */
    void *context;
} sga_options;

typedef struct sga_answer sga_answer;

SGA_PUBLIC int sga_api(void);
/* "0.3.0+9f2c41d07a3b": the product's, and a digest of the sources that answers come from: a cache of answers is keyed by it. Static. */
SGA_PUBLIC const char *sga_version(void);

/* Solves a request of so many bytes. options may be NULL. The caller frees the answer; never NULL. */
SGA_PUBLIC sga_answer *sga_solve(const char *request, size_t length, const sga_options *options);
/* Reads and checks a request without solving it, in about a second at most. The answer's text is the canonical request: compact, keys
 * sorted, equal for requests that mean the same member by member. */
SGA_PUBLIC sga_answer *sga_check(const char *request, size_t length);

/* Of an answer; all texts are 0-terminated, owned by the answer, and never NULL. */
SGA_PUBLIC int sga_answer_ok(const sga_answer *a);                 /* 1: text is the result; 0: what follows says why there is none */
SGA_PUBLIC const char *sga_answer_text(const sga_answer *a);       /* JSON, or "" */
SGA_PUBLIC size_t sga_answer_length(const sga_answer *a);          /* bytes of it */
SGA_PUBLIC const char *sga_answer_code(const sga_answer *a);       /* "ok", or a code of doc/errors.md, "expression_syntax" */
SGA_PUBLIC const char *sga_answer_title(const sga_answer *a);      /* the code in words */
SGA_PUBLIC const char *sga_answer_detail(const sga_answer *a);     /* what is wrong, where, and what to change */
SGA_PUBLIC const char *sga_answer_pointer(const sga_answer *a);    /* JSON Pointer into the request, or "" */
SGA_PUBLIC const char *sga_answer_stage(const sga_answer *a);      /* "request", "sga", "witness", "trajectory", ..., or "" */
SGA_PUBLIC int sga_answer_line(const sga_answer *a);               /* within an expression, from 1; 0: none */
SGA_PUBLIC int sga_answer_column(const sga_answer *a);
SGA_PUBLIC void sga_answer_free(sga_answer *a);                    /* NULL is allowed */

#ifdef __cplusplus
}
#endif

#endif
