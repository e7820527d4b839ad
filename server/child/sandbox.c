/* The sandbox: resource limits, no new privileges, Landlock without any rule (no file can
 * be opened or made), and a seccomp filter that lists what computing needs. A call outside
 * the list fails with EPERM, so that a library's harmless question does not end a job. */
#define _GNU_SOURCE    /* MREMAP_MAYMOVE */
#include "sandbox.h"

#include <errno.h>
#include <linux/landlock.h>
#include <seccomp.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = 1 };      /* they map terabytes, start threads and read /proc */
#else
enum { SANITIZED = 0 };
#endif

/* Memory, time, the socket, ending. Of prctl, clone, open, ioctl and the like nothing. */
static const int allowed[] = {
    SCMP_SYS(brk), SCMP_SYS(munmap), SCMP_SYS(madvise), SCMP_SYS(futex),
    SCMP_SYS(clock_gettime), SCMP_SYS(clock_nanosleep), SCMP_SYS(nanosleep), SCMP_SYS(gettimeofday), SCMP_SYS(sched_yield),
    SCMP_SYS(getrandom), SCMP_SYS(getrusage), SCMP_SYS(sysinfo), SCMP_SYS(sched_getaffinity),
    SCMP_SYS(sendto), SCMP_SYS(recvfrom), SCMP_SYS(poll), SCMP_SYS(ppoll), SCMP_SYS(read), SCMP_SYS(write), SCMP_SYS(pread64),
    SCMP_SYS(close), SCMP_SYS(fstat), SCMP_SYS(lseek),
    SCMP_SYS(getpid), SCMP_SYS(gettid), SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigreturn),
    SCMP_SYS(restart_syscall), SCMP_SYS(exit), SCMP_SYS(exit_group),
};

static bool fail(char *why, size_t size, const char *what, int number)
{
    snprintf(why, size, "%s: %s", what, strerror(number));
    return false;
}

static bool limit(int which, rlim_t value, char *why, size_t size)
{
    struct rlimit r = { value, value };
    return setrlimit(which, &r) == 0 || fail(why, size, "setrlimit", errno);
}

/* No file can be written, no core left, nothing more opened. */
static bool limit_resources(const struct sandbox *s, char *why, size_t size)
{
    if (!limit(RLIMIT_CORE, 0, why, size))
        return false;
    if (SANITIZED)
        return true;
    signal(SIGXFSZ, SIG_IGN);        /* a write to standard error, where that is a file, just fails */
    return limit(RLIMIT_FSIZE, 0, why, size) && limit(RLIMIT_NOFILE, (rlim_t)s->descriptors, why, size) && limit(RLIMIT_NPROC, 0, why, size)
        && limit(RLIMIT_MEMLOCK, 0, why, size) && (!s->memory || limit(RLIMIT_AS, s->memory, why, size));
}

/* Of a kernel that is newer than its headers: the attributes of ruleset by the versions of Landlock,
 * each of which adds rights at the upper end of its words, and words. A kernel refuses what it does not know. */
struct ruleset { uint64_t files, network, scopes; };

static const struct { uint64_t files, network, scopes; size_t size; } landlock[] = {
    [1] = { 0x1fff, 0, 0, 8 },       /* execute, write, read, list, remove, make */
    [2] = { 0x3fff, 0, 0, 8 },       /* refer */
    [3] = { 0x7fff, 0, 0, 8 },       /* truncate */
    [4] = { 0x7fff, 3, 0, 16 },      /* TCP: bind, connect */
    [5] = { 0xffff, 3, 0, 16 },      /* ioctl of devices */
    [6] = { 0xffff, 3, 3, 24 },      /* abstract sockets and signals to those outside */
};
enum { LANDLOCK_KNOWN = sizeof landlock / sizeof *landlock - 1 };

/* All accesses that this kernel can handle, and no rule: none is left. */
static void forbid_files(void)
{
    long version = syscall(SYS_landlock_create_ruleset, NULL, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1 || SANITIZED)
        return;
    if (version > LANDLOCK_KNOWN)
        version = LANDLOCK_KNOWN;
    struct ruleset all = { landlock[version].files, landlock[version].network, landlock[version].scopes };
    int fd = (int)syscall(SYS_landlock_create_ruleset, &all, landlock[version].size, 0);
    if (fd < 0)
        return;
    syscall(SYS_landlock_restrict_self, fd, 0);
    close(fd);
}

