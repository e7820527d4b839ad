/* Orders to the store that is asked, waited for. Jobs have numbers as their names: "7" is the job whose identifier is 7 in 32 digits. */
#ifndef TESTS_CONFORMANCE_ORDERS_H
#define TESTS_CONFORMANCE_ORDERS_H

#define CHECK_SHARED
#include "check.h"
#include "clock.h"
#include "store.h"

extern struct store *store;
/* Two daemons; the leases of the second end soon (lapse: they have ended). Errors that are reported. */
extern const struct store_claimant ann, brief;
extern const char dead[], stopped[];

struct store_submission asks(const char *id, const char *owner, const char *text);
enum store_kept give(struct store_submission *s);
/* The outcome, or -1: it was not kept. */
int submit(const char *id, const char *owner);
int cancel(const char *id, const char *owner);
enum store_kept end_as(const struct job_row *run, enum job_status status, const char *result);
enum store_kept release(const struct job_row *run);
/* All orders before are done. */
void settle(void);
/* The claimed row; its id is "" where there is none. */
struct job_row claim(const struct store_claimant *who);
int number(const char *id);
/* A job's status; -1: there is no such job; -2: the store does not answer. */
int status_of(const char *id);
bool result_is(const struct job_row *run, const char *should);
/* How many were taken from daemons whose leases ended. */
long reap(void);
enum store_beat_answer beat(const struct store_claimant *who, const struct job_row *run, const char *stage);
void lapse(void);

/* lives.c: submissions, leases, attempts, cancelling, whose turn it is. keeping.c: room, lists, what is kept and for how long. */
void check_lives(void);
void check_keeping(void);

#endif
