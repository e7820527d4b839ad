/* Who asked for a job: it goes on while anybody wants it. */
#include "jobs_parts.h"
#include "store.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

bool jobs_interested(const struct job *job, const struct account *account)
{
    const struct interest *i = job->interests;
    while (i && i->account != account)
        i = i->next;
    return i;
}

void jobs_add_interest(struct job *job, struct account *account)
{
    struct interest *fresh = jobs_interested(job, account) ? NULL : malloc(sizeof *fresh);
    if (!fresh)
        return;
    *fresh = (struct interest){ account, job->interests };
    job->interests = fresh;
}

void jobs_free_interests(struct job *job)
{
    for (struct interest *i = job->interests, *next; i; i = next) {
        next = i->next;
        free(i);
    }
}

static void joined(void *ctx, enum store_kept how)
{
    struct job *job = ctx;
    struct jobs *js = job->table;
    (void)how;           /* the job itself is on disk, and known here as asked for */
    pthread_mutex_lock(&js->lock);
    assert(job->joining > 0);
    job->joining--;
    jobs_notify(js, job);
    pthread_mutex_unlock(&js->lock);
    job_unref(job);
}

void jobs_join(struct jobs *js, struct job *job, struct account *account)
{
    if (jobs_interested(job, account))
        return;
    jobs_add_interest(job, account);
    job_ref(job);
    job->joining++;
    if (store_join(js->store, job->row.id, account->name) && store_barrier(js->store, joined, job))
        return;
    job->joining--;
    atomic_fetch_sub(&job->refs, 1);         /* never the last: the table has one */
}

/* Onto the account of one who still wants it. */
static void move(struct jobs *js, struct job *job, struct account *to)
{
    assert(to != job->account && job->account->alive > 0);
    jobs_dequeue(js, job);
    job->account->alive--;
    job->account->reserved -= (double)job->row.seconds;
    job->account = to;
    to->alive++;
    to->reserved += (double)job->row.seconds;
    jobs_enqueue(js, job);
}

void jobs_withdraw(struct jobs *js, struct job *job, const struct account *account)
{
    struct interest **at = &job->interests;
    while (*at && (*at)->account != account)
        at = &(*at)->next;
    struct interest *old = *at;
    if (!old)
        return;
    *at = old->next;
    free(old);
    store_withdraw(js->store, job->row.id, account->name);
    if (job->queued && job->account == account && job->interests)
        move(js, job, job->interests->account);
}

/* A direct-mapped set: to forget one costs a write that changes nothing but a place in a list. */
static uint32_t *noted(struct jobs *js, const char *id, const char *owner, uint32_t *sum)
{
    *sum = 2166136261u;
    for (; *id; id++)
        *sum = (*sum ^ (unsigned char)*id) * 16777619u;
    for (; *owner; owner++)
        *sum = (*sum ^ (unsigned char)*owner) * 16777619u;
    return &js->noted[*sum % JOBS_NOTED];
}

void jobs_note(struct jobs *js, const char *id, const struct account *account)
{
    uint32_t sum;
    pthread_mutex_lock(&js->lock);
    uint32_t *slot = noted(js, id, account->name, &sum);
    bool fresh = *slot != sum;
    *slot = sum;
    if (fresh)
        store_note(js->store, id, account->name);
    pthread_mutex_unlock(&js->lock);
}

bool jobs_asked(struct jobs *js, const char *id, const struct account *account)
{
    if (!digest_is_id(id, strlen(id)))
        return false;
    pthread_mutex_lock(&js->lock);
    const struct job *job = *jobs_place(js, id);
    bool asked = job && jobs_interested(job, account);
    pthread_mutex_unlock(&js->lock);
    return asked;
}

void jobs_drop_interest(struct jobs *js, const char *id, const struct account *account)
{
    uint32_t sum;
    pthread_mutex_lock(&js->lock);
    *noted(js, id, account->name, &sum) = 0;
    store_withdraw(js->store, id, account->name);
    pthread_mutex_unlock(&js->lock);
}

/* Under no lock: the owners that the store knows, at a start or where a result is made once more. */
static void owned_by(void *ctx, const char *owner)
{
    static const struct quota none;
    struct job *job = ctx;
    struct jobs *js = job->table;
    struct account *account = jobs_account_of(js, owner ? owner : "", &none);
    if (!account)
        return;
    pthread_mutex_lock(&js->lock);
    jobs_add_interest(job, account);
    pthread_mutex_unlock(&js->lock);
}

void jobs_load_interests(struct jobs *js, struct job *job)
{
    store_owners(js->store, job->row.id, owned_by, job);
}
