/* MAT-file level 5: a head of 128 bytes, then data elements: a tag of type and length, data, zeros up to a multiple of 8. An array is an element
 * of elements. The MathWorks, MAT-File Format, "Level 5 MAT-File Format". */
#include "samples_files.h"

#include <stdio.h>
#include <string.h>

#include "little_endian.h"

enum { MI_INT8 = 1, MI_INT32 = 5, MI_UINT32 = 6, MI_DOUBLE = 9, MI_MATRIX = 14, MI_UTF8 = 16 };
enum { MX_CELL = 1, MX_CHAR = 4, MX_DOUBLE = 6 };
static const size_t MOST_BYTES = 0x7fffffff;          /* of an array, as readers count them */

static size_t padded(size_t n)
{
    return (n + 7) / 8 * 8;
}

static void put_bytes(struct sga_buf *out, int type, const char *text, size_t n)
{
    little_put(out, (uint64_t)type, 4);
    little_put(out, n, 4);
    sga_buf_put(out, text, n);
    for (; n % 8; n++)
        sga_buf_put(out, "", 1);
}

/* Tag, flags, dimensions, name. `data`: bytes of what follows. */
static void put_array(struct sga_buf *out, int kind, size_t rows, size_t columns, const char *name, size_t data)
{
    little_put(out, MI_MATRIX, 4);
    little_put(out, 16 + 16 + 8 + padded(strlen(name)) + data, 4);
    little_put(out, MI_UINT32, 4);
    little_put(out, 8, 4);
    little_put(out, (uint64_t)kind, 8);
    little_put(out, MI_INT32, 4);
    little_put(out, 8, 4);
    little_put(out, rows, 4);
    little_put(out, columns, 4);
    put_bytes(out, MI_INT8, name, strlen(name));
}

/* Characters, not bytes. */
static size_t letters(const char *text)
{
    size_t n = 0;
    for (; *text; text++)
        n += ((unsigned char)*text & 0xc0) != 0x80;
    return n;
}

static size_t name_bytes(const char *text)
{
    return 8 + 16 + 16 + 8 + 8 + padded(strlen(text));
}

static void put_columns(const struct samples *s, size_t bytes, struct sga_buf *out)
{
    put_array(out, MX_CELL, 1, (size_t)s->columns, "columns", bytes);
    for (int i = 0; i < s->columns; i++) {
        put_array(out, MX_CHAR, 1, letters(s->column[i]), "", 8 + padded(strlen(s->column[i])));
        put_bytes(out, MI_UTF8, s->column[i], strlen(s->column[i]));
    }
}

static void put_rows(const struct samples *s, size_t bytes, struct sga_buf *out)
{
    put_array(out, MX_DOUBLE, s->rows, (size_t)s->columns, "rows", 8 + bytes);
    little_put(out, MI_DOUBLE, 4);
    little_put(out, bytes, 4);
    for (int i = 0; i < s->columns; i++)
        little_doubles(out, s->value + i, s->rows, (size_t)s->columns);
}

bool samples_mat(const struct samples *s, struct sga_buf *out)
{
    size_t names = 0, values = s->rows * (size_t)s->columns * sizeof(double);
    for (int i = 0; i < s->columns; i++)
        names += name_bytes(s->column[i]);
    if (names + 64 > MOST_BYTES || values + 64 > MOST_BYTES)
        return false;
    char head[125];
    snprintf(head, sizeof head, "%-116s", "MATLAB 5.0 MAT-file, written by sgad");
    memset(head + 116, 0, 8);
    sga_buf_put(out, head, 124);
    sga_buf_put(out, "\0\1IM", 4);
    put_columns(s, names, out);
    put_rows(s, values, out);
    return true;
}
