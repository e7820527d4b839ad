/* The work is zlib's, and the response of the kind whose length is not known. */
#include "packed.h"
#include "spool.h"

#include <assert.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* 32 KiB of window would need 256 KiB: numbers repeat little over such distances. Level 3 packs JSON of numbers to the half of its
 * bytes that 6 reaches too, in a third of the time. */
enum { LEVEL = 3, WINDOW_BITS = 13, MEM_LEVEL = 7, GZIP = 16, PIECE = 65536, INPUT = 16384, BLOCK = 32768, PIECES = 3, SENT = 32 << 10 };

struct packer {
    z_stream z;
    struct packed_source source;
    uint64_t at;
    bool last, done;
    char in[INPUT];
};

struct pieces {
    struct MHD_IoVec part[PIECES];
    int count, now;
    size_t at;
    MHD_ContentReaderFreeCallback release;
    void *cls;
};

static atomic_int packers;

bool packed_room(void)
{
    return atomic_load(&packers) < PACKED_MOST;
}

static void close_packer(void *cls)
{
    struct packer *p = cls;
    deflateEnd(&p->z);
    if (p->source.release)
        p->source.release(p->source.cls);
    free(p);
    int before = atomic_fetch_sub(&packers, 1);
    assert(before > 0);
}

/* More of the source; false where it broke off. */
static bool fill(struct packer *p)
{
    assert(!p->last && !p->z.avail_in);
    ssize_t n = p->source.read(p->source.cls, p->at, p->in, sizeof p->in);
    if (n == MHD_CONTENT_READER_END_WITH_ERROR)
        return false;
    p->last = n == MHD_CONTENT_READER_END_OF_STREAM;
    p->z.next_in = (unsigned char *)p->in;
    p->z.avail_in = n > 0 ? (unsigned)n : 0;
    assert(p->z.avail_in <= sizeof p->in);
    p->at += p->z.avail_in;
    return true;
}

/* 0, where nothing has come out of a piece yet: the library calls again after others had their turn. */
static ssize_t read_packed(void *cls, uint64_t at, char *buf, size_t max)
{
    struct packer *p = cls;
    uint64_t begun = p->at;
    (void)at;
    if (p->done)
        return MHD_CONTENT_READER_END_OF_STREAM;
    p->z.next_out = (unsigned char *)buf;
    p->z.avail_out = (unsigned)(max < BLOCK ? max : BLOCK);
    unsigned room = p->z.avail_out;
    while (p->z.avail_out && !p->done && p->at - begun < PIECE) {
        if (!p->z.avail_in && !p->last && !fill(p))
            return MHD_CONTENT_READER_END_WITH_ERROR;
        int rc = deflate(&p->z, p->last ? Z_FINISH : Z_NO_FLUSH);
        if (rc != Z_OK && rc != Z_BUF_ERROR && rc != Z_STREAM_END)
            return MHD_CONTENT_READER_END_WITH_ERROR;
        p->done = rc == Z_STREAM_END;
    }
    return (ssize_t)(room - p->z.avail_out);
}

struct MHD_Response *packed_response(struct packed_source source)
{
    struct packer *p = calloc(1, sizeof *p);
    if (!p || deflateInit2(&p->z, LEVEL, Z_DEFLATED, WINDOW_BITS + GZIP, MEM_LEVEL, Z_DEFAULT_STRATEGY) != Z_OK) {
        free(p);
        if (source.release)
            source.release(source.cls);
        return NULL;
    }
    atomic_fetch_add(&packers, 1);
    p->source = source;
    struct MHD_Response *r = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, BLOCK, read_packed, p, close_packer);
    if (!r)
        close_packer(p);
    return r;
}

static ssize_t read_pieces(void *cls, uint64_t at, char *buf, size_t max)
{
    struct pieces *p = cls;
    (void)at;
    while (p->now < p->count && p->at == p->part[p->now].iov_len) {
        p->now++;
        p->at = 0;
    }
    if (p->now == p->count)
        return MHD_CONTENT_READER_END_OF_STREAM;
    const char *from = p->part[p->now].iov_base;
    size_t left = p->part[p->now].iov_len - p->at, n = left < max ? left : max, step = p->at / SPOOL_STEP;
    memcpy(buf, from + p->at, n);
    p->at += n;
    if (p->at / SPOOL_STEP > step)
        spool_rest(from + step * SPOOL_STEP, p->at - step * SPOOL_STEP);
    return (ssize_t)n;
}

static void free_pieces(void *cls)
{
    struct pieces *p = cls;
    if (p->release)
        p->release(p->cls);
    free(p);
}

/* NULL when memory ends: then what they are of has been released. */
static struct pieces *hold(const struct MHD_IoVec *part, int count, MHD_ContentReaderFreeCallback release, void *cls)
{
    struct pieces *p = count <= PIECES ? calloc(1, sizeof *p) : NULL;
    if (!p) {
        if (release)
            release(cls);
        return NULL;
    }
    memcpy(p->part, part, (size_t)count * sizeof *part);
    p->count = count;
    p->release = release;
    p->cls = cls;
    return p;
}

struct MHD_Response *packed_pieces(const struct MHD_IoVec *part, int count, MHD_ContentReaderFreeCallback release, void *cls)
{
    struct pieces *p = hold(part, count, release, cls);
    return p ? packed_response((struct packed_source){ read_pieces, free_pieces, p }) : NULL;
}

struct MHD_Response *plain_pieces(const struct MHD_IoVec *part, int count, MHD_ContentReaderFreeCallback release, void *cls)
{
    struct pieces *p = hold(part, count, release, cls);
    uint64_t length = 0;
    for (int i = 0; i < count; i++)
        length += part[i].iov_len;
    struct MHD_Response *r = p ? MHD_create_response_from_callback(length, SENT, read_pieces, p, free_pieces) : NULL;
    if (p && !r)
        free_pieces(p);
    return r;
}
