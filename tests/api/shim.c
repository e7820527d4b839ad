/* Faults of the environment, between the daemon and the C library (LD_PRELOAD). Each is switched
 * by a line of the file that SHIM_FILE names, while the daemon runs:
 *   spawn 1      no process can be started (EAGAIN)
 *   write N      each write to a file takes N milliseconds more
 *   sync N       N of 1000 syncs fail (EIO)
 *   clock S      the clock of the day is S seconds ahead */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

/* The number behind the name; 0 where there is none. */
static long setting(const char *name)
{
    const char *path = getenv("SHIM_FILE");
    char text[256];
    long fd = path ? syscall(SYS_openat, AT_FDCWD, path, O_RDONLY | O_CLOEXEC) : -1;
    if (fd < 0)
        return 0;
    ssize_t n = syscall(SYS_read, fd, text, sizeof text - 1);
    syscall(SYS_close, fd);
    text[n > 0 ? n : 0] = 0;
    const char *at = strstr(text, name);
    return at ? strtol(at + strlen(name), NULL, 10) : 0;
}

static void slow(void)
{
    long ms = setting("write");
    struct timespec t = { ms / 1000, ms % 1000 * 1000000 };
    if (ms > 0)
        syscall(SYS_nanosleep, &t, NULL);
}

ssize_t pwrite(int fd, const void *data, size_t length, off_t at)
{
    slow();
    return syscall(SYS_pwrite64, fd, data, length, at);
}

ssize_t pwrite64(int fd, const void *data, size_t length, off_t at)
{
    return pwrite(fd, data, length, at);
}

static int fails(void)
{
    static unsigned seed = 1;
    seed = seed * 1103515245 + 12345;
    if ((seed >> 16) % 1000 >= (unsigned)setting("sync"))
        return 0;
    errno = EIO;
    return 1;
}

int fsync(int fd)
{
    return fails() ? -1 : (int)syscall(SYS_fsync, fd);
}

int fdatasync(int fd)
{
    return fails() ? -1 : (int)syscall(SYS_fdatasync, fd);
}

int clock_gettime(clockid_t id, struct timespec *t)
{
    int rc = (int)syscall(SYS_clock_gettime, id, t);
    if (rc == 0 && id == CLOCK_REALTIME)
        t->tv_sec += setting("clock");
    return rc;
}

int posix_spawn(pid_t *pid, const char *path, const posix_spawn_file_actions_t *actions, const posix_spawnattr_t *attributes,
                char *const argv[], char *const envp[])
{
    int (*real)(pid_t *, const char *, const posix_spawn_file_actions_t *, const posix_spawnattr_t *, char *const[], char *const[])
        = dlsym(RTLD_NEXT, "posix_spawn");
    return setting("spawn") ? EAGAIN : real(pid, path, actions, attributes, argv, envp);
}
