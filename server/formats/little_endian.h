/* Numbers as bytes, the lowest first, on any machine. */
#ifndef SERVER_LITTLE_ENDIAN_H
#define SERVER_LITTLE_ENDIAN_H

#include <stdint.h>
#include <string.h>

#include "buf.h"

static inline void little_put(struct sga_buf *out, uint64_t v, int bytes)
{
    char b[8];
    for (int i = 0; i < bytes; i++, v >>= 8)
        b[i] = (char)(v & 0xff);
    sga_buf_put(out, b, (size_t)bytes);
}

/* n doubles, `step` places apart. */
static inline void little_doubles(struct sga_buf *out, const double *v, size_t n, size_t step)
{
    for (size_t i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, v + i * step, sizeof bits);
        little_put(out, bits, 8);
    }
}

#endif
