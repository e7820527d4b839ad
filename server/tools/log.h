/* The log on standard error: one line for each event, JSON for machines, plain text
 * where standard error is a terminal. Any thread may log and none ever waits for who reads:
 * lines go to a ring of LOG_RING bytes, which one thread writes out. A line that finds the ring
 * full is dropped and counted, and a line `log_dropped` says how many were, once there is room. */
#ifndef SERVER_LOG_H
#define SERVER_LOG_H

#include <stdbool.h>

/* LOG_L_AUDIT: who changed what, or tried to; written whatever the level is. */
enum log_level { LOG_L_AUDIT = -1, LOG_L_ERROR, LOG_L_WARN, LOG_L_INFO, LOG_L_DEBUG };

enum { LOG_RING = 1 << 20 };

/* Once, before other threads start, with the signals blocked that no thread but main takes.
 * Before it, and where its thread cannot be started, lines are written where they are logged. */
void log_open(enum log_level level);
/* Writes what is left, for a second at most: a reader that stands still holds nobody up. Then
 * lines are written where they are logged again. */
void log_close(void);
/* Lines dropped since the start. */
unsigned long log_dropped(void);
/* The level called "error", "warn", "info" or "debug"; false if there is none. */
bool log_level_from_text(const char *text, enum log_level *level);
bool log_wants(enum log_level level);
/* From the next line on. */
void log_set_level(enum log_level level);

/* An event with string fields: name, value, ..., ended by NULL. A NULL value leaves
 * its field out. A name that begins with '#' is of a number: `"#status", "200"` is written as
 * "status":200. Fields past 8 kB of line are cut. */
void log_event(enum log_level level, const char *event, ...) __attribute__((sentinel));

#endif
