/* The two database files: opening, schema, and statements. Internal to the store. */
#ifndef SERVER_STORE_FILE_H
#define SERVER_STORE_FILE_H

#include <sqlite3.h>
#include <stdbool.h>
#include <stddef.h>

enum store_file { FILE_QUEUE, FILE_CACHE };

/* Opens the file in a folder: read-write with its schema made or checked, or read-only.
 * NULL with a reason in why. */
sqlite3 *store_file_open(const char *folder, enum store_file which, bool write, char *why, size_t size);
/* Deletes the file and opens it empty. */
sqlite3 *store_file_fresh(const char *folder, enum store_file which, char *why, size_t size);
/* Its user_version; -1 where that cannot be read. */
int store_file_version(sqlite3 *db);
/* Writes so many bytes that mean nothing, in place of those before; 0 takes them away. */
bool store_file_fill(sqlite3 *db, size_t bytes);
/* Does this result code say that the file itself is broken? */
bool store_file_broken(int code);
/* Takes a lock on the folder, making it if it is missing, and waits so many seconds for who has it; a descriptor or -1. */
int store_file_lock(const char *folder, double wait, char *why, size_t size);
/* Prepares a statement that lives as long as its connection. */
sqlite3_stmt *store_file_prepare(sqlite3 *db, const char *sql, char *why, size_t size);

#endif
