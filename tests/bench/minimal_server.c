/* The least that a cached answer over HTTP can cost: a libmicrohttpd server that hashes
 * the body (SHA-256) and does one look-up in SQLite: minimal_server DATABASE
 *
 * The table is replies(key BLOB PRIMARY KEY, reply TEXT). Prints the port and serves
 * until its standard input ends. */
#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <microhttpd.h>
#include <pthread.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST = 65536 };

struct body {
    size_t length;
    char text[MOST];
};

struct server {
    pthread_mutex_t lock;
    sqlite3_stmt *find;
};

static enum MHD_Result answer(struct server *s, struct MHD_Connection *connection, const struct body *b)
{
    unsigned char key[32];
    struct MHD_Response *r;
    unsigned status = MHD_HTTP_OK;
    gnutls_hash_fast(GNUTLS_DIG_SHA256, b->text, b->length, key);
    pthread_mutex_lock(&s->lock);
    sqlite3_bind_blob(s->find, 1, key, sizeof key, SQLITE_STATIC);
    if (sqlite3_step(s->find) == SQLITE_ROW) {
        r = MHD_create_response_from_buffer((size_t)sqlite3_column_bytes(s->find, 0), (void *)(size_t)sqlite3_column_text(s->find, 0),
                                            MHD_RESPMEM_MUST_COPY);
    } else {
        r = MHD_create_response_from_buffer(0, "", MHD_RESPMEM_PERSISTENT);
        status = MHD_HTTP_NOT_FOUND;
    }
    sqlite3_reset(s->find);
    pthread_mutex_unlock(&s->lock);
    MHD_add_response_header(r, "Content-Type", "application/json");
    enum MHD_Result done = MHD_queue_response(connection, status, r);
    MHD_destroy_response(r);
    return done;
}

static enum MHD_Result serve(void *cls, struct MHD_Connection *connection, const char *url, const char *method,
                             const char *version, const char *data, size_t *size, void **ctx)
{
    struct body *b = *ctx;
    (void)url;
    (void)method;
    (void)version;
    if (!b) {
        *ctx = calloc(1, sizeof *b);
        return *ctx ? MHD_YES : MHD_NO;
    }
    if (*size) {
        size_t n = *size < MOST - b->length ? *size : MOST - b->length;
        memcpy(b->text + b->length, data, n);
        b->length += n;
        *size = 0;
        return MHD_YES;
    }
    return answer(cls, connection, b);
}

static void completed(void *cls, struct MHD_Connection *connection, void **ctx, enum MHD_RequestTerminationCode how)
{
    (void)cls;
    (void)connection;
    (void)how;
    free(*ctx);
    *ctx = NULL;
}

int main(int argc, char **argv)
{
    static struct server s = { .lock = PTHREAD_MUTEX_INITIALIZER };
    sqlite3 *db = NULL;
    char end;
    if (argc != 2 || sqlite3_open_v2(argv[1], &db, SQLITE_OPEN_READONLY, NULL) != SQLITE_OK
        || sqlite3_prepare_v2(db, "SELECT reply FROM replies WHERE key = ?", -1, &s.find, NULL) != SQLITE_OK) {
        fprintf(stderr, "usage: minimal_server DATABASE (%s)\n", db ? sqlite3_errmsg(db) : "no database");
        return 2;
    }
    struct MHD_Daemon *d = MHD_start_daemon(MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_POLL, 0, NULL, NULL, serve, &s,
                                            MHD_OPTION_THREAD_POOL_SIZE, 2u, MHD_OPTION_NOTIFY_COMPLETED, completed, NULL,
                                            MHD_OPTION_END);
    if (!d)
        return 1;
    printf("%u\n", (unsigned)MHD_get_daemon_info(d, MHD_DAEMON_INFO_BIND_PORT)->port);
    fflush(stdout);
    while (read(0, &end, 1) > 0)
        ;
    MHD_stop_daemon(d);
    sqlite3_finalize(s.find);
    sqlite3_close(db);
    return 0;
}
