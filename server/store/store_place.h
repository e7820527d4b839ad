/* Where the queue's file lies: is it still there, under its name? A folder that was deleted,
 * unmounted or put elsewhere takes every write and loses it. */
#ifndef SERVER_STORE_PLACE_H
#define SERVER_STORE_PLACE_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

struct store_place {
    dev_t device;
    ino_t inode;
};

/* Of FOLDER/queue.db. False: there is none. One system call; any thread. */
bool store_place_of(const char *folder, struct store_place *place);
/* Bytes that can still be written there; 0 where that cannot be told. */
unsigned long long store_place_free(const char *folder);
/* Bytes that should stay free there, so that the queue can always be written: an eighth of the disk, 64 MiB at the most. */
unsigned long long store_place_spare(const char *folder);
/* Of a file of the folder alone, and with its log (-wal); 0 where there is none. */
unsigned long long store_place_size(const char *folder, const char *name);
unsigned long long store_place_bytes(const char *folder, const char *name);
bool store_place_same(const struct store_place *a, const struct store_place *b);

/* A state folder that was in use has the file `instance`, written once, with a random name that
 * tells one service's state from another's. Before the queue is opened: false with the reason
 * where the folder has it (or results), and the queue's file is missing or empty. */
bool store_place_sound(const char *folder, char *why, size_t size);
/* Makes it where it is missing, on disk when this returns. */
bool store_place_mark(const char *folder, char *why, size_t size);

#endif
