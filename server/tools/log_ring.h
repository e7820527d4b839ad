/* Bytes on their way to standard error, which may take them slowly or not at all. Inside the log. */
#ifndef SERVER_LOG_RING_H
#define SERVER_LOG_RING_H

#include <stddef.h>

/* Starts the thread that writes. */
void log_ring_open(void);
/* A line with its newline: copied, or dropped and counted. Never waits for the reader. Without a
 * thread it is one write(2). */
void log_ring_put(const char *line, size_t length);

#endif
