/* Growable text and the JSON writer on top of it. */
#include "buf.h"
#include "mem.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void sga_buf_free(struct sga_buf *b)
{
    free(b->data);
    *b = (struct sga_buf){ 0 };
}

void sga_buf_clear(struct sga_buf *b)
{
    b->len = 0;
    if (b->data)
        b->data[0] = 0;
}

void sga_buf_put(struct sga_buf *b, const char *s, size_t n)
{
    SGA_RESERVE(b->data, b->cap, b->len + n + 1);
    if (n)
        memcpy(b->data + b->len, s, n);
    b->len += n;
    b->data[b->len] = 0;
}

char *sga_buf_room(struct sga_buf *b, size_t n)
{
    SGA_RESERVE(b->data, b->cap, b->len + n + 1);
    return b->data + b->len;
}

void sga_buf_puts(struct sga_buf *b, const char *s)
{
    sga_buf_put(b, s, strlen(s));
}

void sga_buf_printf(struct sga_buf *b, const char *fmt, ...)
{
    va_list ap, again;
    va_start(ap, fmt);
    va_copy(again, ap);
    char small[256];
    int n = vsnprintf(small, sizeof small, fmt, ap);
    va_end(ap);
    assert(n >= 0);
    if ((size_t)n < sizeof small) {
        sga_buf_put(b, small, (size_t)n);
    } else {
        SGA_RESERVE(b->data, b->cap, b->len + (size_t)n + 1);
        vsnprintf(b->data + b->len, (size_t)n + 1, fmt, again);
        b->len += (size_t)n;
    }
    va_end(again);
}

char *sga_buf_take(struct sga_buf *b)
{
    if (!b->data)
        sga_buf_put(b, "", 0);
    char *s = b->data;
    *b = (struct sga_buf){ 0 };
    return s;
}

void sga_json_begin(struct sga_json *w, struct sga_buf *out)
{
    *w = (struct sga_json){ .out = out };
    w->first[0] = true;
}

static void separate(struct sga_json *w)
{
    if (w->after_key)
        w->after_key = false;
    else if (w->first[w->depth])
        w->first[w->depth] = false;
    else
        sga_buf_put(w->out, ",", 1);
}

static void open(struct sga_json *w, const char *bracket)
{
    separate(w);
    sga_buf_put(w->out, bracket, 1);
    assert(w->depth + 1 < 64);
    w->first[++w->depth] = true;
}

static void close(struct sga_json *w, const char *bracket)
{
    assert(w->depth > 0);
    w->depth--;
    sga_buf_put(w->out, bracket, 1);
}

void sga_json_object(struct sga_json *w) { open(w, "{"); }
void sga_json_end_object(struct sga_json *w) { close(w, "}"); }
void sga_json_array(struct sga_json *w) { open(w, "["); }
void sga_json_end_array(struct sga_json *w) { close(w, "]"); }

static void quote(struct sga_buf *out, const char *s)
{
    sga_buf_put(out, "\"", 1);
    const char *run = s;
    for (; *s; s++) {
        unsigned char c = (unsigned char)*s;
        if (c >= 0x20 && c != '"' && c != '\\')
            continue;
        sga_buf_put(out, run, (size_t)(s - run));
        run = s + 1;
        if (c == '"' || c == '\\')
            sga_buf_printf(out, "\\%c", c);
        else if (c == '\n')
            sga_buf_put(out, "\\n", 2);
        else
            sga_buf_printf(out, "\\u%04x", c);
    }
    sga_buf_put(out, run, (size_t)(s - run));
    sga_buf_put(out, "\"", 1);
}

void sga_json_key(struct sga_json *w, const char *key)
{
    separate(w);
    quote(w->out, key);
    sga_buf_put(w->out, ":", 1);
    w->after_key = true;
}

void sga_json_string(struct sga_json *w, const char *s)
{
    separate(w);
    quote(w->out, s);
}

void sga_json_int(struct sga_json *w, long long v)
{
    separate(w);
    sga_buf_printf(w->out, "%lld", v);
}

void sga_json_double(struct sga_json *w, double v)
{
    separate(w);
    char *at = sga_buf_room(w->out, 32);
    w->out->len += (size_t)sga_format_double(at, v);
}

void sga_json_bool(struct sga_json *w, bool v)
{
    separate(w);
    sga_buf_puts(w->out, v ? "true" : "false");
}

void sga_json_null(struct sga_json *w)
{
    separate(w);
    sga_buf_put(w->out, "null", 4);
}

void sga_json_raw(struct sga_json *w, const char *text, size_t n)
{
    separate(w);
    sga_buf_put(w->out, text, n);
}

void sga_json_member_string(struct sga_json *w, const char *key, const char *v)
{
    sga_json_key(w, key);
    sga_json_string(w, v);
}

void sga_json_member_int(struct sga_json *w, const char *key, long long v)
{
    sga_json_key(w, key);
    sga_json_int(w, v);
}

void sga_json_member_double(struct sga_json *w, const char *key, double v)
{
    sga_json_key(w, key);
    sga_json_double(w, v);
}

void sga_json_member_bool(struct sga_json *w, const char *key, bool v)
{
    sga_json_key(w, key);
    sga_json_bool(w, v);
}
