/* Handing out the pieces of a job's loop, and what became of them. */
#include "helpers.h"
#include "budget.h"
#include "child.h"
#include "child_inbox.h"
#include "config.h"
#include "jobs.h"
#include "metrics.h"
#include "spool.h"

#include <assert.h>
#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

/* Pieces are handed out by parts of what is left for each process, so that all end at about one time, and of so many seconds at the most, so that
 * one that helps soon leaves where its place is wanted; helpers give way to whoever else has work. */
enum { PARTS = 4, NICE = 5 };
static const double SECONDS = 0.5;

struct helper {
    struct child child;
    struct child_inbox in;
    struct wire_pieces has;          /* pieces that it makes; from == to: none */
    double began;
};

struct made { char *data; size_t length; };      /* a helper's message (of spool_new): struct wire_pieces, then what they are */

struct helpers {
    const struct config *config;
    struct jobs *jobs;
    struct metrics *metrics;
    const struct job *job;
    const char *request;
    size_t length;
    double spent, asked;             /* seconds that the job had run for, when that was said */
    double each;                     /* seconds that a piece took until then */
    int next, count, done;           /* pieces: handed out so far, all, those that are made */
    bool waits;                      /* the leader does */
    struct wire_pieces *back;        /* of lost helpers */
    struct made *made;
    int backs, mades;
    int most, helping;
    struct helper helper[];
};

struct helpers *helpers_new(const struct config *c, struct jobs *js, struct metrics *m, const struct job *job, const char *request, size_t length)
{
    size_t most = (size_t)atomic_load(&c->workers);
    struct helpers *h = calloc(1, sizeof *h + most * sizeof *h->helper);
    if (h)
        *h = (struct helpers){ .config = c, .jobs = js, .metrics = m, .job = job, .request = request, .length = length, .most = (int)most };
    return h;
}

/* One is over; pieces that it had are to be made by another. */
static void end_helper(struct helpers *h, int k)
{
    struct helper *e = &h->helper[k];
    char how[128];
    child_end(&e->child, how, sizeof how);
    child_inbox_clear(&e->in);
    jobs_helped(h->jobs, h->job, sga_now() - e->began);
    if (e->has.from < e->has.to)
        h->back[h->backs++] = e->has;            /* there is room for those of each helper: helpers_grow */
    *e = h->helper[--h->helping];
}

void helpers_free(struct helpers *h)
{
    if (!h)
        return;
    while (h->helping)
        end_helper(h, h->helping - 1);
    for (int i = 0; i < h->mades; i++)
        spool_free(h->made[i].data);
    free(h->made);
    free(h->back);
    free(h);
}

/* Pieces that nobody has. */
static int left(const struct helpers *h)
{
    int n = h->count - h->next;
    for (int i = 0; i < h->backs; i++)
        n += h->back[i].to - h->back[i].from;
    return n;
}

/* As many more as workers are idle and pieces are left for. */
static void grow(struct helpers *h)
{
    while (h->helping < h->most && left(h) > h->helping + 1) {
        struct wire_pieces *back = realloc(h->back, (size_t)(h->backs + h->helping + 1) * sizeof *back);
        if (!back)
            return;
        h->back = back;
        if (!jobs_help(h->jobs))
            return;
        struct helper *e = &h->helper[h->helping];
        *e = (struct helper){ .began = sga_now() };
        bool started = child_start(&e->child, CHILD_JOB, h->config);
        metrics_add(h->metrics, started ? METRIC_CHILD_STARTS : METRIC_CHILD_FAILURES);
        if (!started) {
            jobs_helped(h->jobs, h->job, 0);
            return;
        }
        setpriority(PRIO_PROCESS, (id_t)e->child.pid, NICE);
        h->helping++;
    }
}

/* The next pieces for one of the processes; from == to: none. */
static struct wire_pieces hand_out(struct helpers *h)
{
    struct wire_pieces p = { .made = h->done };
    if (h->backs) {
        p = h->back[--h->backs];
        p.made = h->done;
    } else if (h->next < h->count) {
        double part = fmin((h->count - h->next) / (PARTS * (h->helping + 1)), SECONDS / fmax(h->each, 1e-9));
        p.from = h->next;
        p.to = h->next += part > 1 ? (int)part : 1;
    }
    return p;
}

