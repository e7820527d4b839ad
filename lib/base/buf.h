/* A growable byte string, and JSON written into it without a tree. */
#ifndef SGA_BASE_BUF_H
#define SGA_BASE_BUF_H

#include <stdbool.h>
#include <stddef.h>

struct sga_buf {
    char *data;    /* always 0-terminated once something was written; NULL before */
    size_t len, cap;
};

void sga_buf_free(struct sga_buf *b);                 /* releases, leaves it empty */
void sga_buf_clear(struct sga_buf *b);                /* keeps the memory */
void sga_buf_put(struct sga_buf *b, const char *s, size_t n);
void sga_buf_puts(struct sga_buf *b, const char *s);
/* Room for n more bytes, and the 0 behind them, at the end of the text: the caller fills it from
 * there on and adds to len. */
char *sga_buf_room(struct sga_buf *b, size_t n);
void sga_buf_printf(struct sga_buf *b, const char *fmt, ...) __attribute__((format(printf, 2, 3)));
/* The text as a string that the caller frees; the buffer is left empty. Never NULL. */
char *sga_buf_take(struct sga_buf *b);

/* Shortest decimal that reads back as the same double, into out[32]; returns its
 * length. Infinities and NaN have no JSON form: they are written as null. */
int sga_format_double(char *out, double v);

/* A JSON writer: commas and colons are its business. Depth is at most 64. */
struct sga_json {
    struct sga_buf *out;
    int depth;
    bool first[64];
    bool after_key;
};
void sga_json_begin(struct sga_json *w, struct sga_buf *out);
void sga_json_object(struct sga_json *w);             /* { */
void sga_json_end_object(struct sga_json *w);         /* } */
void sga_json_array(struct sga_json *w);              /* [ */
void sga_json_end_array(struct sga_json *w);          /* ] */
void sga_json_key(struct sga_json *w, const char *key);
void sga_json_string(struct sga_json *w, const char *s);
void sga_json_int(struct sga_json *w, long long v);
void sga_json_double(struct sga_json *w, double v);   /* null where it is not finite */
void sga_json_bool(struct sga_json *w, bool v);
void sga_json_null(struct sga_json *w);
/* A key and its value. */
void sga_json_member_string(struct sga_json *w, const char *key, const char *s);
void sga_json_member_int(struct sga_json *w, const char *key, long long v);
void sga_json_member_double(struct sga_json *w, const char *key, double v);
void sga_json_member_bool(struct sga_json *w, const char *key, bool v);
void sga_json_raw(struct sga_json *w, const char *text, size_t n);  /* finished JSON */

#endif
