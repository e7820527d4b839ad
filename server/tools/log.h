/* The log on standard error: one line for each event, JSON for machines, plain text
 * where standard error is a terminal. Any thread may write; a line is one write(2). */
#ifndef SERVER_LOG_H
#define SERVER_LOG_H

#include <stdbool.h>

enum log_level { LOG_L_ERROR, LOG_L_WARN, LOG_L_INFO, LOG_L_DEBUG };

/* Once, before other threads start. */
void log_open(enum log_level level);
/* The level called "error", "warn", "info" or "debug"; false if there is none. */
bool log_level_from_text(const char *text, enum log_level *level);
bool log_wants(enum log_level level);

/* An event with string fields: name, value, ..., ended by NULL. A NULL value leaves
 * its field out. Fields past 8 kB of line are cut. */
void log_event(enum log_level level, const char *event, ...) __attribute__((sentinel));

#endif
