/* All settings, in the order in which they are shown. */
#include "settings.h"
#include "config.h"

#include <string.h>

#define MB (1L << 20)
#define TEXT(name, member, text, help) { name, offsetof(struct config, member), SETTING_TEXT, false, text, 0, 0, 0, help },
#define LIVE_TEXT(name, member, text, help) { name, offsetof(struct config, member), SETTING_TEXT, true, text, 0, 0, 0, help },
#define FIXED(name, member, value, low, high, help) \
    { name, offsetof(struct config, member), SETTING_NUMBER, false, NULL, value, low, high, help },
#define LIVE(name, member, value, low, high, help) \
    { name, offsetof(struct config, member), SETTING_NUMBER, true, NULL, value, low, high, help },
#define SWITCH(name, member, help) { name, offsetof(struct config, member), SETTING_SWITCH, false, NULL, 0, 0, 1, help },

const struct setting settings[] = {
    TEXT("listen", listen, NULL, "HOST:PORT (port 0: any free one), unix:PATH, or systemd for a socket that systemd passes; several with commas between. Unless said: what systemd passes, else 127.0.0.1:8080")
    TEXT("state", state, NULL, "folder that keeps the queue, the results and the tokens. Unless said: the one that systemd makes (STATE_DIRECTORY)")
    TEXT("store", store, NULL, "postgresql://...: a database that several daemons share instead of files in a folder of their own (see sgad migrate)")
    TEXT("access", access, "open", "open: whoever can connect may ask; tokens: who shows a token made by sgad token create")
    TEXT("tls-cert", tls_cert, NULL, "certificate chain for TLS, a PEM file. Unless said: the credential sgad.tls-cert of systemd, where there is one")
    TEXT("tls-key", tls_key, NULL, "private key of that certificate, a PEM file. Unless said: the credential sgad.tls-key")
    SWITCH("allow-remote-without-tls", remote_plain, "listen off loopback with no encryption, as behind a proxy that encrypts")
    SWITCH("allow-remote-without-tokens", remote_open, "listen off loopback and let in everyone who can connect")
    TEXT("allow-host", allow_host, NULL, "further host names to serve, separated by commas")
    TEXT("isolation", isolation, "none", "none: the same request is the same job, whoever asks; token: each token has jobs of its own, and none can tell what others asked")
    TEXT("ui", ui, "yes", "yes: a page for browsers at /; no: none")
    LIVE_TEXT("log-level", log_level, "info", "error, warn, info or debug")
    FIXED("workers", workers, 0, 0, 256, "jobs that run at one time; 0: one for each processor")
    LIVE("queue", queue, 1000, 1, 1000000, "jobs that wait at most")
    LIVE("queue-bytes", queue_bytes, 256 * MB, 1024, 1L << 40, "bytes of the requests that wait")
    LIVE("token-queue", token_queue, 50, 1, 100, "percent of the queue that the jobs of one token may hold")
    LIVE("token-workers", token_workers, 100, 1, 100, "percent of the workers that the jobs of one token may hold at one time")
    LIVE("body-limit", body_limit, 4 * MB, 64, 1L << 30, "bytes of a request body")
    FIXED("child-memory", child_memory, 4096 * MB, 0, 1L << 44, "address space of one job in bytes; 0: no limit")
    SWITCH("interpret-only", interpret_only, "run formulas without making machine code of them; answers are the same, trajectories take longer")
    LIVE("result-limit", result_limit, 256 * MB, 1024, 1L << 30, "bytes of one result")
    LIVE("max-seconds", max_seconds, 3600, 1, 31536000, "seconds that one job may run")
    LIVE("max-wait", max_wait, 300, 0, 3600, "seconds that one request may wait for its job")
    LIVE("waiters", waiters, 800, 0, 100000, "requests that wait for a job at one time")
    LIVE("streams", streams, 300, 0, 100000, "event streams at one time")
    FIXED("connections", connections, 2000, 2, 100000, "connections at one time to each listening address")
    FIXED("address-connections", address_connections, 1500, 0, 100000, "connections at one time from one address; 0: no limit but the others")
    FIXED("idle-timeout", idle_timeout, 60, 1, 3600, "seconds that a connection may be silent")
    LIVE("request-timeout", request_timeout, 90, 1, 3600, "seconds in which a whole request must arrive")
    LIVE("send-timeout", send_timeout, 900, 1, 86400, "seconds in which a whole reply must be taken")
    LIVE("stream-timeout", stream_timeout, 3600, 1, 604800, "seconds that one event stream lasts; clients come back by themselves")
    LIVE("store-timeout", store_timeout, 60, 1, 3600, "seconds that a reply waits for the disk, before it is a 503")
    LIVE("grace", grace, 2, 0, 3600, "seconds that running jobs get at shutdown")
    FIXED("lease", lease, 15, 2, 3600, "seconds after which other daemons take over the jobs of one that is gone; only where they share a store")
    LIVE("cache-disk", cache_disk, 8192 * MB, 0, 1L << 50, "bytes of results kept on disk, the least recently used go first; 0: no limit")
    LIVE("cache-days", cache_days, 0, 0, 36500, "days that results are kept on disk after they were computed; 0: no limit")
    LIVE("cache-results", cache_results, 0, 0, 1L << 40, "results kept on disk, the latest; 0: no limit")
    LIVE("keep-days", keep_days, 0, 0, 36500, "days that jobs are kept after their end; 0: for ever")
    LIVE("keep-jobs", keep_jobs, 0, 0, 1L << 40, "ended jobs that are kept, the latest; 0: all")
    LIVE("keep-bytes", keep_bytes, 0, 0, 1L << 50, "bytes that jobs take on disk; past them the oldest that have ended go; 0: no limit")
    LIVE("body-memory", body_memory, 512 * MB, 1024, 1L << 40, "bytes of all request bodies that are being read or checked")
    LIVE("reply-memory", reply_memory, 1024 * MB, 1024, 1L << 40, "bytes of results read from disk that are being sent; past it such requests are refused for a while")
    LIVE("unsaved-memory", unsaved_memory, 256 * MB, 0, 1L << 40, "bytes of results that wait for a slow disk; past it no further job is started")
    FIXED("cache-memory", cache_memory, 64 * MB, 0, 1L << 40, "bytes of finished replies kept in memory")
};
const int settings_count = sizeof settings / sizeof *settings;

const struct setting *setting_find(const char *name, size_t length)
{
    for (int i = 0; i < settings_count; i++)
        if (strlen(settings[i].name) == length && memcmp(settings[i].name, name, length) == 0)
            return &settings[i];
    return NULL;
}
