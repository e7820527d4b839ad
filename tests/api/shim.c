/* Faults of the environment, between the daemon and the C library (LD_PRELOAD), and a record of what
 * reaches the disk. Both are the tests' own.
 *
 * SHIM_FILE is a file of 64 words of 8 bytes, mapped here and by the test, so that faults are switched
 * while the daemon runs (shim.py has the same names):
 *   SPAWN 1      no process can be started (EAGAIN)
 *   WRITE N      each write to a file takes N milliseconds more
 *   SYNC N       N of 1000 syncs fail (EIO)
 *   CLOCK S      the clock of the day is S seconds ahead
 *   KIND, NTH, LENGTH   calls of one kind from the NTH on, LENGTH of them, fail: writes to files (no room), syncs,
 *                opens, processes, allocations, looks at the clock of the day (from then on 2 hours are gone), lines of
 *                the log. COUNTS + KIND counts the calls of each kind, FAILED those that failed.
 *
 * SHIM_RECORD is a file to which what happens to files below SHIM_FOLDER is appended, in order: see shim.py. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

enum { SPAWN, WRITE, SYNC, CLOCK, KIND, NTH, LENGTH, FAILED, COUNTS, WORDS = 64 };
enum kind { NO_KIND, ON_WRITE, ON_SYNC, ON_OPEN, ON_SPAWN, ON_MEMORY, ON_CLOCK, ON_LOG };
enum { FILES = 65536, BACK = 7200 };

static atomic_llong none[WORDS], *word = none;

/* -- The record -- */

enum { MADE = 1, WROTE, CUT, SYNCED, UNLINKED, RENAMED };
struct head { uint32_t what, path; uint64_t at, length, begun; };

static int record = -1;
static const char *folder;
static size_t folder_length;
static uint64_t position;            /* bytes of the record */
static pthread_mutex_t order = PTHREAD_MUTEX_INITIALIZER;
static char *paths[FILES];           /* of the open files below the folder; never freed */

/* Below the folder, its name without it; NULL: elsewhere. */
static const char *below(const char *path)
{
    if (record < 0 || !folder || strncmp(path, folder, folder_length) != 0 || (path[folder_length] != '/' && path[folder_length] != 0))
        return NULL;
    return path[folder_length] ? path + folder_length + 1 : ".";
}

static const char *of(int fd)
{
    return fd >= 0 && fd < FILES ? paths[fd] : NULL;
}

/* With the lock held, so that the record's order is that of the calls. */
static void put(uint32_t what, const char *path, size_t length_of_path, uint64_t at, const void *data, uint64_t length, uint64_t begun)
{
    struct head h = { what, (uint32_t)length_of_path, at, length, begun };
    struct iovec piece[3] = { { &h, sizeof h }, { (void *)path, length_of_path }, { (void *)data, data ? length : 0 } };
    ssize_t n = syscall(SYS_writev, record, piece, 3);
    if (n > 0)
        position += (uint64_t)n;
}

/* -- The faults -- */

__attribute__((constructor)) static void begin(void)
{
    const char *path = getenv("SHIM_FILE"), *to = getenv("SHIM_RECORD");
    long fd = path ? syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC) : -1;
    if (fd >= 0) {
        void *at = mmap(NULL, WORDS * sizeof *word, PROT_READ | PROT_WRITE, MAP_SHARED, (int)fd, 0);
        if (at != MAP_FAILED)
            word = at;
        syscall(SYS_close, fd);
    }
    folder = getenv("SHIM_FOLDER");
    folder_length = folder ? strlen(folder) : 0;
    if (to)
        record = (int)syscall(SYS_openat, AT_FDCWD, to, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    struct stat st;
    if (record >= 0 && fstat(record, &st) == 0)
        position = (uint64_t)st.st_size;
}

/* Counts the call; whether it is one that fails. */
static int fails(enum kind kind)
{
    long long n = atomic_fetch_add(&word[COUNTS + kind], 1) + 1, first = word[NTH];
    if (word[KIND] != kind || n < first || n >= first + word[LENGTH])
        return 0;
    atomic_fetch_add(&word[FAILED], 1);
    return 1;
}

static void slow(void)
{
    long ms = (long)word[WRITE];
    struct timespec t = { ms / 1000, ms % 1000 * 1000000 };
    if (ms > 0)
        syscall(SYS_nanosleep, &t, NULL);
}

static int is_file(int fd)
{
    struct stat st;
    return fd > 2 && fstat(fd, &st) == 0 && S_ISREG(st.st_mode);
}

ssize_t pwrite(int fd, const void *data, size_t length, off_t at)
{
    slow();
    if (fails(ON_WRITE)) {
        errno = ENOSPC;
        return -1;
    }
    const char *path = of(fd);
    if (!path)
        return syscall(SYS_pwrite64, fd, data, length, at);
    pthread_mutex_lock(&order);
    ssize_t n = syscall(SYS_pwrite64, fd, data, length, at);
    if (n > 0)
        put(WROTE, path, strlen(path), (uint64_t)at, data, (uint64_t)n, 0);
    pthread_mutex_unlock(&order);
    return n;
}

ssize_t pwrite64(int fd, const void *data, size_t length, off_t at)
{
    return pwrite(fd, data, length, at);
}

