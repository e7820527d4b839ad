/* Is there memory for what a request may need while it is read? The exact arithmetic below the
 * reader cannot bear a failed allocation: it ends the process. */
#ifndef SERVER_MEMORY_ROOM_H
#define SERVER_MEMORY_ROOM_H

#include <stdbool.h>
#include <stddef.h>

/* For a body of so many bytes, within the bounds of sga_canonical. Costs two system calls. */
bool room_for_reading(size_t body);

#endif
