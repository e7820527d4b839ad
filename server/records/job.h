/* What a job is, apart from how it is run: its stored row, and the object users see. */
#ifndef SERVER_JOB_H
#define SERVER_JOB_H

#include <stdbool.h>
#include <stdint.h>

#include "digest.h"
#include "quota.h"

struct sga_json;

#define JOB_STATUS_TABLE(X) \
    X(QUEUED, "queued") X(RUNNING, "running") X(DONE, "done") X(FAILED, "failed") X(CANCELLED, "cancelled")

enum job_status {
#define X(sym, text) JOB_##sym,
    JOB_STATUS_TABLE(X)
#undef X
    JOB_STATUSES
};

const char *job_status_text(enum job_status status);
/* JOB_STATUSES where the text names none. */
enum job_status job_status_from_text(const char *text, size_t length);
static inline bool job_ended(enum job_status s) { return s >= JOB_DONE; }

/* A row of the store. Times are milliseconds since 1970; 0: not yet. */
struct job_row {
    char id[ID_LENGTH + 1];
    int64_t seq;                 /* grows with each submission; 0: not stored yet */
    enum job_status status;
    int attempts;                /* how often a run was begun before */
    int64_t created, started, finished;
    char *error;                 /* problem object of a job that failed; owned, or NULL */
    char owner[ACCOUNT_NAME];    /* name of the token on whose account it runs; "" where none was needed */
    bool listed;                 /* in a list, which says what it is about: */
    char name[96], form[16];     /* of its system; "" where there is none, or the request is long */
    char verdict[24];            /* "" unless it is done and its result is stored */
    int64_t epoch;               /* of its latest run; see store.h */
    int64_t seconds;             /* that it may run, as reserved when it was accepted */
};

/* The stage of a run that was claimed and has told none yet. */
#define JOB_STAGE_CLAIMED "running"

/* How far a running job is. */
struct job_progress {
    char stage[32];
    double fraction;             /* 0..1 */
    bool moves;                  /* a motion is made, which is at time t of the system */
    double t;
};

/* Opens the job object and writes every member but the result, "cached" as false; the
 * caller closes it. progress may be NULL: then it follows from the status. cached_at,
 * unless NULL, gets the offset of the text `false` in the writer's buffer. */
void job_write_open(struct sga_json *w, const struct job_row *row, const struct job_progress *progress, size_t *cached_at);
/* The whole object of a job that has no result (yet). */
void job_write(struct sga_json *w, const struct job_row *row, const struct job_progress *progress);

#endif