static bool send_pieces(int fd, struct wire_pieces p)
{
    return wire_send(fd, WIRE_PIECES, 0, &p, sizeof p);
}

/* What the leader gets: pieces that are made, and its own once there are some, or none is left to wait for. */
static bool answer(struct helpers *h, int fd)
{
    bool ok = true;
    for (int i = 0; i < h->mades; i++) {
        ok = ok && wire_send(fd, WIRE_MADE, 0, h->made[i].data, h->made[i].length);
        spool_free(h->made[i].data);
    }
    h->mades = 0;
    bool others = false;
    for (int k = 0; k < h->helping; k++)
        others |= h->helper[k].has.from < h->helper[k].has.to;
    h->waits = !left(h) && others;
    if (!ok || h->waits)
        return ok;
    struct wire_pieces own = hand_out(h);
    h->done += own.to - own.from;            /* they are in its hands */
    return send_pieces(fd, own);
}

bool helpers_shares(const struct helpers *h)
{
    return h && h->count;
}

bool helpers_next(struct helpers *h, int fd)
{
    grow(h);
    return answer(h, fd);
}

bool helpers_share(struct helpers *h, const struct wire_share *share, int fd)
{
    bool good = h && share->from >= 0 && share->from < share->count && !h->count;
    if (good) {
        h->next = h->done = share->from;
        h->count = share->count;
        h->spent = share->spent;
        h->each = share->each;
        h->asked = sga_now();
        grow(h);
        if (!h->helping)
            h->count = h->next = 0;          /* it may ask again */
    }
    return send_pieces(fd, (struct wire_pieces){ 0, good && h->helping, 0 });
}

int helpers_poll(const struct helpers *h, struct pollfd *fds, int most)
{
    int n = 0;
    for (; h && n < h->helping && n < most; n++)
        fds[n] = (struct pollfd){ .fd = h->helper[n].child.fd, .events = POLLIN };
    return n;
}

static bool keep_made(struct helpers *h, struct helper *e)
{
    struct wire_pieces p;
    struct made *more = realloc(h->made, (size_t)(h->mades + 1) * sizeof *more);
    if (!more)
        return false;
    h->made = more;
    if (e->in.head.length < sizeof p)
        return false;
    memcpy(&p, e->in.data, sizeof p);
    if (p.from != e->has.from || p.to != e->has.to || p.from >= p.to)
        return false;
    h->made[h->mades++] = (struct made){ e->in.data, e->in.head.length };
    e->in.data = NULL;
    h->done += p.to - p.from;
    e->has = (struct wire_pieces){ 0 };
    return true;
}

/* A whole message of a helper. False: it is over. */
static bool handle(struct helpers *h, struct helper *e)
{
    switch (e->in.head.type) {
    case WIRE_READY: {
        struct wire_help help = { h->spent + (sga_now() - h->asked) };
        return wire_send_two(e->child.fd, WIRE_HELP, &help, sizeof help, h->request, h->length);
    }
    case WIRE_PROGRESS:
        return true;
    case WIRE_NEXT:
        if (e->has.from < e->has.to || jobs_help_over(h->jobs))
            return false;
        e->has = hand_out(h);
        return e->has.from < e->has.to && send_pieces(e->child.fd, e->has);
    case WIRE_MADE:
        return keep_made(h, e);
    default:
        return false;
    }
}

bool helpers_look(struct helpers *h, int fd)
{
    if (!h)
        return true;
    for (int k = h->helping - 1; k >= 0; k--) {
        struct helper *e = &h->helper[k];
        enum received r = child_receive(&e->in, e->child.fd, (size_t)h->config->result_limit);
        bool stays = r == RECEIVED_PART || (r == RECEIVED_WHOLE && handle(h, e));
        if (r == RECEIVED_WHOLE)
            child_inbox_clear(&e->in);
        if (!stays)
            end_helper(h, k);
    }
    assert(h->next <= h->count && h->done <= h->count);
    return !h->waits || answer(h, fd);
}
