/* What every HTTP handler may use: the parts of the running service, by name. */
#ifndef SERVER_SERVICE_H
#define SERVER_SERVICE_H

#include <stdatomic.h>

struct account;
struct check_threads;
struct config;
struct conns;
struct jobs;
struct listeners;
struct memory_cache;
struct metrics;
struct store;
struct tokens;

struct service {
    struct config *config;
    struct metrics *metrics;
    struct store *store;
    struct memory_cache *memory_cache;
    struct jobs *jobs;
    struct conns *conns;
    struct check_threads *check_threads;
    struct tokens *tokens;          /* NULL where access is open */
    struct account *everyone;       /* of requests without a token */
    const char *const *route_names;   /* by number, for the metrics; NULL at the end */
    const struct listeners *listeners;   /* whose hosts the service answers to; NULL: none */
    atomic_bool leaving;            /* a successor is there: no connection is kept alive any more */
    atomic_long exchanges;          /* requests begun and not completed */
    atomic_long body_bytes;         /* of request bodies in memory */
    atomic_long reply_bytes;        /* of results read from disk, in memory */
    atomic_ulong request_number;
    unsigned request_prefix;        /* random: ids of two lives of the service differ */
};

#endif
