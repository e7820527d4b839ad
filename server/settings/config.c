/* Reading settings: defaults, a file, flags, and whether they fit together. */
#include "config.h"
#include "inherit.h"
#include "settings.h"

#include <errno.h>
#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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

static bool set_number(struct config *c, const struct setting *s, long value)
{
    atomic_store((atomic_long *)((char *)c + s->offset), value);
    return true;
}

static bool set(struct config *c, const struct setting *s, const char *value, char *why, size_t size)
{
    if (s->kind == SETTING_TEXT) {
        if (*value && set_text(c, s, value))
            return true;
        snprintf(why, size, "%s needs a value", s->name);
        return false;
    }
    if (s->kind == SETTING_SWITCH) {
        if (strcmp(value, "yes") == 0 || strcmp(value, "no") == 0)
            return set_number(c, s, *value == 'y');
        snprintf(why, size, "%s must be yes or no, not '%s'", s->name, value);
        return false;
    }
    char *end;
    errno = 0;
    long v = strtol(value, &end, 10);
    if (errno || end == value || *end || v < s->low || v > s->high) {
        snprintf(why, size, "%s must be a whole number from %ld to %ld, not '%s'", s->name, s->low, s->high, value);
        return false;
    }
    return set_number(c, s, v);
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
    const struct setting *s = setting_find(key, strlen(key));
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
    for (int i = 0; i < settings_count; i++)
        if (settings[i].kind != SETTING_TEXT)
            set_number(c, &settings[i], settings[i].value);
        else if (settings[i].text && !set_text(c, &settings[i], settings[i].text))
            return false;
    return true;
}

