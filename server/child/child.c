/* Starting and ending child processes: the parent's side. */
#define _GNU_SOURCE    /* pipe2 */
#include "child.h"
#include "budget.h"
#include "child_inbox.h"
#include "config.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(SGAD_COVERAGE)
enum { OPEN = 1 };       /* what sanitizers say goes where the service's own words go, and they have options */
#else
enum { OPEN = 0 };
#endif

extern char **environ;
static const double START_SECONDS = 30, LOOK = 0.1;
enum { MESSAGE = 4096 };

/* end: of the socket; said: of the pipe, or -1. */
static bool spawn(struct child *c, int end, int said, char *const argv[])
{
    char *none_at_all[] = { NULL };
    posix_spawn_file_actions_t fa;
    posix_spawnattr_t attr;
    sigset_t none, all;
    posix_spawn_file_actions_init(&fa);
    posix_spawnattr_init(&attr);
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attr, &none);
    posix_spawnattr_setsigdefault(&attr, &all);
    posix_spawnattr_setflags(&attr, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    posix_spawn_file_actions_addopen(&fa, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&fa, 1, "/dev/null", O_WRONLY, 0);
    if (said >= 0)
        posix_spawn_file_actions_adddup2(&fa, said, 2);
    posix_spawn_file_actions_adddup2(&fa, end, 3);
    int rc = posix_spawn(&c->pid, "/proc/self/exe", &fa, &attr, argv, OPEN ? environ : none_at_all);
    posix_spawnattr_destroy(&attr);
    posix_spawn_file_actions_destroy(&fa);
    if (rc != 0)
        errno = rc;
    return rc == 0;
}

static void close_both(const int pair[2])
{
    for (int i = 0; i < 2; i++)
        if (pair[i] >= 0)
            close(pair[i]);
}

bool child_start(struct child *c, const char *role, const struct config *config)
{
    char parent[24], space[24], seconds[24], result[24];
    snprintf(parent, sizeof parent, "%ld", (long)getpid());
    snprintf(space, sizeof space, "%ld", config->child_memory);
    snprintf(seconds, sizeof seconds, "%ld", config->max_seconds);
    snprintf(result, sizeof result, "%ld", config->result_limit);
    char *interpret = config->interpret_only ? "1" : "0";
    char name[16];
    snprintf(name, sizeof name, "%s", role);
    char *argv[] = { name, CHILD_FLAG, parent, space, seconds, result, interpret, NULL };
    int pair[2] = { -1, -1 }, said[2] = { -1, -1 };
    *c = (struct child){ .fd = -1, .said_fd = -1 };
    bool ok = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) == 0
        && (OPEN || pipe2(said, O_CLOEXEC | O_NONBLOCK) == 0)      /* a full pipe keeps nobody: what does not fit is lost */
        && spawn(c, pair[1], said[1], argv);
    if (!ok) {
        c->pid = 0;
        int number = errno;
        close_both(pair);
        close_both(said);
        errno = number;
        return false;
    }
    close(pair[1]);
    if (said[1] >= 0)
        close(said[1]);
    c->fd = pair[0];
    c->said_fd = said[0];
    /* A child that has stopped reading must not hold its worker for ever. */
    struct timeval patience = { .tv_sec = 10 };
    setsockopt(c->fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    return true;
}

/* The end of what it wrote to standard error. */
static void last_words(struct child *c)
{
    char piece[CHILD_SAID];
    size_t used = 0;
    for (ssize_t n; c->said_fd >= 0 && (n = read(c->said_fd, piece, sizeof piece - 1)) > 0; used = (size_t)n)
        memcpy(c->said, piece, (size_t)n);
    while (used && (c->said[used - 1] == '\n' || c->said[used - 1] == 0))
        used--;
    c->said[used] = 0;
}

bool child_lives(const struct child *c)
{
    struct pollfd p = { .fd = c->fd, .events = POLLIN };
    return c->pid && poll(&p, 1, 0) == 0;
}

/* Its first message. */
static bool confined(struct child *c, struct child_patience patience, char *why, size_t size)
{
    struct child_inbox in = { .data = NULL };
    double until = sga_now() + START_SECONDS;
    enum received r;
    do
        r = child_receive_until(&in, c->fd, MESSAGE, sga_now() + LOOK);
    while (r == RECEIVED_PART && sga_now() < until && !patience.over(patience.ctx));
    bool whole = r == RECEIVED_WHOLE;
    bool ready = whole && in.head.type == WIRE_READY;
    if (!ready)
        snprintf(why, size, "%s", whole && in.head.type == WIRE_UNSAFE ? in.data : "it did not say that it had confined itself");
    child_inbox_clear(&in);
    return ready;
}

bool child_renew(struct child *c, const char *role, const struct config *config, struct child_patience patience, char *why, size_t size)
{
    char how[128];
    child_end(c, how, sizeof how);
    if (!child_start(c, role, config)) {
        snprintf(why, size, "%s", strerror(errno));
        return false;
    }
    if (confined(c, patience, why, size))
        return true;
    child_end(c, how, sizeof how);
    return false;
}

int child_end(struct child *c, char *how, size_t size)
{
    int status = 0;
    if (!c->pid)
        return 0;
    kill(c->pid, SIGKILL);
    while (waitpid(c->pid, &status, 0) < 0 && errno == EINTR)
        ;
    if (WIFSIGNALED(status))
        snprintf(how, size, "signal %d (%s)", WTERMSIG(status), strsignal(WTERMSIG(status)));
    else
        snprintf(how, size, "exit code %d", WEXITSTATUS(status));
    last_words(c);
    close(c->fd);
    if (c->said_fd >= 0)
        close(c->said_fd);
    c->pid = 0;
    return status;
}
