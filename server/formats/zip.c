/* A head and the data of each file, then the directory. All dates are the first one that the format has, 1980-01-01. */
#include "zip.h"

#include <string.h>
#include <zlib.h>

#include "little_endian.h"

enum { VERSION = 20, DEFLATED = 8, FIRST_DATE = 0x21 };
static const size_t MOST_BYTES = 0xfffffff0;

/* zlib's own wrapping (two bytes before, four after) is left out: windowBits below 0. */
static bool deflate_all(const struct sga_buf *content, struct sga_buf *out)
{
    z_stream s;
    memset(&s, 0, sizeof s);
    if (deflateInit2(&s, Z_DEFAULT_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return false;
    uLong most = deflateBound(&s, (uLong)content->len);
    s.next_in = (Bytef *)content->data;
    s.avail_in = (uInt)content->len;
    s.next_out = (Bytef *)sga_buf_room(out, most);
    s.avail_out = (uInt)most;
    bool ok = deflate(&s, Z_FINISH) == Z_STREAM_END;
    out->len += s.total_out;
    deflateEnd(&s);
    return ok;
}

/* What the head and the directory both say of a file. */
static void put_facts(struct sga_buf *out, uLong crc, size_t packed, size_t size, size_t name)
{
    little_put(out, VERSION, 2);
    little_put(out, 0, 2);
    little_put(out, DEFLATED, 2);
    little_put(out, 0, 2);
    little_put(out, FIRST_DATE, 2);
    little_put(out, crc, 4);
    little_put(out, packed, 4);
    little_put(out, size, 4);
    little_put(out, name, 2);
    little_put(out, 0, 2);
}

void zip_begin(struct zip *z, struct sga_buf *out)
{
    *z = (struct zip){ .out = out, .start = out->len };
}

bool zip_file(struct zip *z, const char *name, const struct sga_buf *content)
{
    struct sga_buf packed = { 0 };
    size_t at = z->out->len - z->start, letters = strlen(name);
    bool ok = content->len <= MOST_BYTES && deflate_all(content, &packed) && at + packed.len + z->directory.len + 1000 + 2 * letters <= MOST_BYTES;
    if (ok) {
        uLong crc = crc32(0, (const Bytef *)content->data, (uInt)content->len);
        little_put(z->out, 0x04034b50, 4);
        put_facts(z->out, crc, packed.len, content->len, letters);
        sga_buf_put(z->out, name, letters);
        sga_buf_put(z->out, packed.data, packed.len);
        little_put(&z->directory, 0x02014b50, 4);
        little_put(&z->directory, VERSION, 2);
        put_facts(&z->directory, crc, packed.len, content->len, letters);
        little_put(&z->directory, 0, 2 + 2 + 2);      /* no comment, disk 0, binary */
        little_put(&z->directory, 0, 4);
        little_put(&z->directory, at, 4);
        sga_buf_put(&z->directory, name, letters);
        z->files++;
    }
    sga_buf_free(&packed);
    return ok;
}

void zip_end(struct zip *z)
{
    size_t at = z->out->len - z->start;
    sga_buf_put(z->out, z->directory.data, z->directory.len);
    little_put(z->out, 0x06054b50, 4);
    little_put(z->out, 0, 4);
    little_put(z->out, (uint64_t)z->files, 2);
    little_put(z->out, (uint64_t)z->files, 2);
    little_put(z->out, z->directory.len, 4);
    little_put(z->out, at, 4);
    little_put(z->out, 0, 2);
    sga_buf_free(&z->directory);
}
