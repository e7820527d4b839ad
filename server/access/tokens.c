/* The daemon's table of tokens. A look-up hashes what the client shows and compares digests:
 * how long that takes tells nothing about any token. */
#include "tokens.h"
#include "clock.h"
#include "jobs.h"
#include "log.h"
#include "postgres.h"

#include <gnutls/gnutls.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { SETTLED_SECONDS = 2 };

struct tokens {
    pthread_mutex_t lock;          /* guards all below */
    char *path, *folder;
    struct jobs *jobs;
    struct token_list list;
    struct stat seen;
    bool read;                     /* once, at least */
};

static const struct { const char *name; unsigned scope; } scopes[] = {
    { "submit", SCOPE_SUBMIT }, { "read", SCOPE_READ }, { "admin", SCOPE_ADMIN }, { "watch", SCOPE_WATCH },
};
enum { SCOPES = sizeof scopes / sizeof *scopes };

unsigned scopes_read(const char *text)
{
    unsigned set = 0;
    while (*text) {
        size_t n = strcspn(text, ",");
        int i = 0;
        while (i < SCOPES && (strlen(scopes[i].name) != n || memcmp(scopes[i].name, text, n) != 0))
            i++;
        if (i == SCOPES)
            return 0;
        set |= scopes[i].scope;
        text += n + (text[n] == ',');
    }
    return set;
}

void scopes_write(unsigned set, char *out, size_t size)
{
    size_t used = 0;
    *out = 0;
    for (int i = 0; i < SCOPES; i++)
        if (set & scopes[i].scope && used < size)
            used += (size_t)snprintf(out + used, size - used, "%s%s", used ? "," : "", scopes[i].name);
}

struct tokens *tokens_new(const char *folder, struct jobs *jobs)
{
    struct tokens *ts = calloc(1, sizeof *ts);
    if (!ts)
        return NULL;
    pthread_mutex_init(&ts->lock, NULL);
    ts->jobs = jobs;
    ts->folder = strdup(folder);
    ts->path = malloc(strlen(folder) + sizeof "/tokens.db");
    if (!ts->folder || !ts->path) {
        free(ts->path);
        free(ts->folder);
        free(ts);
        return NULL;
    }
    strcpy(ts->path, folder);
    strcat(ts->path, "/tokens.db");
    return ts;
}

void tokens_free(struct tokens *ts)
{
    if (!ts)
        return;
    pthread_mutex_destroy(&ts->lock);
    free(ts->list.token);
    free(ts->path);
    free(ts->folder);
    free(ts);
}

static bool same_file(const struct stat *a, const struct stat *b)
{
    return a->st_ino == b->st_ino && a->st_size == b->st_size && a->st_mtim.tv_sec == b->st_mtim.tv_sec && a->st_mtim.tv_nsec == b->st_mtim.tv_nsec;
}

static const struct token *named(const struct token_list *list, const char *name)
{
    for (size_t i = 0; i < list->count; i++)
        if (strcmp(list->token[i].name, name) == 0)
            return &list->token[i];
    return NULL;
}

/* What the command did to the file, seen from here. Who may write the file may: it names nobody. */
static void tell_changes(const struct token_list *old, const struct token_list *fresh)
{
    char may[64], expires[CLOCK_TEXT];
    for (size_t i = 0; i < fresh->count; i++) {
        const struct token *t = &fresh->token[i], *before = named(old, t->name);
        bool made = !before || memcmp(before->sum, t->sum, sizeof t->sum) != 0;
        scopes_write(t->scopes, may, sizeof may);
        if (t->expires)
            clock_text(expires, 1000 * t->expires);
        if (made)
            log_event(LOG_L_AUDIT, "token_created", "token", t->name, "scopes", may, "expires", t->expires ? expires : NULL, NULL);
        if (t->revoked && (made || !before->revoked))
            log_event(LOG_L_AUDIT, "token_revoked", "token", t->name, NULL);
    }
    for (size_t i = 0; i < old->count; i++)
        if (!named(fresh, old->token[i].name))
            log_event(LOG_L_AUDIT, "token_removed", "token", old->token[i].name, NULL);
}

static bool find_accounts(struct tokens *ts, struct token_list *list)
{
    bool ok = true;
    for (size_t i = 0; ok && i < list->count; i++)
        ok = (list->token[i].account = jobs_account(ts->jobs, list->token[i].name, &list->token[i].quota)) != NULL;
    return ok;
}

/* Read without the lock: a database may take its time. */
static bool refresh_shared(struct tokens *ts, char *why, size_t size)
{
    struct token_list fresh;
    if (!tokens_read(ts->folder, &fresh, why, size))
        return false;
    if (!find_accounts(ts, &fresh)) {
        free(fresh.token);
        snprintf(why, size, "out of memory");
        return false;
    }
    pthread_mutex_lock(&ts->lock);
    if (ts->read)
        tell_changes(&ts->list, &fresh);
    ts->read = true;
    free(ts->list.token);
    ts->list = fresh;
    pthread_mutex_unlock(&ts->lock);
    return true;
}

bool tokens_refresh(struct tokens *ts, bool always, char *why, size_t size)
{
    struct stat now;
    struct token_list fresh;
    if (postgres_address(ts->folder))
        return !always || refresh_shared(ts, why, size);
    pthread_mutex_lock(&ts->lock);
    /* Looked at before it is read: a write in between is seen the next time. */
    if (stat(ts->path, &now) != 0)
        memset(&now, 0, sizeof now);
    bool changed = always || !same_file(&now, &ts->seen), ok = true;
    if (changed && (ok = tokens_read(ts->folder, &fresh, why, size))) {
        ok = find_accounts(ts, &fresh);
        if (ok) {
            if (ts->read)
                tell_changes(&ts->list, &fresh);
            ts->read = true;
            free(ts->list.token);
            ts->list = fresh;
            /* A file time has a coarse tick: two writes in one tick look alike. A file that was
             * written a moment ago is therefore read once more. */
            if (clock_ms() / 1000 - now.st_mtim.tv_sec < SETTLED_SECONDS)
                memset(&now, 0xff, sizeof now);
            ts->seen = now;
        } else {
            free(fresh.token);
            snprintf(why, size, "out of memory");
        }
    }
    pthread_mutex_unlock(&ts->lock);
    return ok;
}

bool tokens_find(struct tokens *ts, const char *text, struct token *out)
{
    unsigned char sum[DIGEST_BYTES];
    bool found = false;
    digest(sum, text, strlen(text));
    int64_t now = clock_ms() / 1000;
    pthread_mutex_lock(&ts->lock);
    for (size_t i = 0; i < ts->list.count && !found; i++) {
        const struct token *t = &ts->list.token[i];
        if (gnutls_memcmp(t->sum, sum, sizeof sum) != 0)
            continue;
        found = !t->revoked && (!t->expires || now < t->expires);
        if (found)
            *out = *t;
    }
    pthread_mutex_unlock(&ts->lock);
    return found;
}
