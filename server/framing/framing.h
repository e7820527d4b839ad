/* Where the messages of a connection begin and end, by RFC 9112 to the letter: a state machine over the bytes as they come,
 * before the HTTP library sees them. It has no opinion on what is asked, only on what is ambiguous, and on sizes.
 *
 * Beyond that it takes out what is allowed and means nothing here, in place, so that no other reader can take it otherwise:
 * an empty line before a request, extensions of chunks, trailers. */
#ifndef SERVER_FRAMING_H
#define SERVER_FRAMING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct sga_error;

/* What the HTTP library holds in the memory that it has for each connection (32 KiB), with its lists. */
enum {
    FRAMING_HEAD = 16384,        /* bytes of a request line and its fields */
    FRAMING_TARGET = 8000,       /* of a target: what RFC 9112 asks for at the least */
    FRAMING_FIELDS = 100,
    FRAMING_PARAMETERS = 100,    /* of a query */
    FRAMING_COOKIES = 100,       /* nobody reads them, but the library makes a list of them */
    FRAMING_EXTRAS = 8192,       /* bytes of extensions and trailers of one message */
};

struct framing {
    unsigned char state;
    bool head_request, connect, http10;      /* of the request line */
    unsigned char kind;                      /* of the field that is read */
    bool host, length_given, coding_given;
    unsigned char name_at, value_at;
    char name[20], value[20];                /* first characters, in lower case */
    unsigned head, target, fields, parameters, cookies, extras;
    unsigned char digits;
    char percent;
    uint64_t left;                           /* bytes of a body or a chunk that are to come */
    unsigned long heads;                     /* heads that were complete, since the beginning */
};

void framing_init(struct framing *f);
/* Reads the n bytes that came. Those that may be handed on are left at the beginning of bytes, *kept of them. False where a
 * byte is refused, with err filled: *kept are then those before it, and nothing can be read any more. Cost: about 2 ns a
 * byte of heads and of chunks' heads, nothing for those of bodies. */
bool framing_take(struct framing *f, char *bytes, size_t n, size_t *kept, struct sga_error *err);
/* Has the request been begun and its head not ended, or is none on its way? Else its body is. */
bool framing_in_head(const struct framing *f);

#endif
