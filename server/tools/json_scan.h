/* Finding values in JSON that this program wrote itself (canonical requests, results),
 * without a tree. A slice points into the text. On text that is not JSON the answers
 * are empty slices, never a read past the end. No recursion; linear cost; of a long text what it has gone through rests (spool.h). */
#ifndef SERVER_JSON_SCAN_H
#define SERVER_JSON_SCAN_H

#include <stdbool.h>
#include <stddef.h>

struct slice {
    const char *at;     /* NULL: none */
    size_t len;
};

/* The value that begins at s (white space skipped), up to end: its slice. */
struct slice scan_value(const char *s, const char *end);
/* The value of a member of an object. The key is compared byte by byte. */
struct slice scan_member(struct slice object, const char *key);
/* Walk an array: *cursor starts as NULL; an empty slice ends the walk. */
struct slice scan_next(struct slice array, const char **cursor);
/* The number in a slice; otherwise where it holds none. */
double scan_number(struct slice value, double otherwise);

#endif
