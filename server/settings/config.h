/* Settings: flags and `key = value` lines of one file share one table of names. */
#ifndef SERVER_CONFIG_H
#define SERVER_CONFIG_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* What each one means stands in settings.c. Texts are fixed once threads run (log-level is main's alone); numbers may
 * be changed by a reload while other threads read them. */
struct config {
    char *listen, *state, *store, *access, *tls_cert, *tls_key, *allow_host, *isolation, *ui, *log_level;
    atomic_long remote_plain, remote_open, interpret_only;
    atomic_long workers;          /* threads that run jobs, each with a child process */
    atomic_long queue, queue_bytes, token_queue, token_workers;
    atomic_long body_limit, child_memory, result_limit;
    atomic_long max_seconds, max_wait;
    atomic_long waiters, streams, connections, address_connections;
    atomic_long idle_timeout, request_timeout, send_timeout, stream_timeout, store_timeout;
    atomic_long grace, lease;
    atomic_long cache_memory, cache_disk, body_memory, reply_memory, unsaved_memory;
    atomic_long keep_days, keep_jobs, keep_bytes, cache_days, cache_results;
};

enum config_result { CONFIG_OK, CONFIG_HELP, CONFIG_VERSION, CONFIG_CHECK, CONFIG_PRINT, CONFIG_SAMPLE, CONFIG_BAD };

/* Defaults, then the file named by --config, then the flags; what they say together is
 * checked too. On CONFIG_BAD the reason is in why. Strings belong to the config. */
enum config_result config_read(struct config *c, int argc, char **argv, char *why, size_t size);
void config_free(struct config *c);
/* Takes over from `fresh` what may change while the service runs, and writes it to changed, as "queue: 1000 -> 5, ...". The
 * names of settings that differ and need a new start go to restart, separated by blanks. Both have size bytes. On the thread that
 * alone reads texts which may change (log-level). */
void config_take_live(struct config *c, const struct config *fresh, char *changed, char *restart, size_t size);
bool config_tokens(const struct config *c);      /* access = tokens */
bool config_isolated(const struct config *c);    /* ... and isolation = token */

/* -- config_print.c -- */

void config_usage(FILE *out);
/* Every setting with its value, as lines of a settings file. */
void config_print(const struct config *c, FILE *out);
/* A settings file in which every default stands as a comment. */
void config_sample(FILE *out);

#endif
