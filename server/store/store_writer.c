/* A writer: a list, a thread, and what both writers need of SQLite. */
#include "store_parts.h"

#include <assert.h>

void store_bind_text(sqlite3_stmt *s, int at, const char *text)
{
    if (text)
        sqlite3_bind_text(s, at, text, -1, SQLITE_STATIC);
    else
        sqlite3_bind_null(s, at);
}

void store_bind_sum(sqlite3_stmt *s, int at, const char *id, struct slice text)
{
    unsigned char sum[DIGEST_BYTES];
    digest_kept(sum, id, text.at, text.len);
    sqlite3_bind_blob(s, at, sum, sizeof sum, SQLITE_TRANSIENT);
}

bool store_step(sqlite3_stmt *s)
{
    int rc = sqlite3_step(s);
    sqlite3_reset(s);
    sqlite3_clear_bindings(s);
    return rc == SQLITE_DONE;
}

bool store_exec(sqlite3 *db, const char *sql)
{
    return sqlite3_exec(db, sql, NULL, NULL, NULL) == SQLITE_OK;
}

static void *work(void *arg)
{
    struct store_writer *w = arg;
    for (;;) {
        pthread_mutex_lock(&w->lock);
        while (!w->first && !w->stop)
            pthread_cond_wait(&w->work, &w->lock);
        struct store_op *ops = w->first;
        w->first = NULL;
        w->last = &w->first;
        w->count = 0;
        pthread_mutex_unlock(&w->lock);
        assert(ops || w->stop);
        if (!ops)
            return NULL;
        w->commit(w->store, ops);
    }
}

bool store_writer_start(struct store_writer *w, struct lite *st, void (*commit)(struct lite *, struct store_op *))
{
    w->store = st;
    w->commit = commit;
    w->last = &w->first;
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->work, NULL);
    return w->runs = pthread_create(&w->thread, NULL, work, w) == 0;
}

void store_writer_stop(struct store_writer *w)
{
    if (!w->runs)
        return;
    pthread_mutex_lock(&w->lock);
    w->stop = true;
    pthread_cond_signal(&w->work);
    pthread_mutex_unlock(&w->lock);
    pthread_join(w->thread, NULL);
    w->runs = false;
}

void store_writer_give(struct store_writer *w, struct store_op *ops)
{
    if (!ops)
        return;
    pthread_mutex_lock(&w->lock);
    assert(!*w->last && !w->stop);           /* the results' thread, which gives too, ends before the queue's */
    *w->last = ops;
    for (; *w->last; w->last = &(*w->last)->next)
        w->count++;
    pthread_cond_signal(&w->work);
    pthread_mutex_unlock(&w->lock);
}
