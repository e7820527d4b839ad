/* Settings: flags and `key = value` lines of one file share one table of names. */
#ifndef SERVER_CONFIG_H
#define SERVER_CONFIG_H

#include <stddef.h>
#include <stdio.h>

struct config {
    char *listen;          /* HOST:PORT, a loopback address */
    char *state;           /* folder of the store */
    char *allow_host;      /* further host names served, separated by commas */
    char *log_level;
    long workers;          /* threads that run jobs, each with a child process */
    long queue;            /* jobs waiting at most */
    long queue_bytes;      /* bytes of waiting requests at most */
    long body_limit;       /* bytes of a request body */
    long child_memory;     /* address space of a child, bytes; 0: no limit */
    long result_limit;     /* bytes of one result */
    long max_seconds;      /* of one job */
    long max_wait;         /* seconds that one HTTP request may wait for its job */
    long waiters;          /* HTTP requests waiting for a job at one time */
    long streams;          /* event streams at one time */
    long connections;
    long idle_timeout;     /* seconds without a byte */
    long request_timeout;  /* seconds in which a whole request must have come */
    long send_timeout;     /* seconds in which a whole reply must have gone */
    long grace;            /* seconds that running jobs get at shutdown */
    long cache_memory;     /* bytes of finished replies kept in memory */
};

enum config_result { CONFIG_OK, CONFIG_HELP, CONFIG_VERSION, CONFIG_BAD };

/* Defaults, then the file named by --config, then the flags. On CONFIG_BAD the reason
 * is in why. Strings belong to the config. */
enum config_result config_read(struct config *c, int argc, char **argv, char *why, size_t size);
void config_free(struct config *c);
void config_usage(FILE *out);

#endif
