/* The child's side: one request after another, each run or only checked. */
#define _GNU_SOURCE    /* close_range */
#include "child.h"
#include "budget.h"
#include "child_team.h"
#include "child_wire.h"
#include "exec.h"
#include "run.h"
#include "sandbox.h"

#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "error.h"

enum { SOCKET = 3, ARGUMENTS = 7, WALL_EXIT = 3 };
/* Text, libraries and the request itself. */
static const size_t HEADROOM = 96 << 20;
/* Machine code of formulas: 20 bytes for each operation. */
static const size_t CODE = 4 << 20;
static const double PROGRESS_EVERY = 0.5, LOOK_EVERY = 0.02;    /* seconds; a new stage is told at once */

/* What one job may use. */
struct allowance {
    double seconds;
    size_t memory, result;
    struct sga_exec *exec;
};

struct running {
    struct wire_progress told;
    double told_at, looked_at;
    bool cancelled;
};

/* What keeps a bad job inside. The library opens one descriptor, by which it measures its
 * memory: that comes first. */
static bool confine(pid_t parent, size_t memory, const struct sga_exec *exec)
{
    struct sandbox s = { .parent = parent, .memory = memory, .descriptors = SOCKET + 2 };
    if (exec)
        sga_exec_range(exec, &s.code, &s.code_bytes);
    char why[200];
    close_range(SOCKET + 1, ~0U, 0);
    sga_init();
    signal(SIGINT, SIG_IGN);         /* a terminal's ^C goes to the whole group: the parent decides */
    signal(SIGTERM, SIG_IGN);
    if (sandbox_enter(&s, why, sizeof why))
        return wire_send(SOCKET, WIRE_READY, 0, NULL, 0);
    wire_send(SOCKET, WIRE_UNSAFE, 0, why, strlen(why));
    return false;
}

static uint64_t resident(void)
{
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return (uint64_t)u.ru_maxrss * 1024;
}

static void progress(void *ctx, const char *stage, double fraction, double t)
{
    struct running *r = ctx;
    double now = sga_now();
    bool same = strncmp(stage, r->told.stage, sizeof r->told.stage - 1) == 0;
    if (same && now - r->told_at < PROGRESS_EVERY)
        return;
    memset(&r->told, 0, sizeof r->told);
    strncpy(r->told.stage, stage, sizeof r->told.stage - 1);
    r->told.fraction = fraction;
    r->told.t = t;
    r->told_at = now;
    wire_send(SOCKET, WIRE_PROGRESS, 0, &r->told, sizeof r->told);
}

static bool cancelled(void *ctx)
{
    struct running *r = ctx;
    double now = sga_now();
    if (r->cancelled || now - r->looked_at < LOOK_EVERY)
        return r->cancelled;
    r->looked_at = now;
    struct pollfd p = { .fd = SOCKET, .events = POLLIN };
    if (poll(&p, 1, 0) > 0) {
        struct wire_header h;
        if (!wire_read(SOCKET, &h, sizeof h))
            _exit(0);                /* the parent is gone */
        r->cancelled = h.type == WIRE_CANCEL;
    }
    return r->cancelled;
}

static void give(void *ctx, const char *text, size_t length)
{
    (void)ctx;
    if (!wire_send(SOCKET, WIRE_PART, 0, text, length))
        _exit(0);                    /* the parent is gone */
}

/* Memory or time ended inside a library call: the last words, in memory that is there already. */
static void wall(void *ctx, const struct sga_error *err)
{
    (void)ctx;
    wire_send(SOCKET, WIRE_LAST, 0, err, sizeof *err);
    _exit(WALL_EXIT);
}

/* helps: with the pieces of a job that runs elsewhere, and that has run for `spent` seconds. */
static bool run(const char *request, size_t length, const struct allowance *allowed, bool helps, double spent)
{
    struct running r = { .told_at = 0 };
    struct child_team team;
    child_team_begin(&team, SOCKET, &r.cancelled);
    team.team.member = helps;
    team.team.spent = spent;
    struct sga_run_options options = {
        .max_seconds = allowed->seconds, .max_memory = allowed->memory, .max_result = allowed->result,
        .progress = progress, .cancelled = cancelled, .wall = wall, .give = helps ? NULL : give, .ctx = &r,
        .exec = allowed->exec, .team = &team.team,
    };
    struct sga_buf out = { 0 };
    struct sga_error err = { 0 };
    bool ok = sga_run(request, length, &options, &out, &err);
    bool sent = ok ? wire_send(SOCKET, WIRE_DONE, resident(), out.data, out.len)
                   : wire_send(SOCKET, WIRE_ERROR, resident(), &err, sizeof err);
    sga_buf_free(&out);
    return sent;
}

static bool check(const char *request, size_t length)
{
    struct sga_buf out = { 0 };
    struct sga_error err = { 0 };
    bool ok = sga_canonical(request, length, &out, &err);
    bool sent = ok ? wire_send(SOCKET, WIRE_DONE, resident(), out.data, out.len)
                   : wire_send(SOCKET, WIRE_ERROR, resident(), &err, sizeof err);
    sga_buf_free(&out);
    return sent;
}

static bool review(const char *request, size_t length)
{
    struct sga_buf out = { 0 };
    sga_review(request, length, &out);
    bool sent = wire_send(SOCKET, WIRE_DONE, resident(), out.data, out.len);
    sga_buf_free(&out);
    return sent;
}

static const char TASKS[] = { WIRE_RUN, WIRE_HELP, WIRE_CHECK, WIRE_REVIEW, 0 };

static bool task(uint32_t type, const char *request, size_t length, const struct allowance *allowed)
{
    struct wire_help help = { 0 };
    if (type == WIRE_CHECK || type == WIRE_REVIEW)
        return (type == WIRE_CHECK ? check : review)(request, length);
    if (type == WIRE_RUN)
        return run(request, length, allowed, false, 0);
    if (length < sizeof help)
        return false;
    memcpy(&help, request, sizeof help);
    return run(request + sizeof help, length - sizeof help, allowed, true, help.spent);
}

/* Until the socket is closed; the exit code. */
static int serve(const struct allowance *allowed)
{
    struct wire_header h;
    while (wire_read(SOCKET, &h, sizeof h)) {
        if (h.type == WIRE_CANCEL)
            continue;                /* it came after the end of its job */
        char *request = malloc((size_t)h.length + 1);
        if (!strchr(TASKS, (int)h.type) || !request || !wire_read(SOCKET, request, h.length))
            return 1;
        request[h.length] = 0;
        bool sent = task(h.type, request, h.length, allowed);
        free(request);
        if (!sent)
            return 0;
    }
    return 0;
}

int child_main(int argc, char **argv)
{
    if (argc != ARGUMENTS)
        return 2;
    size_t space = strtoul(argv[3], NULL, 10);
    struct sga_exec *exec = atoi(argv[6]) ? NULL : sga_exec_new(CODE);
    if (!confine((pid_t)atol(argv[2]), space, exec)) {
        sga_exec_free(exec);
        return 1;
    }
    /* The library's own wall stands a quarter past its limit: both are inside the space. */
    struct allowance allowed = {
        .seconds = atof(argv[4]), .result = strtoul(argv[5], NULL, 10), .exec = exec,
        .memory = space > 2 * HEADROOM ? (size_t)(0.8 * (double)(space - HEADROOM)) : space / 3,
    };
    int status = serve(&allowed);
    sga_exec_free(exec);
    return status;
}
