/* One request from text to text: the public face of the library.
 *
 * sga_run reads the request (JSON), brings its form to the one shape, runs the
 * reduction, lets the witness check it, integrates, and writes the result (the
 * object that schema/result.json describes). It keeps no state between calls and
 * may be called from one thread at a time in each process that wants isolation:
 * GMP aborts the process when memory ends. */
#ifndef SGA_RUN_RUN_H
#define SGA_RUN_RUN_H

#include <stdbool.h>
#include <stddef.h>

#include "buf.h"
#include "error.h"
#include "exec.h"

struct sga_team;

struct sga_run_options {
    double max_seconds;                 /* server's maximum; 0: 3600 */
    size_t max_memory;                  /* bytes that a job may add to the process; 0: 16 GB */
    size_t max_result;                  /* bytes of the result's text; 0: 1 GB */
    /* Where a library call runs past memory or time and cannot be left, and where a job that met a limit has so much memory
     * that giving it back would take long: tells why, does not return. NULL: such a job goes on, and the process aborts once
     * memory ends. */
    void (*wall)(void *ctx, const struct sga_error *err);
    void (*progress)(void *ctx, const char *stage, double fraction, double t);  /* may be NULL; fraction 0..1; t: where a motion is, else NAN */
    bool (*cancelled)(void *ctx);       /* may be NULL; asked often */
    /* Takes a long result piece by piece while it is written: what is left is appended to out, also of a result that is short. A job may
     * fail after some were given. NULL: all of it is appended to out. */
    void (*give)(void *ctx, const char *text, size_t length);
    void *ctx;
    /* Memory for machine code, made before a sandbox is entered that would forbid it. NULL, or a
     * process that may not run it: formulas are interpreted, and answers are the same to the bit. */
    struct sga_exec *exec;
    /* Other processes that may make a part of the sets of a long sweep (team.h); NULL: there are none. Answers are the same. */
    struct sga_team *team;
};

/* Once in every process that calls sga_run, before the first call: the numerical
 * libraries' error handlers must not end the process. */
void sga_init(void);
/* The same for a process that is somebody else's: the allocators of GMP, FLINT and jansson stay what they are. What these ask for is
 * not counted while it is asked for, and where memory ends the process aborts. */
void sga_init_guest(void);

/* Appends the result to out and returns true; on failure fills err and leaves out
 * unspecified. Cost: the whole job. */
bool sga_run(const char *request, size_t length, const struct sga_run_options *options,
             struct sga_buf *out, struct sga_error *err);

/* Reads and checks a request without running it, within bounded time and memory:
 * shapes, names, expressions. A good beginning that would take more than about a second or
 * two million nodes counts as good. On success appends the canonical request to out: compact
 * JSON with sorted keys, equal for requests that mean the same member by member
 * (the key of the cache is its SHA-256). */
bool sga_canonical(const char *request, size_t length, struct sga_buf *out, struct sga_error *err);
/* A request that has been answered, with its ranges and loops written out (request_plain). */
bool sga_plain(const char *request, size_t length, struct sga_buf *out, struct sga_error *err);

/* Reads a request within the same bounds and appends what there is to say of it, a JSON object: {"valid", "problems": [every one],
 * "warnings", "form", "variables", "equations", "unknowns"} (schema/check.json). Runs nothing. `valid` is null where nothing is known
 * against it, and reading all of it would take longer. */
void sga_review(const char *request, size_t length, struct sga_buf *out);

/* "0.3.0+9f2c...": the product's version, and a digest of the sources of lib/, with which answers may change: jobs are named by it, so
 * that old cached answers are not given. Static. Made by lib/run/version.sh. */
const char *sga_version(void);

#endif
