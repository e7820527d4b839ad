/* What one job may use, asked cooperatively inside every long loop. */
#ifndef SGA_BASE_BUDGET_H
#define SGA_BASE_BUDGET_H

#include <stdbool.h>
#include <stddef.h>

struct sga_error;
struct sga_share;
struct sga_warnings;

struct sga_budget {
    double deadline;        /* sga_now() value after which work stops; 0: none */
    double cpu_deadline;    /* sga_cpu() value of the thread that works, likewise; 0: none */
    double seconds;         /* what was granted, for the message */
    int max_nodes;          /* expression nodes; 0: none */
    int max_generations;
    size_t max_memory;      /* bytes that the job may add to the process; 0: none (watch.h measures) */
    long max_terms;         /* of one polynomial in normal forms; 0: what each caller thinks right */
    bool (*cancelled)(void *ctx);  /* may be NULL */
    void *cancel_ctx;
    struct sga_warnings *warnings; /* the job's list (warnings.h); NULL: nobody asks for them */
    struct sga_share *share;       /* how far it is (share.h); NULL: nobody asks */
    struct sga_exec *exec;  /* memory for machine code (exec.h); NULL: formulas are interpreted */
};

/* Monotonic seconds. */
double sga_now(void);
/* CPU seconds of this thread. */
double sga_cpu(void);
/* True while work may go on; otherwise fills err (LIMIT_SECONDS, LIMIT_MEMORY,
 * CANCELLED). */
bool sga_budget_ok(const struct sga_budget *b, struct sga_error *err);

#endif
