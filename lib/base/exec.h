/* Memory for machine code that is made at run time.
 *
 * Pages are written first, and made executable (and read-only) afterwards: none is ever
 * both. A process that may not make memory executable (systemd's MemoryDenyWriteExecute,
 * a seccomp filter, SELinux) gets NULL from sga_exec_add, and interprets instead. All of
 * it lies in one range, so that a filter can allow that range and nothing else. */
#ifndef SGA_BASE_EXEC_H
#define SGA_BASE_EXEC_H

#include <stdbool.h>
#include <stddef.h>

struct sga_exec;

/* Address space for so many bytes of code, at least (the next power of two); pages cost memory
 * once they are used. NULL where there is none, or the processor is not one that code is
 * made for. */
struct sga_exec *sga_exec_new(size_t bytes);
void sga_exec_free(struct sga_exec *m);     /* NULL is allowed; nothing of it may run any more */

/* The range: code begins at multiples of the page size from `base` on, within `bytes`; base is
 * a multiple of bytes, a power of two. Each page is made executable by a call of its own. */
void sga_exec_range(const struct sga_exec *m, void **base, size_t *bytes);

/* A copy of code[0 .. bytes) that can be called, or NULL: no room, or it may not be. Costs
 * whole pages, and a system call for each and one more; nothing of it where the same bytes were added before and their room was not
 * wanted since (the motions of a sweep make the same code again and again). */
const void *sga_exec_add(struct sga_exec *m, const void *code, size_t bytes);
/* By what code is made from, which saves making it: a key of any bytes that decides about all bytes of the code. sga_exec_name gives one to what
 * was added (the first that it gets stays); sga_exec_known finds it, as sga_exec_add does where the code is there, or NULL. */
void sga_exec_name(struct sga_exec *m, const void *at, const void *key, size_t bytes);
const void *sga_exec_known(struct sga_exec *m, const void *key, size_t bytes);
/* Most of what was added was there: code costs no system calls as a rule, as in a sweep, and pays at once. */
bool sga_exec_repeats(const struct sga_exec *m);
/* Once for each that was added: its pages may be used again. */
void sga_exec_drop(struct sga_exec *m, const void *at);

#endif
