/* Texts of any length. A short one is in memory; a long one in a file without a name, in the folder that was told, and mapped: its pages
 * are the system's to take and bring back, and who goes through one says what it is done with, so that of a text of a gigabyte there are
 * some megabytes in the process. Where no file can be made (no folder, no room on its disk) a long text is in memory too. Thread-safe. */
#ifndef SERVER_SPOOL_H
#define SERVER_SPOOL_H

#include <stdbool.h>
#include <stddef.h>

enum {
    SPOOL_HEAD = 1024,           /* bytes before a text that its owner may write, too */
    SPOOL_LONG = 1 << 20,        /* bytes from which on a text is in a file */
    SPOOL_STEP = 1 << 20         /* whoever goes through a text rests each so many bytes behind him */
};

/* Where files are made from now on; NULL: nowhere. Copied. Before other threads are there. */
void spool_folder(const char *folder);

/* Room for a text of so many bytes and a 0 behind it; what it holds is not defined. NULL when memory ends. */
char *spool_new(size_t length);
/* The same text with room for another length, the shorter of both of it kept. NULL when memory ends: then it is as it was. */
char *spool_resize(char *text, size_t length);
void spool_free(char *text);     /* NULL is allowed */
/* It will not grow any more: a file needs no descriptor from now on. One that grows all the same is copied. */
void spool_settle(char *text);

/* These bytes, of a text or of anything else, will not be read soon: those of files leave the process, until they are. Others may read
 * them meanwhile. */
void spool_rest(const void *at, size_t length);

#endif
