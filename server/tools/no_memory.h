/* The end for want of memory, where there is no other way: what was promised is on disk. */
#ifndef SERVER_NO_MEMORY_H
#define SERVER_NO_MEMORY_H

/* Says what there was no memory for, on standard error, and aborts. */
void no_memory(const char *what) __attribute__((noreturn));

#endif
