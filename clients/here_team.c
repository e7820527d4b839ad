/* Work sharing by fork: a copy goes on where the library asked for help, with all that was computed so far. Pieces are taken from a counter in
 * shared memory; what a copy makes it writes into a file without a name, which is read once all is taken. */
#define _GNU_SOURCE    /* memfd_create */
#include "here_team.h"

#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PARTS = 4 };              /* for each process, of what is left, at a time */

struct here_team {
    struct sga_team team;
    int processes;               /* at most */
    int count;                   /* of all pieces */
    atomic_int *next;            /* shared: the first piece that nobody has */
    struct copy { pid_t pid; FILE *file; } *copy;    /* of one that is a copy itself: its own place, the last */
    int copies;
    unsigned char *there;        /* by piece: made by a copy, and taken */
};

/* What stands in a copy's file before each piece of data. */
struct chunk { int from, to; size_t length; };

static bool take_pieces(struct here_team *t, int *from, int *to)
{
    int first = atomic_load(t->next), part;
    do {
        part = (t->count - first) / (PARTS * t->processes);
        part = part > 1 ? part : 1;
        if (first >= t->count)
            return false;
    } while (!atomic_compare_exchange_weak(t->next, &first, first + part));
    *from = first;
    *to = first + part;
    return true;
}

/* Begins one copy. True in the copy. */
static bool fork_one(struct here_team *t)
{
    struct copy *c = &t->copy[t->copies];
    int fd = memfd_create("sets", MFD_CLOEXEC);
    if (fd < 0 || !(c->file = fdopen(fd, "w+"))) {
        if (fd >= 0)
            close(fd);
        return false;
    }
    pid_t parent = getpid();
    fflush(NULL);                /* nothing is printed twice */
    c->pid = fork();
    if (c->pid < 0)
        fclose(c->file);
    else
        t->copies++;
    if (c->pid != 0)
        return false;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent)
        _exit(1);
    t->team.member = true;
    return true;
}

static bool share(void *ctx, int from, int count, double spent, double each)
{
    struct here_team *t = ctx;
    (void)spent;
    (void)each;
    if (t->copy)                 /* it could not be done before */
        return false;
    void *shared = mmap(NULL, sizeof *t->next, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    t->copy = calloc((size_t)t->processes, sizeof *t->copy);
    t->there = calloc((size_t)count, 1);
    t->next = shared == MAP_FAILED ? NULL : shared;
    if (!t->next || !t->copy || !t->there)
        return false;
    t->count = count;
    memset(t->there, 1, (size_t)from);
    atomic_store(t->next, from);
    for (int k = 1; k < t->processes; k++)
        if (fork_one(t))
            return true;
    return t->copies > 0;
}

/* What one copy made, once it has ended. A part that is torn is left out: its pieces are made again. */
static bool take_all(struct here_team *t, struct copy *c)
{
    struct chunk head;
    bool ok = true;
    while (waitpid(c->pid, NULL, 0) < 0)
        ;
    rewind(c->file);
    while (ok && fread(&head, sizeof head, 1, c->file) == 1) {
        char *data = malloc(head.length + 1);
        bool whole = data && fread(data, 1, head.length, c->file) == head.length;
        if (whole) {
            ok = t->team.take(t->team.of, head.from, head.to, data, head.length);
            memset(t->there + head.from, 1, (size_t)(head.to - head.from));
        }
        free(data);
        if (!whole)
            break;
    }
    fclose(c->file);
    return ok;
}

static bool next(void *ctx, int *from, int *to, int *made)
{
    struct here_team *t = ctx;
    bool ok = true;
    if (take_pieces(t, from, to)) {
        *made = *to;                 /* nearly: others are at theirs */
        memset(t->there + *from, 1, (size_t)(*to - *from));
        return true;
    }
    if (t->team.member) {
        fflush(t->copy[t->copies - 1].file);
        _exit(0);
    }
    while (ok && t->copies)
        ok = take_all(t, &t->copy[--t->copies]);
    for (*from = 0; *from < t->count && t->there[*from];)
        ++*from;
    *to = *from + 1;
    *made = t->count;
    if (ok && *from < t->count)
        t->there[*from] = 1;
    return ok && *from < t->count;
}

static bool give(void *ctx, int from, int to, const char *data, size_t length)
{
    struct here_team *t = ctx;
    FILE *f = t->copy[t->copies - 1].file;
    struct chunk head = { from, to, length };
    return fwrite(&head, sizeof head, 1, f) == 1 && fwrite(data, 1, length, f) == length;
}

struct here_team *here_team_new(int processes)
{
    struct here_team *t = processes > 1 ? calloc(1, sizeof *t) : NULL;
    if (t)
        *t = (struct here_team){ .team = { .ctx = t, .share = share, .next = next, .give = give }, .processes = processes };
    return t;
}

struct sga_team *here_team_of(struct here_team *t)
{
    return t ? &t->team : NULL;
}

void here_team_free(struct here_team *t)
{
    if (!t)
        return;
    for (int k = 0; k < t->copies; k++) {
        kill(t->copy[k].pid, SIGKILL);
        waitpid(t->copy[k].pid, NULL, 0);
        fclose(t->copy[k].file);
    }
    if (t->next)
        munmap(t->next, sizeof *t->next);
    free(t->copy);
    free(t->there);
    free(t);
}
