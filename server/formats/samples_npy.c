/* NumPy's format: magic, version, a header that is a literal of Python, the values. https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html */
#include "samples_files.h"

#include <string.h>

#include "little_endian.h"

/* A text as Python's literal. */
static void put_literal(struct sga_buf *out, const char *text)
{
    sga_buf_puts(out, "\"");
    for (; *text; text++) {
        if ((unsigned char)*text < 0x20)
            sga_buf_printf(out, "\\x%02x", *text);
        else
            sga_buf_printf(out, *text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    }
    sga_buf_puts(out, "\"");
}

static void put_description(const struct samples *s, struct sga_buf *out)
{
    sga_buf_puts(out, "{'descr': [");
    for (int i = 0; i < s->columns; i++) {
        sga_buf_puts(out, i ? ", (" : "(");
        put_literal(out, s->column[i]);
        sga_buf_puts(out, ", '<f8')");
    }
    sga_buf_printf(out, "], 'fortran_order': False, 'shape': (%zu,), }", s->rows);
}

static bool plain(const struct sga_buf *text)
{
    for (size_t i = 0; i < text->len; i++)
        if ((unsigned char)text->data[i] >= 0x80)
            return false;
    return true;
}

/* Version 1 has two bytes for the length, 2 has four, 3 is UTF-8 too. The values begin at a multiple of 64. */
void samples_npy_head(const struct samples *s, struct sga_buf *out)
{
    struct sga_buf head = { 0 };
    put_description(s, &head);
    char version = !plain(&head) ? 3 : head.len + 64 > 65535 ? 2 : 1;
    size_t before = version == 1 ? 10 : 12;
    while ((before + head.len + 1) % 64)
        sga_buf_puts(&head, " ");
    sga_buf_puts(&head, "\n");
    sga_buf_put(out, "\x93NUMPY", 6);
    sga_buf_put(out, (char[]){ version, 0 }, 2);
    little_put(out, head.len, version == 1 ? 2 : 4);
    sga_buf_put(out, head.data, head.len);
    sga_buf_free(&head);
}

void samples_npy(const struct samples *s, struct sga_buf *out)
{
    samples_npy_head(s, out);
    little_doubles(out, s->value, s->rows * (size_t)s->columns, 1);
}
