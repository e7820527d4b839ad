/* Whether formulas can become machine code in this process, and so in the children that it starts. */
#ifndef SERVER_CODE_RUNS_H
#define SERVER_CODE_RUNS_H

#include <stdbool.h>

struct sga_exec;

/* By trying: a function of five bytes is made in `memory` (NULL: there is none) and called. False where the processor or the kernel
 * (MemoryDenyWriteExecute, SELinux) does not let it be. */
bool code_runs(struct sga_exec *memory);
/* "compiled", or "interpreted" with the reason in *why, else NULL. Both static. */
const char *code_mode(bool interpret_only, const char **why);

#endif
