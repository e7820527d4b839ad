/* Is there memory for a request that is being read? Where there is none it is refused in words,
 * before an allocation fails in the midst of it. */
#ifndef SERVER_MEMORY_ROOM_H
#define SERVER_MEMORY_ROOM_H

#include <stdbool.h>
#include <stddef.h>

/* For a body of so many bytes. Costs two system calls. */
bool room_for_reading(size_t body);

#endif
