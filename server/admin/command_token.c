/* sgad token create | list | revoke. The token itself is printed once and kept nowhere. */
#include "command.h"
#include "clock.h"
#include "tokens.h"

#include <errno.h>
#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TOKEN_BYTES = 32, DAY = 86400 };

struct wish {
    const char *name, *scope, *expires, *jobs, *bytes, *waiters, *seconds, *state, *store, *config;
};

static const char usage[] =
    "usage: sgad token create --state DIR --name NAME [--scope submit,read] [--expires 90d] [--jobs N]\n"
    "                         [--bytes N] [--waiters N] [--seconds N]\n"
    "       sgad token list --state DIR\n"
    "       sgad token revoke --state DIR --name NAME\n"
    "\n"
    "Scopes: submit (post and cancel jobs), read (jobs, events, metrics), admin (all, and cancel\n"
    "the jobs of others). --expires: a number with s, m, h or d, or never (the default). Quotas, 0 for\n"
    "none: jobs that wait or run, bytes of waiting requests, requests that wait, seconds of running in\n"
    "one hour. --config FILE or --store\n"
    "postgresql://... may stand for --state DIR. A running daemon notices within two seconds.\n";

static int bad(const char *what, const char *which)
{
    fprintf(stderr, "sgad: %s%s\n%s", what, which, usage);
    return COMMAND_USAGE;
}

static bool read_wish(int argc, char **argv, struct wish *w)
{
    const struct { const char *name; const char **at; } options[] = {
        { "name", &w->name }, { "scope", &w->scope }, { "expires", &w->expires }, { "jobs", &w->jobs }, { "bytes", &w->bytes },
        { "waiters", &w->waiters }, { "seconds", &w->seconds }, { "state", &w->state }, { "store", &w->store }, { "config", &w->config },
    };
    for (int i = 3; i < argc; i++) {
        const char *value = NULL, *arg = argv[i];
        for (size_t k = 0; !value && k < sizeof options / sizeof *options; k++)
            if ((value = command_option(argc, argv, &i, options[k].name)))
                *options[k].at = value;
        if (!value) {
            bad("unknown option, or one without a value: ", arg);
            return false;
        }
    }
    return true;
}

static bool read_count(const char *text, long *out)
{
    char *end;
    if (!text)
        return true;
    errno = 0;
    *out = strtol(text, &end, 10);
    return !errno && end != text && !*end && *out >= 0;
}

/* A time from now on; 0 for never. */
static bool read_expiry(const char *text, int64_t now, int64_t *out)
{
    char *end;
    *out = 0;
    if (!text || strcmp(text, "never") == 0)
        return true;
    errno = 0;
    long n = strtol(text, &end, 10);
    const char *units = "smhd", *unit = *end ? strchr(units, *end) : NULL;
    static const long seconds[] = { 1, 60, 3600, DAY };
    if (errno || end == text || !unit || end[1] || n <= 0 || n > 100000L * DAY / seconds[unit - units])
        return false;
    *out = now + n * seconds[unit - units];
    return true;
}

static bool plain_name(const char *name)
{
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_.@";
    size_t n = strlen(name);
    return n > 0 && n < ACCOUNT_NAME && strspn(name, plain) == n;
}

static bool draw(char text[2 * TOKEN_BYTES + 6])
{
    unsigned char bits[TOKEN_BYTES];
    if (gnutls_rnd(GNUTLS_RND_KEY, bits, sizeof bits) != 0)
        return false;
    strcpy(text, "sgad_");
    for (int i = 0; i < TOKEN_BYTES; i++)
        snprintf(text + 5 + 2 * i, 3, "%02x", bits[i]);
    gnutls_memset(bits, 0, sizeof bits);
    return true;
}

static int create(const struct wish *w, const char *state)
{
    struct token t = { .created = clock_ms() / 1000 };
    char text[2 * TOKEN_BYTES + 6], why[512];
    if (!w->name || !plain_name(w->name))
        return bad("--name needs letters, digits, and - _ . @, at most 63 of them", "");
    if (!(t.scopes = scopes_read(w->scope ? w->scope : "submit,read")))
        return bad("--scope is a list of submit, read, watch and admin, not ", w->scope);
    if (!read_expiry(w->expires, t.created, &t.expires))
        return bad("--expires is a time such as 30d, or never, not ", w->expires);
    if (!read_count(w->jobs, &t.quota.jobs) || !read_count(w->bytes, &t.quota.bytes)
        || !read_count(w->waiters, &t.quota.waiters) || !read_count(w->seconds, &t.quota.seconds))
        return bad("a quota is a whole number from 0", "");
    strcpy(t.name, w->name);
    if (!draw(text)) {
        fprintf(stderr, "sgad: there are no random numbers\n");
        return COMMAND_FAILED;
    }
    digest(t.sum, text, strlen(text));
    if (!tokens_add(state, &t, why, sizeof why)) {
        fprintf(stderr, "sgad: %s\n", why);
        return COMMAND_FAILED;
    }
    printf("%s\n", text);
    return fflush(stdout) == 0 ? COMMAND_DONE : COMMAND_FAILED;
}

static void put_time(int64_t seconds, const char *none)
{
    char text[CLOCK_TEXT];
    if (seconds)
        clock_text(text, 1000 * seconds);
    printf("\t%s", seconds ? text : none);
}

static int list(const char *state)
{
    struct token_list all;
    char why[512], names[64];
    if (!tokens_read(state, &all, why, sizeof why)) {
        fprintf(stderr, "sgad: %s\n", why);
        return COMMAND_FAILED;
    }
    int64_t now = clock_ms() / 1000;
    printf("name\tstate\tscopes\tcreated\texpires\tjobs\tbytes\twaiters\tseconds\n");
    for (size_t i = 0; i < all.count; i++) {
        const struct token *t = &all.token[i];
        scopes_write(t->scopes, names, sizeof names);
        printf("%s\t%s\t%s", t->name, t->revoked ? "revoked" : t->expires && t->expires <= now ? "expired" : "valid", names);
        put_time(t->created, "-");
        put_time(t->expires, "never");
        printf("\t%ld\t%ld\t%ld\t%ld\n", t->quota.jobs, t->quota.bytes, t->quota.waiters, t->quota.seconds);
    }
    free(all.token);
    return COMMAND_DONE;
}

static int revoke(const struct wish *w, const char *state)
{
    char why[512];
    if (!w->name)
        return bad("--name is missing", "");
    if (tokens_revoke(state, w->name, clock_ms() / 1000, why, sizeof why))
        return COMMAND_DONE;
    fprintf(stderr, "sgad: %s\n", why);
    return COMMAND_FAILED;
}

int command_token(int argc, char **argv)
{
    const char *what = argc > 2 ? argv[2] : "";
    struct wish w = { NULL };
    if (strcmp(what, "--help") == 0 || strcmp(what, "help") == 0) {
        fputs(usage, stdout);
        return COMMAND_DONE;
    }
    if (strcmp(what, "create") != 0 && strcmp(what, "list") != 0 && strcmp(what, "revoke") != 0)
        return bad("token needs create, list or revoke", "");
    if (!read_wish(argc, argv, &w))
        return COMMAND_USAGE;
    char *state = command_place(w.store, w.state, w.config);
    if (!state)
        return COMMAND_USAGE;
    int status = *what == 'c' ? create(&w, state) : *what == 'l' ? list(state) : revoke(&w, state);
    free(state);
    return status;
}
