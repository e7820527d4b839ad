/* Settings. The table below is the only list: flags, file keys and --help come from it. */
#include "config.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct setting {
    const char *name;
    size_t offset;
    bool text;
    long value, low, high;    /* default and range of a number */
    const char *help;
};

#define AT(member) offsetof(struct config, member)
#define MB (1L << 20)

static const struct setting settings[] = {
    { "listen", AT(listen), true, 0, 0, 0, "HOST:PORT to listen on, a loopback address; port 0: any free one" },
    { "state", AT(state), true, 0, 0, 0, "folder that keeps the queue and the results" },
    { "allow-host", AT(allow_host), true, 0, 0, 0, "further host names to serve, separated by commas" },
    { "log-level", AT(log_level), true, 0, 0, 0, "error, warn, info or debug" },
    { "workers", AT(workers), false, 0, 0, 256, "jobs that run at one time; 0: one for each processor" },
    { "queue", AT(queue), false, 1000, 1, 1000000, "jobs that wait at most" },
    { "queue-bytes", AT(queue_bytes), false, 256 * MB, 1024, 1L << 40, "bytes of the requests that wait" },
    { "body-limit", AT(body_limit), false, 4 * MB, 64, 1L << 30, "bytes of a request body" },
    { "child-memory", AT(child_memory), false, 4096 * MB, 0, 1L << 44, "address space of one job in bytes; 0: no limit" },
    { "result-limit", AT(result_limit), false, 256 * MB, 1024, 1L << 30, "bytes of one result" },
    { "max-seconds", AT(max_seconds), false, 3600, 1, 31536000, "seconds that one job may run" },
    { "max-wait", AT(max_wait), false, 300, 0, 3600, "seconds that one request may wait for its job" },
    { "waiters", AT(waiters), false, 800, 0, 100000, "requests that wait for a job at one time" },
    { "streams", AT(streams), false, 300, 0, 100000, "event streams at one time" },
    { "connections", AT(connections), false, 2000, 2, 100000, "connections at one time" },
    { "idle-timeout", AT(idle_timeout), false, 60, 1, 3600, "seconds that a connection may be silent" },
    { "request-timeout", AT(request_timeout), false, 90, 1, 3600, "seconds in which a whole request must arrive" },
    { "send-timeout", AT(send_timeout), false, 900, 1, 86400, "seconds in which a whole reply must be taken" },
    { "grace", AT(grace), false, 2, 0, 3600, "seconds that running jobs get at shutdown" },
    { "cache-memory", AT(cache_memory), false, 64 * MB, 0, 1L << 40, "bytes of finished replies kept in memory" },
};
enum { SETTINGS = sizeof settings / sizeof *settings };

static const struct setting *find(const char *name, size_t length)
{
    for (int i = 0; i < SETTINGS; i++)
        if (strlen(settings[i].name) == length && memcmp(settings[i].name, name, length) == 0)
            return &settings[i];
    return NULL;
}

static bool set_text(struct config *c, const struct setting *s, const char *value)
{
    char **slot = (char **)((char *)c + s->offset);
    char *copy = strdup(value);
    if (!copy)
        return false;
    free(*slot);
    *slot = copy;
    return true;
}

static bool set(struct config *c, const struct setting *s, const char *value, char *why, size_t size)
{
    if (s->text) {
        if (*value && set_text(c, s, value))
            return true;
        snprintf(why, size, "%s needs a value", s->name);
        return false;
    }
    char *end;
    errno = 0;
    long v = strtol(value, &end, 10);
    if (errno || end == value || *end || v < s->low || v > s->high) {
        snprintf(why, size, "%s must be a whole number from %ld to %ld, not '%s'", s->name, s->low, s->high, value);
        return false;
    }
    *(long *)((char *)c + s->offset) = v;
    return true;
}

static char *trim(char *s)
{
    s += strspn(s, " \t\r\n");
    size_t n = strlen(s);
    while (n && strchr(" \t\r\n", s[n - 1]))
        s[--n] = 0;
    return s;
}

static bool read_line(struct config *c, char *line, char *why, size_t size)
{
    char *key = trim(line);
    if (!*key || *key == '#')
        return true;
    char *equals = strchr(key, '=');
    if (!equals) {
        snprintf(why, size, "expected 'key = value'");
        return false;
    }
    *equals = 0;
    key = trim(key);
    const struct setting *s = find(key, strlen(key));
    if (!s) {
        snprintf(why, size, "there is no setting '%s'", key);
        return false;
    }
    return set(c, s, trim(equals + 1), why, size);
}

