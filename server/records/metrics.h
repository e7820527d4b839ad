/* Counters and histograms, written as Prometheus text. Any thread may count; nothing here
 * takes a lock. Labels come from closed sets: no ids, no user text. */
#ifndef SERVER_METRICS_H
#define SERVER_METRICS_H

#include <stdatomic.h>

#include "error.h"
#include "job.h"

struct sga_buf;

/*    symbol             name                             help */
#define METRICS_COUNTERS(X) \
    X(CACHE_MEMORY,      "cache_hits_total{from=\"memory\"}", "Requests answered from a finished job") \
    X(CACHE_STORE,       "cache_hits_total{from=\"store\"}",  NULL) \
    X(CACHE_MISSES,      "cache_misses_total",            "Requests that no finished job answered") \
    X(JOBS_NEW,          "jobs_accepted_total",           "Jobs put into the queue") \
    X(JOBS_JOINED,       "jobs_joined_total",             "Requests that met their own job waiting or running") \
    X(CHILD_STARTS,      "child_starts_total",            "Child processes started") \
    X(CHILD_FAILURES,    "child_start_failures_total",    "Child processes that could not be started or confined") \
    X(CHILD_DEATHS,      "child_deaths_total",            "Child processes that died while they ran a job") \
    X(CHILD_KILLS,       "child_kills_total",             "Child processes killed past a deadline or after a cancellation") \
    X(CHILD_WALLS,       "child_walls_total",             "Child processes that ended themselves at the wall of memory or time") \
    X(STORE_COMMITS,     "store_commits_total",           "Transactions committed to the queue file") \
    X(STORE_FAILURES,    "store_failures_total",          "Transactions that failed") \
    X(EVICTED,           "results_evicted_total",         "Results dropped because they took too much room") \
    X(PRUNED,            "jobs_pruned_total",             "Ended jobs removed because of their age or number") \
    X(REAPED,            "connections_reaped_total",      "Connections cut at a deadline") \
    X(PLACES_GIVEN,      "connections_displaced_total",   "Connections without a request that were cut for others, at the limits of an address or a listening socket") \
    X(LOST_CONNECTIONS,  "connections_refused_total",     "Connections refused for lack of memory, or because all that may be open have a request")

enum metrics_counter {
#define X(sym, name, help) METRIC_##sym,
    METRICS_COUNTERS(X)
#undef X
    METRICS_COUNTERS_N
};

/* Where a job is: waiting, handed to a child, or at one of the library's stages. */
#define METRICS_STAGES_TABLE(X) \
    X(QUEUED, "queued") X(RUNNING, "running") X(REDUCTION, "reduction") X(STRUCTURE, "structure") X(TEXTS, "texts") \
    X(WITNESS, "witness") X(TRAJECTORY, "trajectory") X(WRITING, "writing") X(OTHER, "other")

enum metrics_stage {
    STAGE_NONE = -1,
#define X(sym, name) STAGE_##sym,
    METRICS_STAGES_TABLE(X)
#undef X
    METRICS_STAGES
};

enum { METRICS_ROUTES = 20, METRICS_METHODS = 5, METRICS_STATUSES = 23, METRICS_BUCKETS = 14 };

struct histogram {
    atomic_ulong bucket[METRICS_BUCKETS];    /* not cumulative; the last is +Inf */
    atomic_ulong microseconds;
};

struct metrics {
    atomic_ulong counter[METRICS_COUNTERS_N];
    atomic_ulong refused[SGA_E_COUNT];
    atomic_ulong ended[JOB_STATUSES];
    atomic_ulong http[METRICS_ROUTES][METRICS_METHODS][METRICS_STATUSES];
    struct histogram request_seconds, job_seconds, commit_seconds, stage_seconds[METRICS_STAGES];
    atomic_ulong at_stage[METRICS_STAGES];    /* jobs that are there now */
};

/* What is counted elsewhere and only read here. */
struct metrics_now {
    unsigned long queued, running, queue_bytes, waiters, streams, connections;
    bool store_healthy, ready;
    unsigned long log_dropped, ending, ending_bytes;
    unsigned long certificate_expires;        /* seconds since 1970; 0: there is none */
    double oldest;                            /* seconds that the job which waits longest has waited; 0: none waits */
    unsigned long long free_bytes;            /* on the disk of the state */
    unsigned long long queue_file, results_file;   /* bytes of its files, with what is not yet written back into them */
    unsigned long reply_cache;                /* bytes of finished replies in memory */
    const char *version;
};

static inline void metrics_add(struct metrics *m, enum metrics_counter c) { atomic_fetch_add_explicit(&m->counter[c], 1, memory_order_relaxed); }
/* A request is answered; it is counted before the answer can be read, so that whoever has an answer finds it counted. */
void metrics_http(struct metrics *m, int route, const char *method, int status);
/* ... and has ended, its answer sent or given up. */
void metrics_http_took(struct metrics *m, double seconds);
/* A transaction of the queue file, from its begin to its commit or failure. */
void metrics_committed(struct metrics *m, double seconds);
void metrics_job(struct metrics *m, enum job_status status, double seconds);
/* A job moves from one stage, where it was for so long, to another. */
void metrics_moved(struct metrics *m, enum metrics_stage from, enum metrics_stage to, double seconds);
/* STAGE_OTHER where the name is not known. */
enum metrics_stage metrics_stage_of(const char *name);
void metrics_refused(struct metrics *m, enum sga_code code);
/* route_names[route] for each route counted, NULL at the end. */
void metrics_write(const struct metrics *m, const struct metrics_now *now, const char *const *route_names, struct sga_buf *out);

#endif
