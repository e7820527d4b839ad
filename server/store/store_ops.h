/* What a store consists of, for those who write one: store.h says what each function does. */
#ifndef SERVER_STORE_OPS_H
#define SERVER_STORE_OPS_H

#include "store.h"

struct store_ops {
    bool shared;
    void (*close)(struct store *st);
    void (*limit)(struct store *st, const atomic_long *cache_bytes);
    bool (*healthy)(struct store *st);
    unsigned long long (*free_bytes)(struct store *st);
    unsigned long long (*bytes)(struct store *st, bool results);
    void (*probe)(struct store *st);
    void (*look)(struct store *st);
    void (*touch)(struct store *st, const char *id, int64_t now);

    bool (*submit)(struct store *st, struct store_submission *s, store_done *done, void *ctx);
    bool (*end)(struct store *st, const struct job_row *row, struct slice result, store_done *done, void *ctx);
    bool (*release)(struct store *st, const struct job_row *row, int64_t *next, store_done *done, void *ctx);
    bool (*cancel)(struct store *st, struct store_cancel *c, store_done *done, void *ctx);
    bool (*join)(struct store *st, const char *id, const char *owner);
    bool (*note)(struct store *st, const char *id, const char *owner);
    bool (*withdraw)(struct store *st, const char *id, const char *owner);
    bool (*forget)(struct store *st, const char *id);
    bool (*prune)(struct store *st, const struct store_keep *keep);
    bool (*barrier)(struct store *st, store_done *done, void *ctx);

    enum store_answer (*claim)(struct store *st, const struct store_claimant *who, struct job_row *row, char **request, size_t *length);
    bool (*beat)(struct store *st, const struct store_claimant *who, struct store_beat *beat, int count);
    bool (*reap)(struct store *st, struct store_reaping *r);
    enum store_answer (*look_at)(struct store *st, const char *id, struct job_row *row, struct job_progress *progress);

    enum store_answer (*job)(struct store *st, const char *id, struct job_row *row);
    enum store_answer (*request)(struct store *st, const char *id, char **text, size_t *length);
    enum store_answer (*result)(struct store *st, const char *id, char **text, size_t *length);
    bool (*owners)(struct store *st, const char *id, void (*each)(void *ctx, const char *owner), void *ctx);
    enum store_answer (*owned)(struct store *st, const char *id, const char *owner);
    enum store_answer (*list)(struct store *st, const struct store_query *q, struct store_page *page);

    /* Where it is not shared; else NULL. */
    bool (*started)(struct store *st, const struct job_row *row);
    int64_t (*epoch)(struct store *st);
    bool (*used)(struct store *st, int64_t since, void (*each)(void *ctx, const char *owner, int64_t ms), void *ctx);
    bool (*recover)(struct store *st, void (*each)(void *ctx, const struct job_row *row), void *ctx, char *why, size_t size);

    /* Where it is; else NULL. */
    void (*hint)(struct store *st);
    void (*listen)(struct store *st, double seconds);
};

/* The first member of every store. */
struct store {
    const struct store_ops *ops;
};

#endif