enum { PAGE = 4096 };

/* Machine code of formulas: a page of the range may change from writable to executable. One page a call: more than one could
 * reach beyond the end, which no filter sees. */
static int allow_code(scmp_filter_ctx f, const struct sandbox *s)
{
    if (!s->code_bytes)
        return 0;
    return seccomp_rule_add(f, SCMP_ACT_ALLOW, SCMP_SYS(mprotect), 3,
                            SCMP_A0(SCMP_CMP_MASKED_EQ, ~(scmp_datum_t)(s->code_bytes - 1), (scmp_datum_t)(uintptr_t)s->code),
                            SCMP_A1(SCMP_CMP_LE, (scmp_datum_t)PAGE),
                            SCMP_A2(SCMP_CMP_EQ, PROT_READ | PROT_EXEC));
}

/* realloc() moves memory. Pages of the range stay where they are, and nothing is moved to a place of the caller's choice: executable
 * pages would else be carried out of the range. */
static int allow_moving(scmp_filter_ctx f, const struct sandbox *s)
{
    scmp_datum_t from = (scmp_datum_t)(uintptr_t)s->code;
    if (!s->code_bytes)
        return seccomp_rule_add(f, SCMP_ACT_ALLOW, SCMP_SYS(mremap), 1, SCMP_A3(SCMP_CMP_EQ, MREMAP_MAYMOVE));
    int rc = seccomp_rule_add(f, SCMP_ACT_ALLOW, SCMP_SYS(mremap), 2, SCMP_A0(SCMP_CMP_LT, from), SCMP_A3(SCMP_CMP_EQ, MREMAP_MAYMOVE));
    return rc ? rc : seccomp_rule_add(f, SCMP_ACT_ALLOW, SCMP_SYS(mremap), 2, SCMP_A0(SCMP_CMP_GE, from + s->code_bytes), SCMP_A3(SCMP_CMP_EQ, MREMAP_MAYMOVE));
}

static int add_rules(scmp_filter_ctx f, const struct sandbox *s)
{
    int rc = 0;
    for (size_t i = 0; i < sizeof allowed / sizeof *allowed && rc == 0; i++)
        rc = seccomp_rule_add(f, SCMP_ACT_ALLOW, allowed[i], 0);
    /* Pages may be made read-only or writable; executable only where formulas are compiled to. */
    if (rc == 0)
        rc = seccomp_rule_add(f, SCMP_ACT_ALLOW, SCMP_SYS(mprotect), 1, SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
    /* Nothing shared: the same page could be had twice, written here and executable there. */
    if (rc == 0)
        rc = seccomp_rule_add(f, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 2, SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0), SCMP_A3(SCMP_CMP_MASKED_EQ, MAP_SHARED, 0));
    if (rc == 0)
        rc = allow_code(f, s);
    if (rc == 0)
        rc = allow_moving(f, s);
    /* abort() signals itself. */
    if (rc == 0)
        rc = seccomp_rule_add(f, SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1, SCMP_A0(SCMP_CMP_EQ, (scmp_datum_t)getpid()));
    return rc;
}

static bool filter_calls(const struct sandbox *s, char *why, size_t size)
{
    if (SANITIZED)
        return true;
    scmp_filter_ctx f = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    if (!f)
        return fail(why, size, "seccomp_init", ENOMEM);
    int rc = add_rules(f, s);
    if (rc == 0)
        rc = seccomp_load(f);
    seccomp_release(f);
    return rc == 0 || fail(why, size, "the seccomp filter", -rc);
}

bool sandbox_enter(const struct sandbox *s, char *why, size_t size)
{
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0)
        return fail(why, size, "prctl", errno);
    if (getppid() != s->parent)
        return fail(why, size, "the parent is gone", ESRCH);     /* it died before the line above */
    prctl(PR_SET_DUMPABLE, 0);       /* nobody of the same user may trace it or read its memory */
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        return fail(why, size, "prctl", errno);
    forbid_files();
    return limit_resources(s, why, size) && filter_calls(s, why, size);
}
