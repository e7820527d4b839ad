/* Starting and ending child processes: the parent's side. */
#include "child.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static bool spawn(struct child *c, int end, char *const argv[])
{
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
    posix_spawn_file_actions_adddup2(&fa, end, 3);
    int rc = posix_spawn(&c->pid, "/proc/self/exe", &fa, &attr, argv, environ);
    posix_spawnattr_destroy(&attr);
    posix_spawn_file_actions_destroy(&fa);
    return rc == 0;
}

bool child_start(struct child *c, const struct config *config)
{
    char parent[24], space[24], seconds[24], result[24];
    snprintf(parent, sizeof parent, "%ld", (long)getpid());
    snprintf(space, sizeof space, "%ld", config->child_memory);
    snprintf(seconds, sizeof seconds, "%ld", config->max_seconds);
    snprintf(result, sizeof result, "%ld", config->result_limit);
    char *interpret = config->interpret_only ? "1" : "0";
    char *argv[] = { "sgad", CHILD_FLAG, parent, space, seconds, result, interpret, NULL };
    int pair[2];
    c->pid = 0;
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0)
        return false;
    bool ok = spawn(c, pair[1], argv);
    close(pair[1]);
    if (!ok) {
        close(pair[0]);
        c->pid = 0;
        return false;
    }
    c->fd = pair[0];
    /* A child that has stopped reading must not hold its worker for ever. */
    struct timeval patience = { .tv_sec = 10 };
    setsockopt(c->fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    return true;
}

void child_end(struct child *c, char *how, size_t size)
{
    int status = 0;
    if (!c->pid)
        return;
    kill(c->pid, SIGKILL);
    while (waitpid(c->pid, &status, 0) < 0 && errno == EINTR)
        ;
    if (WIFSIGNALED(status))
        snprintf(how, size, "signal %d (%s)", WTERMSIG(status), strsignal(WTERMSIG(status)));
    else
        snprintf(how, size, "exit code %d", WEXITSTATUS(status));
    close(c->fd);
    c->pid = 0;
}
