/* Members of an answer that a text has no words for. */
#include "rest.h"

#include <stdlib.h>
#include <string.h>

#include "json_string.h"
#include "pretty.h"

/* Objects longer than this may have long lists inside: their members are looked at one by one, to this depth. */
enum { LONG_OBJECT = 3000, DEEPEST = 3 };

static bool is_one_of(struct slice key, const char *const *list)
{
    for (; list && *list; list++)
        if (key.len == strlen(*list) + 2 && memcmp(key.at + 1, *list, key.len - 2) == 0)
            return true;
    return false;
}

static bool is_empty(struct slice value)
{
    return (value.len == 2 && (*value.at == '[' || *value.at == '{')) || (value.len == 4 && *value.at == 'n');
}

/* The first elements of a list that is too long, and how many there are. */
static void put_list(struct sga_buf *out, struct slice list)
{
    const char *cursor = NULL;
    struct sga_buf first = { 0 };
    struct slice e;
    int count = 0;
    for (; (e = scan_next(list, &cursor)).at; count++)
        if (count < REST_ELEMENTS) {
            sga_buf_puts(&first, count ? "," : "[");
            sga_buf_put(&first, e.at, e.len);
        }
    sga_buf_puts(&first, "]");
    pretty_json(count > REST_ELEMENTS ? (struct slice){ first.data, first.len } : list, out);
    if (count > REST_ELEMENTS)
        sga_buf_printf(out, "(%d of %d: --json)\n", REST_ELEMENTS, count);
    sga_buf_free(&first);
}

static void put_member(struct sga_buf *out, const char *before, struct slice key, struct slice value, int depth);

static void put_all(struct sga_buf *out, struct slice object, const char *before, struct rest_names names, int depth)
{
    struct sga_buf left = { 0 };
    const char *s = object.at + 1, *end = object.at + object.len - 1;
    while (object.len > 2 && s < end) {
        struct slice key = scan_value(s, end), value = { NULL, 0 };
        if (key.at)
            value = scan_value(key.at + key.len + 1, end);
        if (!value.at)
            break;
        s = value.at + value.len + 1;
        if (is_one_of(key, names.seldom) && !is_empty(value)) {
            sga_buf_puts(&left, left.len ? ", " : "");
            string_put(&left, key);
        } else if (!is_one_of(key, names.seldom) && !is_one_of(key, names.shown) && !is_empty(value)) {
            put_member(out, before, key, value, depth);
        }
    }
    if (left.len)
        sga_buf_printf(out, "\n(%s%s: --json)\n", before, left.data);
    sga_buf_free(&left);
}

static void put_member(struct sga_buf *out, const char *before, struct slice key, struct slice value, int depth)
{
    struct sga_buf name = { 0 };
    sga_buf_puts(&name, before);
    string_put(&name, key);
    if (*value.at == '{' && value.len > LONG_OBJECT && depth < DEEPEST) {
        sga_buf_puts(&name, ".");
        put_all(out, value, name.data, (struct rest_names){ 0 }, depth + 1);
    } else if (*value.at == '[') {
        sga_buf_printf(out, "\n%s\n", name.data);
        put_list(out, value);
    } else {
        sga_buf_printf(out, "\n%s%s", name.data, *value.at == '{' ? "\n" : ": ");
        if (*value.at == '{')
            pretty_json(value, out);
        else
            string_put(out, value), sga_buf_puts(out, "\n");
    }
    sga_buf_free(&name);
}

void rest_put(struct sga_buf *out, struct slice object, const char *before, struct rest_names names)
{
    if (object.at && *object.at == '{')
        put_all(out, object, before, names, 0);
}