static bool read_file(struct config *c, const char *path, char *why, size_t size)
{
    FILE *f = fopen(path, "re");
    if (!f) {
        snprintf(why, size, "cannot read %s: %s", path, strerror(errno));
        return false;
    }
    char *line = NULL;
    size_t cap = 0;
    bool ok = true;
    char reason[256];
    for (int number = 1; ok && getline(&line, &cap, f) >= 0; number++)
        if (!(ok = read_line(c, line, reason, sizeof reason)))
            snprintf(why, size, "%s:%d: %s", path, number, reason);
    free(line);
    fclose(f);
    return ok;
}

static bool defaults(struct config *c)
{
    memset(c, 0, sizeof *c);
    for (int i = 0; i < SETTINGS; i++)
        if (!settings[i].text)
            *(long *)((char *)c + settings[i].offset) = settings[i].value;
    return (c->log_level = strdup("info")) != NULL;
}

/* One pass over the flags: the first looks for --config only, the second sets. */
static enum config_result read_flags(struct config *c, int argc, char **argv, const char **file, char *why, size_t size)
{
    for (int i = 1; i < argc; i++) {
        const char *arg = argv[i];
        if (strcmp(arg, "--help") == 0 || strcmp(arg, "-h") == 0)
            return CONFIG_HELP;
        if (strcmp(arg, "--version") == 0)
            return CONFIG_VERSION;
        if (strncmp(arg, "--", 2) != 0) {
            snprintf(why, size, "unexpected argument '%s'", arg);
            return CONFIG_BAD;
        }
        const char *name = arg + 2, *equals = strchr(name, '=');
        size_t length = equals ? (size_t)(equals - name) : strlen(name);
        bool is_file = length == 6 && memcmp(name, "config", 6) == 0;
        const struct setting *s = find(name, length);
        if (!s && !is_file) {
            snprintf(why, size, "unknown option '%.*s'", (int)length + 2, arg);
            return CONFIG_BAD;
        }
        if (!equals && i + 1 >= argc) {
            snprintf(why, size, "%s needs a value", arg);
            return CONFIG_BAD;
        }
        const char *value = equals ? equals + 1 : argv[++i];
        if (is_file)
            *file = value;
        else if (c && !set(c, s, value, why, size))
            return CONFIG_BAD;
    }
    return CONFIG_OK;
}

enum config_result config_read(struct config *c, int argc, char **argv, char *why, size_t size)
{
    const char *file = NULL;
    if (!defaults(c)) {
        snprintf(why, size, "out of memory");
        return CONFIG_BAD;
    }
    enum config_result got = read_flags(NULL, argc, argv, &file, why, size);
    if (got != CONFIG_OK)
        return got;
    if (file && !read_file(c, file, why, size))
        return CONFIG_BAD;
    got = read_flags(c, argc, argv, &file, why, size);
    if (got != CONFIG_OK)
        return got;
    if (!c->listen || !c->state) {
        snprintf(why, size, "%s is required", c->listen ? "--state" : "--listen");
        return CONFIG_BAD;
    }
    if (c->workers == 0)
        c->workers = sysconf(_SC_NPROCESSORS_ONLN) > 0 ? sysconf(_SC_NPROCESSORS_ONLN) : 1;
    return CONFIG_OK;
}

void config_free(struct config *c)
{
    for (int i = 0; i < SETTINGS; i++)
        if (settings[i].text)
            free(*(char **)((char *)c + settings[i].offset));
}

void config_usage(FILE *out)
{
    fprintf(out, "usage: sgad --listen 127.0.0.1:PORT --state DIR [--workers N] [--config FILE] [--NAME VALUE ...]\n\n"
                 "A file holds lines `NAME = VALUE` with the same names; flags override it.\n\n");
    for (int i = 0; i < SETTINGS; i++) {
        fprintf(out, "  --%-16s %s", settings[i].name, settings[i].help);
        if (!settings[i].text)
            fprintf(out, " (%ld)", settings[i].value);
        fputc('\n', out);
    }
    fprintf(out, "  --%-16s %s\n  --%-16s %s\n", "config", "file of settings", "version", "print the version");
    fprintf(out, "  --%-16s %s\n", "check-sandbox", "try what the processes that run jobs must not be able to do, and say what came of it");
}
