/* The watch over one job's memory and time, from inside the allocators.
 *
 * Long loops ask their budget (budget.h), or here where they have none, and end with an error. A library call such as one
 * factorisation in FLINT asks nobody, and can neither fail nor be left; but it allocates.
 * So every allocation of ours, of FLINT and of GMP passes here. Past a limit the budget
 * turns bad, which ends the job wherever it is asked next; where that does not come, the
 * wall is called some way past the limit: it says what happened and ends the process.
 *
 * What is measured is the private writable memory of the process (what RLIMIT_DATA counts)
 * since the watch began, so free memory kept from an earlier job is nobody's fault.
 * The watch belongs to the thread that began it: GMP's and FLINT's hooks carry no context.
 * This is the one place in lib/ that keeps such a state. */
#ifndef SGA_BASE_WATCH_H
#define SGA_BASE_WATCH_H

#include <stdbool.h>
#include <stddef.h>

struct sga_budget;
struct sga_error;

/* The last words of a process: it must not return. */
typedef void sga_wall(void *ctx, const struct sga_error *err);

/* Once in a process, before the first watch: measuring. */
void sga_watch_init(void);
/* The allocators of GMP and FLINT become ours: before they have allocated anything. */
void sga_watch_hook(void);

/* budget is borrowed until sga_watch_end. wall may be NULL: then the process aborts where
 * memory ends, as it does without a watch. */
void sga_watch_begin(const struct sga_budget *budget, sga_wall *wall, void *ctx);
void sga_watch_end(void);

/* Bytes that the process has grown by since the watch of this thread began; 0 without one. */
size_t sga_watch_used(void);
/* False: past budget->max_memory, and err is filled (LIMIT_MEMORY). Costs nothing. */
bool sga_watch_memory_ok(struct sga_error *err);

/* For loops far below those who were given the budget: false where the budget of this thread's watch is used up, be it
 * seconds, memory or a cancellation; true without a watch. They give up, as if what they try had failed; who
 * gives a reason for a failure asks his budget first (sga_budget_ok). A look at the clock, some 50 ns. */
bool sga_watch_ok(void);

/* What a job has worked, whatever machine it ran on: counted for the thread since its watch began (0 without one), so that a
 * regression of the amount of work is seen without a clock. Told before the work, some thousands at a time where it is much: the
 * wall stands here too, as loops over what is large ask nobody else. */
enum sga_counter {
    SGA_COUNT_BALLS,       /* nodes evaluated or differentiated in balls */
    SGA_COUNT_MODULAR,     /* nodes evaluated modulo a prime */
    SGA_COUNT_TERMS,       /* terms of polynomials that were multiplied out */
    SGA_COUNTERS
};
void sga_watch_count(enum sga_counter what, long more);
long sga_watch_counted(enum sga_counter what);

/* For allocators: `size` bytes are about to be asked for; `size` bytes could not be had
 * (does not return). */
void sga_watch_ask(size_t size);
void sga_watch_failed(size_t size) __attribute__((noreturn));
/* NULL was given to a library that can bear it: noted for this thread, watch or not. */
void sga_watch_refuse(void);
/* Was it, since this was asked last? */
bool sga_watch_refused(void);

#endif
