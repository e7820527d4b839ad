/* Read once, before other threads are. */
#include "inherit.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static struct {
    int count, pipe;
    char address[INHERIT_MOST][320];
    bool taken[INHERIT_MOST];
} from = { .pipe = -1 };

static void keep(int fd)
{
    fcntl(fd, F_SETFD, FD_CLOEXEC);
}

void inherit_read(void)
{
    const char *text = getenv(INHERIT_VARIABLE);
    char *at = NULL;
    if (text && strtol(text, &at, 10) == (long)getppid() && *at == ':')
        for (const char *p = at + 1; *p && from.count < INHERIT_MOST;) {
            size_t n = strcspn(p, ",");
            if (n >= sizeof from.address[0])
                break;
            snprintf(from.address[from.count], sizeof from.address[0], "%.*s", (int)n, p);
            keep(INHERIT_FIRST + from.count++);
            p += n + (p[n] == ',');
        }
    unsetenv(INHERIT_VARIABLE);
    if (from.count) {
        from.pipe = INHERIT_FIRST + from.count;
        keep(from.pipe);
    }
}

bool inherited(void)
{
    return from.count > 0;
}

static int find(const char *address, bool free)
{
    for (int i = 0; i < from.count; i++)
        if (strcmp(from.address[i], address) == 0 && !(free && from.taken[i]))
            return i;
    return -1;
}

bool inherit_has(const char *address)
{
    return find(address, false) >= 0;
}

int inherit_take(const char *address)
{
    int i = find(address, true);
    if (i < 0)
        return -1;
    from.taken[i] = true;
    return INHERIT_FIRST + i;
}

void inherit_ready(void)
{
    if (from.pipe < 0)
        return;
    for (int i = 0; i < from.count; i++)
        if (!from.taken[i])
            close(INHERIT_FIRST + i);
    if (write(from.pipe, "1", 1) != 1)
        fprintf(stderr, "sgad: the service that is to be taken over is gone\n");
    close(from.pipe);
    from.pipe = -1;
}