ssize_t write(int fd, const void *data, size_t length)
{
    if (fd == 2 ? fails(ON_LOG) : is_file(fd) && fails(ON_WRITE)) {
        errno = fd == 2 ? EIO : ENOSPC;
        return -1;
    }
    const char *path = of(fd);
    if (!path)
        return syscall(SYS_write, fd, data, length);
    pthread_mutex_lock(&order);
    off_t at = syscall(SYS_lseek, fd, 0, SEEK_CUR);
    ssize_t n = syscall(SYS_write, fd, data, length);
    if (n > 0)
        put(WROTE, path, strlen(path), (uint64_t)at, data, (uint64_t)n, 0);
    pthread_mutex_unlock(&order);
    return n;
}

int ftruncate(int fd, off_t length)
{
    const char *path = of(fd);
    pthread_mutex_lock(&order);
    int rc = (int)syscall(SYS_ftruncate, fd, length);
    if (rc == 0 && path)
        put(CUT, path, strlen(path), (uint64_t)length, NULL, 0, 0);
    pthread_mutex_unlock(&order);
    return rc;
}

int ftruncate64(int fd, off_t length)
{
    return ftruncate(fd, length);
}

static int sync_by(long call, int fd)
{
    static unsigned seed = 1;
    seed = seed * 1103515245 + 12345;
    if (fails(ON_SYNC) || (seed >> 16) % 1000 < (unsigned)word[SYNC]) {
        errno = EIO;
        return -1;
    }
    const char *path = of(fd);
    pthread_mutex_lock(&order);
    uint64_t begun = position;
    pthread_mutex_unlock(&order);
    int rc = (int)syscall(call, fd);
    if (rc == 0 && path) {
        pthread_mutex_lock(&order);
        put(SYNCED, path, strlen(path), 0, NULL, 0, begun);
        pthread_mutex_unlock(&order);
    }
    return rc;
}

int fsync(int fd)
{
    return sync_by(SYS_fsync, fd);
}

int fdatasync(int fd)
{
    return sync_by(SYS_fdatasync, fd);
}

int open(const char *path, int flags, ...)
{
    va_list ap;
    va_start(ap, flags);
    int mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(ap, int) : 0;
    va_end(ap);
    if (fails(ON_OPEN)) {
        errno = EMFILE;
        return -1;
    }
    const char *name = below(path);
    if (!name)
        return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
    struct stat st;
    pthread_mutex_lock(&order);
    int there = stat(path, &st) == 0, fd = (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
    if (fd >= 0 && fd < FILES) {
        paths[fd] = strdup(name);
        if (!there)
            put(MADE, name, strlen(name), 0, NULL, 0, 0);
        else if (flags & O_TRUNC)
            put(CUT, name, strlen(name), 0, NULL, 0, 0);
    }
    pthread_mutex_unlock(&order);
    return fd;
}

int open64(const char *path, int flags, ...)
{
    va_list ap;
    va_start(ap, flags);
    int mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(ap, int) : 0;
    va_end(ap);
    return open(path, flags, mode);
}

int close(int fd)
{
    if (fd >= 0 && fd < FILES)
        paths[fd] = NULL;
    return (int)syscall(SYS_close, fd);
}

int unlink(const char *path)
{
    const char *name = below(path);
    pthread_mutex_lock(&order);
    int rc = (int)syscall(SYS_unlink, path);
    if (rc == 0 && name)
        put(UNLINKED, name, strlen(name), 0, NULL, 0, 0);
    pthread_mutex_unlock(&order);
    return rc;
}

/* The two names follow each other, with a zero byte between. */
int rename(const char *from, const char *to)
{
    const char *a = below(from), *b = below(to);
    char both[2 * PATH_MAX];
    pthread_mutex_lock(&order);
    int rc = (int)syscall(SYS_rename, from, to);
    if (rc == 0 && a && b && strlen(a) + strlen(b) + 1 < sizeof both) {
        strcpy(both, a);
        strcpy(both + strlen(a) + 1, b);
        put(RENAMED, both, strlen(a) + 1 + strlen(b), 0, NULL, 0, 0);
    }
    pthread_mutex_unlock(&order);
    return rc;
}

int clock_gettime(clockid_t id, struct timespec *t)
{
    int rc = (int)syscall(SYS_clock_gettime, id, t);
    if (rc != 0 || id != CLOCK_REALTIME)
        return rc;
    static atomic_llong back;
    if (fails(ON_CLOCK))
        back = BACK;
    t->tv_sec += word[CLOCK] - back;
    return rc;
}

int posix_spawn(pid_t *pid, const char *path, const posix_spawn_file_actions_t *actions, const posix_spawnattr_t *attributes,
                char *const argv[], char *const envp[])
{
    int (*real)(pid_t *, const char *, const posix_spawn_file_actions_t *, const posix_spawnattr_t *, char *const[], char *const[])
        = dlsym(RTLD_NEXT, "posix_spawn");
    return word[SPAWN] || fails(ON_SPAWN) ? EAGAIN : real(pid, path, actions, attributes, argv, envp);
}

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);

void *malloc(size_t size)
{
    return fails(ON_MEMORY) ? (errno = ENOMEM, NULL) : __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    return fails(ON_MEMORY) ? (errno = ENOMEM, NULL) : __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    return fails(ON_MEMORY) ? (errno = ENOMEM, NULL) : __libc_realloc(old, size);
}
