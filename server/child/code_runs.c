#include "code_runs.h"

#include <stdint.h>
#include <stddef.h>

#include "exec.h"

bool code_runs(struct sga_exec *memory)
{
    static const unsigned char twice[] = { 0xF2, 0x0F, 0x58, 0xC0, 0xC3 };      /* addsd xmm0, xmm0; ret */
    const void *at = memory ? sga_exec_add(memory, twice, sizeof twice) : NULL;
    return at && ((double (*)(double))(uintptr_t)at)(21) == 42;
}

const char *code_mode(bool interpret_only, const char **why)
{
    *why = interpret_only ? "the setting interpret-only" : NULL;
    if (interpret_only)
        return "interpreted";
    struct sga_exec *memory = sga_exec_new(1 << 16);
    bool runs = code_runs(memory);
    if (!runs)
        *why = memory ? "memory may not be made executable here (MemoryDenyWriteExecute= of a unit, SELinux)" : "no machine code is made for this processor";
    sga_exec_free(memory);
    return runs ? "compiled" : "interpreted";
}
