/* The program is started anew, by its path: SIGUSR2 is how a new version comes into service. */
#define _GNU_SOURCE    /* pipe2 */
#include "successor.h"
#include "inherit.h"
#include "listen.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { READY_MS = 30000, HIGH = 64, VARIABLES = 1024 };

_Static_assert((int)INHERIT_MOST == (int)LISTEN_MOST, "all are handed over");

extern char **environ;

/* Where the program lies; a file that was put in its place counts, not the one that was there when this process began. */
static bool program(char *path, size_t size)
{
    static const char gone[] = " (deleted)";
    ssize_t n = readlink("/proc/self/exe", path, size - 1);
    if (n <= 0)
        return false;
    path[n] = 0;
    size_t k = sizeof gone - 1;
    if ((size_t)n > k && strcmp(path + n - k, gone) == 0)
        path[(size_t)n - k] = 0;
    return true;
}

/* Not for others: who was meant by a process id, and which sockets were passed, is not true of the next process. */
static bool passes(const char *variable)
{
    static const char *const own[] = { "WATCHDOG_PID=", "LISTEN_PID=", "LISTEN_FDS=", "LISTEN_FDNAMES=", INHERIT_VARIABLE "=" };
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (strncmp(variable, own[i], strlen(own[i])) == 0)
            return false;
    return true;
}

static void write_variable(const struct listeners *ls, char *out, size_t size)
{
    int n = snprintf(out, size, "%s=%ld:", INHERIT_VARIABLE, (long)getpid());
    for (int i = 0; i < ls->count; i++)
        n += snprintf(out + n, size - (size_t)n, "%s%s", i ? "," : "", ls->at[i].address);
    assert((size_t)n < size);
}

/* Copies at high numbers, so that none stands where another is to go. */
static int spawn(const struct listeners *ls, int end, char **argv, pid_t *pid)
{
    static char variable[64 + LISTEN_MOST * 321];
    char path[4096], *env[VARIABLES + 2];
    int copy[LISTEN_MOST + 1], n = 0, rc = 0;
    posix_spawn_file_actions_t fa;
    if (!program(path, sizeof path))
        return errno;
    write_variable(ls, variable, sizeof variable);
    for (char **v = environ; *v && n < VARIABLES; v++)
        if (passes(*v))
            env[n++] = *v;
    env[n++] = variable;
    env[n] = NULL;
    posix_spawn_file_actions_init(&fa);
    for (int i = 0; i <= ls->count; i++) {
        copy[i] = fcntl(i < ls->count ? ls->at[i].fd : end, F_DUPFD_CLOEXEC, HIGH);
        rc = copy[i] < 0 ? errno : rc;
        posix_spawn_file_actions_adddup2(&fa, copy[i] < 0 ? end : copy[i], INHERIT_FIRST + i);
    }
    if (!rc)
        rc = posix_spawn(pid, path, &fa, NULL, argv, env);
    posix_spawn_file_actions_destroy(&fa);
    for (int i = 0; i <= ls->count; i++)
        if (copy[i] >= 0)
            close(copy[i]);
    return rc;
}

/* One byte, or its end. */
static bool ready(int fd)
{
    struct pollfd p = { .fd = fd, .events = POLLIN };
    char one;
    int rc;
    while ((rc = poll(&p, 1, READY_MS)) < 0 && errno == EINTR)
        ;
    return rc > 0 && read(fd, &one, 1) == 1;
}

pid_t successor_start(struct listeners *ls, char **argv, char *why, size_t size)
{
    int end[2];
    pid_t pid = 0;
    if (pipe2(end, O_CLOEXEC) != 0) {
        snprintf(why, size, "no pipe: %s", strerror(errno));
        return 0;
    }
    int rc = spawn(ls, end[1], argv, &pid);
    close(end[1]);
    bool prepared = !rc && ready(end[0]);
    close(end[0]);
    if (rc) {
        snprintf(why, size, "it cannot be started: %s", strerror(rc));
        return 0;
    }
    if (!prepared) {
        snprintf(why, size, "it did not become ready; what it said stands before this line");
        kill(pid, SIGKILL);
        waitpid(pid, NULL, 0);
        return 0;
    }
    for (int i = 0; i < ls->count; i++)
        *ls->at[i].path = 0;
    return pid;
}
