/* The request as the key of the cache sees it: compact, sorted, numbers in one spelling.
 * The recursion is as deep as the JSON, which load_json has bounded. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "reader.h"

static int by_key(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static void write_text(struct sga_buf *out, const char *s)
{
    struct sga_json w;
    sga_json_begin(&w, out);
    sga_json_string(&w, s);
}

static void write_value(struct sga_buf *out, const json_t *v, bool sorted);

static void write_object(struct sga_buf *out, const json_t *v, bool sorted)
{
    size_t n = 0;
    SGA_FREED const char **key = sga_malloc((json_object_size(v) + 1) * sizeof *key);
    for (void *i = json_object_iter((json_t *)v); i; i = json_object_iter_next((json_t *)v, i))
        key[n++] = json_object_iter_key(i);
    if (sorted)
        qsort(key, n, sizeof *key, by_key);
    sga_buf_put(out, "{", 1);
    for (size_t i = 0; i < n; i++) {
        if (i)
            sga_buf_put(out, ",", 1);
        write_text(out, key[i]);
        sga_buf_put(out, ":", 1);
        write_value(out, json_object_get(v, key[i]), sorted);
    }
    sga_buf_put(out, "}", 1);
}

static void write_value(struct sga_buf *out, const json_t *v, bool sorted)
{
    char number[40];
    switch (json_typeof(v)) {
    case JSON_OBJECT:
        write_object(out, v, sorted);
        return;
    case JSON_ARRAY:
        sga_buf_put(out, "[", 1);
        for (size_t i = 0; i < json_array_size(v); i++) {
            if (i)
                sga_buf_put(out, ",", 1);
            write_value(out, json_array_get(v, i), sorted);
        }
        sga_buf_put(out, "]", 1);
        return;
    case JSON_STRING:
        write_text(out, json_string_value(v));
        return;
    case JSON_INTEGER:
        sga_buf_printf(out, "%lld", (long long)json_integer_value(v));
        return;
    case JSON_REAL:
        sga_format_double(number, json_real_value(v) + 0.0);     /* -0.0 is the number 0 */
        sga_buf_puts(out, number);
        return;
    case JSON_TRUE:
    case JSON_FALSE:
        sga_buf_puts(out, json_is_true(v) ? "true" : "false");
        return;
    default:
        sga_buf_puts(out, "null");
    }
}

void write_json(struct sga_buf *out, const json_t *v)
{
    write_value(out, v, false);
}

bool request_canonical(const char *text, size_t length, struct sga_buf *out, struct sga_error *err)
{
    json_t *v = load_json(text, length, err);
    if (!v)
        return false;
    write_value(out, v, true);
    json_decref(v);
    return true;
}
