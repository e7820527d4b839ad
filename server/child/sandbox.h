/* What a child process may do once it runs requests: compute, and talk on the one socket
 * that it was given. A request that took over the child (a fault in a library) could not
 * open a file, reach the network, start a program or touch another process. */
#ifndef SERVER_SANDBOX_H
#define SERVER_SANDBOX_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#define SANDBOX_FLAG "--check-sandbox"

struct sandbox {
    pid_t parent;        /* dies with this one */
    size_t memory;       /* address space in bytes; 0: no limit */
    int descriptors;     /* of them may be open, from 0 */
    /* Pages of this range may be made executable one by one, while they are not writable, and no
     * others: base is a multiple of code_bytes, a power of two. 0 bytes: none. */
    void *code;
    size_t code_bytes;
};

/* Enters for good; the caller has closed what the child shall not have. False with the reason where the kernel refuses a part that it must have;
 * Landlock alone may be missing (older kernels). */
bool sandbox_enter(const struct sandbox *s, char *why, size_t size);

/* `sgad --check-sandbox`: enters, tries what must not work, says what did. 0: nothing did. */
int sandbox_check(void);

#endif
