/* One flag, set by the handler. Calls are not restarted, so that a read that waits for the daemon comes back. */
#include "interrupt.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t said;

static void remember(int number)
{
    (void)number;
    said = 1;
}

void interrupt_catch(void)
{
    struct sigaction a = { .sa_handler = remember, .sa_flags = (int)SA_RESETHAND };
    sigemptyset(&a.sa_mask);
    sigaction(SIGINT, &a, NULL);
}

bool interrupted(void)
{
    return said != 0;
}
