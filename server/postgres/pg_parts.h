/* The inside of the shared store. */
#ifndef SERVER_PG_PARTS_H
#define SERVER_PG_PARTS_H

#include <libpq-fe.h>
#include <pthread.h>
#include <stdatomic.h>

#include "store_ops.h"

enum { PG_POOL = 8, PG_HANDS = 3, PG_ARGS = 24, PG_TOUCHED = 256, PG_SCHEMA = 3, PG_SCHEMA_LEAST = 1, PG_SCHEMA_PIECES = 3 };

enum pg_kind { PG_SUBMIT, PG_END, PG_RELEASE, PG_CANCEL, PG_JOIN, PG_NOTE, PG_WITHDRAW, PG_FORGET, PG_PRUNE, PG_TOUCH, PG_BARRIER };

struct pg_order {
    enum pg_kind kind;
    struct job_row row;              /* error is borrowed */
    struct slice text;
    struct store_keep keep;          /* of what is pruned */
    void *what;
    struct pg_barrier *barrier;
    store_done *done;
    void *ctx;
    struct pg_order *next;
};

/* A thread that carries out the orders of its jobs, one statement for each. */
struct pg_hand {
    struct pg *pg;
    pthread_t thread;
    bool runs;
    pthread_mutex_t lock;            /* guards what follows */
    pthread_cond_t work;
    struct pg_order *first, **last;
    int waiting;
    bool stop;
    struct { char id[ID_LENGTH + 1]; double at; } touched[PG_TOUCHED];   /* results whose use was told lately */
    double lost;                     /* sga_now() when an order that nobody waits for was lost; the hand's own */
};

struct pg {
    struct store face;
    char *address;
    const char *version;
    int schema;                      /* that of the start: a step beside a running daemon adds what it does not use */
    struct metrics *metrics;
    const atomic_long *result_limit;
    atomic_bool down, healthy, stop, hinted, looking;
    _Atomic double down_since;         /* sga_now() */
    pthread_mutex_t lock;            /* guards the pool and heard */
    pthread_cond_t free, news;
    PGconn *conn[PG_POOL];
    unsigned known[PG_POOL];         /* bit set: the statements that the connection has prepared; of who has borrowed it */
    bool busy[PG_POOL];
    unsigned long heard;             /* hints that came */
    struct pg_hand hand[PG_HANDS];
    pthread_t keeper;
    bool keeps;
};

static inline struct pg *pg_of(struct store *face) { return (struct pg *)face; }

/* -- pg_conn.c -- */

/* Statements of which a reader waits for an answer: parsed and planned once on each connection. */
enum pg_known { PG_NOT_KNOWN, PG_KNOWN_ROW, PG_KNOWN_RESULT, PG_KNOWN_REQUEST, PG_KNOWN_TOUCH, PG_KNOWN_PIECE };

struct pg_args {
    enum pg_known known;             /* which one it is: always with the same text */
    int count;
    const char *value[PG_ARGS];
    int length[PG_ARGS], format[PG_ARGS];
    char number[PG_ARGS][32];
};
void pg_text(struct pg_args *a, const char *text);          /* NULL is allowed; borrowed */
void pg_number(struct pg_args *a, int64_t n);
void pg_real(struct pg_args *a, double x);
void pg_bytes(struct pg_args *a, struct slice bytes);       /* borrowed; at NULL: null */

/* A connection with the schema's path set; NULL with a reason. Blocks for some seconds at most. */
PGconn *pg_connect(const char *address, char *why, size_t size);
/* Once or twice more: a connection may break while it is made, as where a proxy between ends all that it has, and that is no server that
 * is away. Not where one is known to be. */
PGconn *pg_connect_again(struct pg *p, char *why, size_t size);
/* The database is away, for this reason: asked for until it is back it fails at once, but in the first second or so, in which it is waited for. */
void pg_went_down(struct pg *p, const char *why);
/* A statement on a connection, given up after so many seconds (then the connection is of no use any
 * more). NULL: no answer came; else a result, which may tell of an error. */
