/* A job by id, wherever it is: alive, among the recent replies, or in the store. */
#ifndef SERVER_LOOKUP_H
#define SERVER_LOOKUP_H

struct account;
struct finished;
struct job;
struct service;
struct sga_error;

enum lookup {
    LOOKUP_LIVE,        /* *job has a reference: it has not ended */
    LOOKUP_RECENT,      /* *finished has a reference; it was in memory */
    LOOKUP_STORED,      /* the same; it was read from the store */
    LOOKUP_NONE,        /* there is no such job */
    LOOKUP_GONE,        /* it was done, but its result was dropped from the store */
    LOOKUP_BROKEN,      /* the store cannot be read */
    LOOKUP_FULL,        /* the same, and it cannot be computed again now: the queue or a quota is full */
    LOOKUP_BUSY         /* results that are being sent take as much memory as they may */
};

enum lookup lookup_job(struct service *sv, const char *id, struct job **job, struct finished **finished);
/* The same, but a job whose result is gone is put into the queue again, where there is room. Only
 * for who may submit: reading starts no work. */
enum lookup lookup_or_run(struct service *sv, struct account *account, const char *id, struct job **job, struct finished **finished);
/* The error of the last five. */
struct sga_error lookup_error(enum lookup outcome);

#endif
