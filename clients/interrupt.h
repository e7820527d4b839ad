/* Ctrl-C while a daemon works for us: the job is to be cancelled before this program ends. */
#ifndef CLIENTS_INTERRUPT_H
#define CLIENTS_INTERRUPT_H

#include <stdbool.h>

/* From here on the first SIGINT is only remembered, and ends a read that waits; the second one ends the process. */
void interrupt_catch(void);
bool interrupted(void);

#endif
