/* sgad --check-sandbox: what the sandbox keeps out on this kernel, by trying each. */
#define _GNU_SOURCE    /* mremap */
#include "sandbox.h"
#include "code_runs.h"
#include "exec.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static void *code;       /* of the process that tries */
static size_t code_bytes;

static bool opens(void)
{
    return open("/proc/self/exe", O_RDONLY) >= 0 || open("/", O_RDONLY | O_DIRECTORY) >= 0;
}

static bool makes(void)
{
    return open("/tmp/sgad-sandbox-check", O_WRONLY | O_CREAT, 0600) >= 0 || mkdir("/tmp/sgad-sandbox-check", 0700) == 0;
}

static bool looks(void)
{
    struct stat st;
    return stat("/", &st) == 0;
}

static bool talks(void)
{
    return socket(AF_INET, SOCK_STREAM, 0) >= 0 || socket(AF_UNIX, SOCK_STREAM, 0) >= 0;
}

static bool signals(void)
{
    return kill(getppid(), 0) == 0 || kill(-1, 0) == 0;
}

static bool traces(void)
{
    return ptrace(PTRACE_TRACEME, 0, NULL, NULL) == 0;
}

static bool forks(void)
{
    pid_t pid = fork();
    if (pid == 0)
        _exit(0);
    return pid > 0;
}

/* A shell in place of this process would end with 0: sandbox_check takes that as a breach. */
static bool runs(void)
{
    char *argv[] = { "true", NULL }, *envp[] = { NULL };
    execve("/bin/true", argv, envp);
    return false;
}

static bool executes(void)
{
    void *page = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return page != MAP_FAILED && mprotect(page, 4096, PROT_READ | PROT_EXEC) == 0;
}

static bool maps_code(void)
{
    return mmap(NULL, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED;
}

/* The pages where formulas are compiled to: written and run at one time they must not be. */
static bool writes_code(void)
{
    return code_bytes && mprotect(code, 4096, PROT_READ | PROT_WRITE | PROT_EXEC) == 0;
}

/* Did the filter let it through? What fails after it, for want of a mapping, was let through too. */
static bool passed(bool failed)
{
    return !failed || errno != EPERM;
}

/* A page becomes executable in each way that is not one page of the range. */
static bool may_execute(unsigned char *at, size_t bytes)
{
    return code_bytes && passed(mprotect(at, bytes, PROT_READ | PROT_EXEC) != 0);
}

static bool spills(void)
{
    unsigned char *at = code, *end = at + code_bytes;
    return may_execute(end - 4096, 8192) || may_execute(end - 4096, code_bytes) || may_execute(end, 4096) || may_execute(end, 1)
        || may_execute(at - 4096, 4096) || may_execute(at - 4096, 8192) || may_execute(at, 4097) || may_execute(at, code_bytes + 1);
}

/* The last page of the range, made executable as it may be, carried elsewhere. */
static bool carries(void)
{
    unsigned char *last = (unsigned char *)code + code_bytes - 4096;
    void *free_place = mmap(NULL, 8192, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (!code_bytes || mprotect(last, 4096, PROT_READ | PROT_EXEC) != 0)
        return false;
    return passed(mremap(last, 4096, 8192, MREMAP_MAYMOVE) == MAP_FAILED)
        || passed(mremap(last, 4096, 4096, MREMAP_MAYMOVE | MREMAP_FIXED, free_place) == MAP_FAILED)
        || passed(mremap((unsigned char *)code - 4096, 8192, 8192, MREMAP_MAYMOVE | MREMAP_FIXED, free_place) == MAP_FAILED);
}

/* One page at two places, writable at one and executable at the other. */
static bool doubles(void)
{
    return passed(mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0) == MAP_FAILED)
        || passed(mmap((unsigned char *)code - 4096, 8192, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_FIXED, -1, 0) == MAP_FAILED);
}

static bool too_much(void)
{
    return mmap(NULL, (size_t)1 << 30, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED;
}

static const struct { const char *what; bool (*tried)(void); } trial[] = {
    { "open a file", opens }, { "make a file", makes }, { "look at a path", looks }, { "make a socket", talks },
    { "signal a process", signals }, { "be traced", traces }, { "fork", forks }, { "run a program", runs },
    { "make memory executable", executes }, { "map executable memory", maps_code }, { "write where code may run", writes_code },
    { "code beyond its range", spills }, { "carry code elsewhere", carries }, { "see a page twice", doubles },
    { "pass its memory limit", too_much },
};
enum { TRIALS = sizeof trial / sizeof *trial, KEPT = 40, REFUSED = 41, BREACHED = 42 };

/* Not a breach: formulas are compiled where this works, and interpreted where it does not. */
static void say_code(struct sga_exec *memory, int out)
{
    dprintf(out, "%-26s %s\n", "machine code of formulas", code_runs(memory) ? "compiled" : "interpreted");
}

/* Memory before and behind the range, where nothing else is yet: what may not become executable must be there to be tried. */
static void neighbours(void)
{
    unsigned char *at = code;
    if (!code_bytes)
        return;
    mmap(at - code_bytes, code_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0);
    mmap(at + code_bytes, code_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0);
}

/* Tells through a pipe: standard output may be a file, which the sandbox refuses to grow. */
static int try_all(pid_t parent, int out)
{
    struct sga_exec *memory = sga_exec_new(1 << 16);
    if (memory)
        sga_exec_range(memory, &code, &code_bytes);
    neighbours();
    struct sandbox s = { .parent = parent, .memory = 512 << 20, .descriptors = 64, .code = code, .code_bytes = code_bytes };
    char why[200];
    int status = KEPT;
    if (!sandbox_enter(&s, why, sizeof why)) {
        dprintf(out, "cannot enter the sandbox: %s\n", why);
        return REFUSED;
    }
    for (int i = 0; i < TRIALS; i++) {
        bool through = trial[i].tried();
        char line[80];
        int n = snprintf(line, sizeof line, "%-26s %s\n", trial[i].what, through ? "POSSIBLE" : "refused");
        if (write(out, line, (size_t)n) != n || through)
            status = BREACHED;
    }
    say_code(memory, out);
    return status;
}

int sandbox_check(void)
{
    char text[256];
    int status = 0, pair[2];
    if (pipe(pair) != 0)
        return 1;
    pid_t parent = getpid(), pid = fork();
    if (pid == 0)
        _exit(try_all(parent, pair[1]));
    close(pair[1]);
    for (ssize_t n; (n = read(pair[0], text, sizeof text)) > 0;)
        fwrite(text, 1, (size_t)n, stdout);
    close(pair[0]);
    while (pid > 0 && waitpid(pid, &status, 0) < 0 && errno == EINTR)
        ;
    return pid > 0 && WIFEXITED(status) && WEXITSTATUS(status) == KEPT ? 0 : 1;
}