PGresult *pg_run(PGconn *c, const char *sql, const struct pg_args *a, bool binary, double seconds);
/* The same on a connection of the pool, once more on a fresh one where it was found dead. NULL: the
 * database is away, or refused the statement, which is logged. */
PGresult *pg_ask(struct pg *p, const char *sql, const struct pg_args *a, bool binary, double seconds);
void pg_pool_close(struct pg *p);
/* Whole number in a column of the text format. */
int64_t pg_int(const PGresult *r, int row, int column);

/* -- pg_orders.c -- */
bool pg_hands_start(struct pg *p);
void pg_hands_stop(struct pg *p);
bool pg_submit(struct store *face, struct store_submission *s, store_done *done, void *ctx);
bool pg_end(struct store *face, const struct job_row *row, struct slice result, store_done *done, void *ctx);
bool pg_release(struct store *face, const struct job_row *row, int64_t *next, store_done *done, void *ctx);
bool pg_cancel(struct store *face, struct store_cancel *c, store_done *done, void *ctx);
bool pg_join(struct store *face, const char *id, const char *owner);
bool pg_note(struct store *face, const char *id, const char *owner);
bool pg_withdraw(struct store *face, const char *id, const char *owner);
bool pg_forget(struct store *face, const char *id);
bool pg_prune(struct store *face, const struct store_keep *keep);
bool pg_barrier(struct store *face, store_done *done, void *ctx);
void pg_touch(struct store *face, const char *id, int64_t now);

/* -- pg_runs.c -- */
enum store_answer pg_claim(struct store *face, const struct store_claimant *who, struct job_row *row, char **request, size_t *length);
bool pg_beat(struct store *face, const struct store_claimant *who, struct store_beat *beat, int count);
bool pg_reap(struct store *face, struct store_reaping *r);

/* -- pg_reads.c -- */
#define PG_ROW "id, seq, status, attempts, created, started, finished, error, owner, seconds, epoch, name, form, verdict, stage, fraction"
bool pg_read_row(const PGresult *r, int line, struct job_row *row);
enum store_answer pg_look_at(struct store *face, const char *id, struct job_row *row, struct job_progress *progress);
enum store_answer pg_job(struct store *face, const char *id, struct job_row *row);
enum store_answer pg_request(struct store *face, const char *id, char **text, size_t *length);
enum store_answer pg_result(struct store *face, const char *id, char **text, size_t *length);
bool pg_owners(struct store *face, const char *id, void (*each)(void *ctx, const char *owner), void *ctx);
enum store_answer pg_owned(struct store *face, const char *id, const char *owner);
enum store_answer pg_list(struct store *face, const struct store_query *q, struct store_page *page);

/* -- pg_pieces.c -- */
/* What of a result stands in its row: all of it, or of a long one the first piece, where the schema has pieces. */
struct slice pg_pieces_first(const struct pg *p, struct slice text);
/* The others of a run's result, *count of them, and the sum of all of it. What was written is no longer in memory. False: they are not all there. */
bool pg_pieces_put(struct pg *p, const char *id, int64_t epoch, struct slice text, unsigned char sum[DIGEST_BYTES], int *count);
/* They are read to `at`, so many bytes, and added to the sum. STORE_NONE: they are not what the row says, as where it was replaced meanwhile. */
enum store_answer pg_pieces_get(struct pg *p, const char *id, int64_t epoch, struct digest_run *d, char *at, size_t left);

/* -- pg_schema.c -- */
/* The schema of the database; 0: none, -1: that cannot be read. */
int pg_schema(PGconn *c);

/* -- pg_keeper.c: a thread that has the connection for hints, tells when the database is back, and drops what is too much -- */
bool pg_keeper_start(struct pg *p);
void pg_keeper_stop(struct pg *p);
void pg_hint(struct store *face);
void pg_listen(struct store *face, double seconds);

#endif