/* Flags that are no settings: what to do instead of serving. */
static enum config_result instead(const char *arg)
{
    static const struct { const char *flag; enum config_result result; } table[] = {
        { "--help", CONFIG_HELP }, { "-h", CONFIG_HELP }, { "--version", CONFIG_VERSION }, { "--check-config", CONFIG_CHECK },
        { "--print-config", CONFIG_PRINT }, { "--sample-config", CONFIG_SAMPLE },
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (strcmp(arg, table[i].flag) == 0)
            return table[i].result;
    return CONFIG_OK;
}

/* One pass over the flags: the first (c is NULL) looks for --config only, the second sets. */
static enum config_result read_flags(struct config *c, int argc, char **argv, const char **file, char *why, size_t size)
{
    enum config_result result = CONFIG_OK;
    for (int i = 1; i < argc; i++) {
        const char *arg = argv[i];
        enum config_result other = instead(arg);
        if (other != CONFIG_OK) {
            result = other;
            continue;
        }
        if (strncmp(arg, "--", 2) != 0) {
            snprintf(why, size, "unexpected argument '%s'", arg);
            return CONFIG_BAD;
        }
        const char *name = arg + 2, *equals = strchr(name, '=');
        size_t length = equals ? (size_t)(equals - name) : strlen(name);
        bool is_file = length == 6 && memcmp(name, "config", 6) == 0;
        const struct setting *s = setting_find(name, length);
        bool bare = s && s->kind == SETTING_SWITCH && !equals;
        if (!s && !is_file) {
            snprintf(why, size, "unknown option '%.*s'", (int)length + 2, arg);
            return CONFIG_BAD;
        }
        if (!equals && !bare && i + 1 >= argc) {
            snprintf(why, size, "%s needs a value", arg);
            return CONFIG_BAD;
        }
        const char *value = equals ? equals + 1 : bare ? "yes" : argv[++i];
        if (is_file)
            *file = value;
        else if (c && !set(c, s, value, why, size))
            return CONFIG_BAD;
    }
    return result;
}

static bool one_of(const char *value, const char *const *allowed)
{
    while (*allowed && strcmp(value, *allowed) != 0)
        allowed++;
    return *allowed != NULL;
}

/* What no single setting can tell. */
static bool consistent(const struct config *c, char *why, size_t size)
{
    static const char *const levels[] = { "error", "warn", "info", "debug", NULL }, *const accesses[] = { "open", "tokens", NULL },
        *const isolations[] = { "none", "token", NULL }, *const answers[] = { "yes", "no", NULL };
    if (!c->state && !c->store)
        snprintf(why, size, "--state is required");
    else if (c->store && strncmp(c->store, "postgresql://", 13) != 0 && strncmp(c->store, "postgres://", 11) != 0)
        snprintf(why, size, "store must be the address of a database, postgresql://..., not '%s'", c->store);
    else if (!one_of(c->log_level, levels))
        snprintf(why, size, "log-level must be error, warn, info or debug, not '%s'", c->log_level);
    else if (!one_of(c->access, accesses))
        snprintf(why, size, "access must be open or tokens, not '%s'", c->access);
    else if (!one_of(c->isolation, isolations))
        snprintf(why, size, "isolation must be none or token, not '%s'", c->isolation);
    else if (!one_of(c->ui, answers))
        snprintf(why, size, "ui must be yes or no, not '%s'", c->ui);
    else if (strcmp(c->isolation, "token") == 0 && !config_tokens(c))
        snprintf(why, size, "isolation = token needs access = tokens");
    else if (!c->tls_cert != !c->tls_key)
        snprintf(why, size, "tls-cert and tls-key belong together; %s is missing", c->tls_cert ? "tls-key" : "tls-cert");
    else if (c->tls_cert && access(c->tls_cert, R_OK) != 0)
        snprintf(why, size, "tls-cert: cannot read %s: %s", c->tls_cert, strerror(errno));
    else if (c->tls_key && access(c->tls_key, R_OK) != 0)
        snprintf(why, size, "tls-key: cannot read %s: %s", c->tls_key, strerror(errno));
    else
        return true;
    return false;
}

/* What systemd hands over: a listening socket (LISTEN_PID), a folder for the state, a certificate
 * and its key as credentials. It counts where nothing else was said. */
static bool adopt(struct config *c, const char *name, const char *value)
{
    return set_text(c, setting_find(name, strlen(name)), value);
}

static bool adopt_credentials(struct config *c)
{
    const char *folder = getenv("CREDENTIALS_DIRECTORY");
    char cert[PATH_MAX], key[PATH_MAX];
    if (!folder || c->tls_cert || c->tls_key)
        return true;
    snprintf(cert, sizeof cert, "%s/sgad.tls-cert", folder);
    snprintf(key, sizeof key, "%s/sgad.tls-key", folder);
    return (access(cert, F_OK) != 0 || adopt(c, "tls-cert", cert)) && (access(key, F_OK) != 0 || adopt(c, "tls-key", key));
}

static bool adopt_missing(struct config *c)
{
    const char *pid = getenv("LISTEN_PID"), *state = getenv("STATE_DIRECTORY");
    bool passed = (pid && strtol(pid, NULL, 10) == (long)getpid()) || inherit_has("systemd");
    return (c->listen || adopt(c, "listen", passed ? "systemd" : "127.0.0.1:8080"))
        && (c->state || !state || !*state || strchr(state, ':') || adopt(c, "state", state)) && adopt_credentials(c);
}

enum config_result config_read(struct config *c, int argc, char **argv, char *why, size_t size)
{
    const char *file = NULL;
    if (!defaults(c)) {
        snprintf(why, size, "out of memory");
        return CONFIG_BAD;
    }
    enum config_result got = read_flags(NULL, argc, argv, &file, why, size);
    if (got == CONFIG_HELP || got == CONFIG_VERSION || got == CONFIG_SAMPLE || got == CONFIG_BAD)
        return got;
    if (file && !read_file(c, file, why, size))
        return CONFIG_BAD;
    got = read_flags(c, argc, argv, &file, why, size);
    if (got == CONFIG_BAD)
        return got;
    if (!adopt_missing(c)) {
        snprintf(why, size, "out of memory");
        return CONFIG_BAD;
    }
    if (got != CONFIG_PRINT && !consistent(c, why, size))
        return CONFIG_BAD;
    if (c->workers == 0)
        c->workers = sysconf(_SC_NPROCESSORS_ONLN) > 0 ? sysconf(_SC_NPROCESSORS_ONLN) : 1;
    return got;
}

static bool differs(const struct config *a, const struct config *b, const struct setting *s)
{
    const char *pa = (const char *)a + s->offset, *pb = (const char *)b + s->offset;
    if (s->kind != SETTING_TEXT)
        return atomic_load((atomic_long *)(uintptr_t)pa) != atomic_load((atomic_long *)(uintptr_t)pb);
    const char *ta = *(char *const *)pa, *tb = *(char *const *)pb;
    return !ta != !tb || (ta && strcmp(ta, tb) != 0);
}

static void value_text(const struct config *c, const struct setting *s, char out[80])
{
    const char *at = (const char *)c + s->offset;
    if (s->kind == SETTING_TEXT)
        snprintf(out, 80, "%.70s", *(char *const *)(uintptr_t)at ? *(char *const *)(uintptr_t)at : "");
    else
        snprintf(out, 80, "%ld", atomic_load((atomic_long *)(uintptr_t)at));
}

void config_take_live(struct config *c, const struct config *fresh, char *changed, char *restart, size_t size)
{
    size_t used = 0, told = 0;
    char before[80], after[80];
    *restart = *changed = 0;
    for (int i = 0; i < settings_count; i++) {
        const struct setting *s = &settings[i];
        if (!differs(c, fresh, s))
            continue;
        if (!s->live) {
            if (used < size)
                used += (size_t)snprintf(restart + used, size - used, "%s%s", used ? " " : "", s->name);
            continue;
        }
        value_text(c, s, before);
        value_text(fresh, s, after);
        if (told < size)
            told += (size_t)snprintf(changed + told, size - told, "%s%s: %s -> %s", told ? ", " : "", s->name, before, after);
        if (s->kind == SETTING_TEXT)
            set_text(c, s, *(char *const *)(uintptr_t)((const char *)fresh + s->offset));
        else
            set_number(c, s, atomic_load((atomic_long *)(uintptr_t)((const char *)fresh + s->offset)));
    }
}

bool config_tokens(const struct config *c)
{
    return strcmp(c->access, "tokens") == 0;
}

bool config_isolated(const struct config *c)
{
    return config_tokens(c) && strcmp(c->isolation, "token") == 0;
}

void config_free(struct config *c)
{
    for (int i = 0; i < settings_count; i++)
        if (settings[i].kind == SETTING_TEXT)
            free(*(char **)((char *)c + settings[i].offset));
}
