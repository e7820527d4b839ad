/* The files of a state folder, for the commands that read or copy them while a daemon may be
 * using them: SQLite's snapshots keep them apart from the daemon's writers. */
#ifndef SERVER_STATE_FILES_H
#define SERVER_STATE_FILES_H

#include <sqlite3.h>
#include <stdbool.h>

enum { STATE_PATH = 4096, STATE_FILES = 3 };

/* In the order of copying: a job that the copied queue calls done has its result in the cache,
 * which is copied after it. */
extern const char *const state_files[STATE_FILES];

/* Opens a file of the state for reading. True with *db NULL: there is none. What is wrong goes to standard error. */
bool state_open(const char *state, const char *name, sqlite3 **db);
/* Checks every file: pages and indices as SQLite does, and the digest of every request and result.
 * One line for each file, or for each of its first ten faults, where not quiet. False: a fault, or no file. */
bool state_sound(const char *state, bool quiet);
/* Copies all files of one folder into another that is not there yet: checked, on disk, and under
 * its name only when it is whole; until then it is TO.partial. False with the reason on standard error. */
bool state_copy(const char *from, const char *to);

#endif
