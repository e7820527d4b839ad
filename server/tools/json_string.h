/* JSON strings as text. */
#ifndef SERVER_JSON_STRING_H
#define SERVER_JSON_STRING_H

struct sga_buf;
struct slice;

/* Appends what a JSON string says; any other value as it stands. */
void string_put(struct sga_buf *out, struct slice value);
/* The same as a new string that the caller frees. */
char *string_take(struct slice value);

#endif
