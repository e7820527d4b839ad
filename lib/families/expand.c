/* Families as the entries that they stand for, by the reader of a request's loops. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "error.h"
#include "family.h"
#include "index.h"
#include "request.h"

static char *copy(struct sga_arena *mem, const char *s, size_t n)
{
    char *text = sga_take(mem, n + 1);
    memcpy(text, s, n);
    text[n] = 0;
    return text;
}

/* The text that `key` is followed by, at *s; behind it and its comma then. */
static char *text_after(const char **s, const char *end, const char *key, struct sga_arena *mem)
{
    size_t n = strlen(key);
    if ((size_t)(end - *s) < n || memcmp(*s, key, n) != 0)
        return NULL;
    const char *from = *s + n, *stop = memchr(from, '"', (size_t)(end - from));
    if (!stop || stop + 1 >= end || stop[1] != ',')
        return NULL;
    *s = stop + 2;
    return copy(mem, from, (size_t)(stop - from));
}

bool folded_read(const char *text, size_t length, struct folded *out, struct sga_arena *mem)
{
    static const char count[] = "\"count\":", lone[] = "\"expression\":";
    const char *s = text, *end = text + length;
    char *behind;
    if (!(out->loop = text_after(&s, end, "{\"for\":\"", mem)) || (size_t)(end - s) < sizeof count || memcmp(s, count, sizeof count - 1) != 0)
        return false;
    out->count = strtol(s + sizeof count - 1, &behind, 10);
    s = behind + (*behind == ',');
    if (behind >= end || out->count < 1 || !(out->place = text_after(&s, end, "\"place\":\"", mem)))
        return false;
    size_t n = sizeof lone - 1;
    bool is_text = (size_t)(end - s) > n && memcmp(s, lone, n) == 0 && family_value_end(s, end) == end - 1;
    if (is_text) {
        out->body = copy(mem, s + n, (size_t)(end - s) - n - 1);
    } else {
        out->body = copy(mem, s - 1, (size_t)(end - s) + 1);
        out->body[0] = '{';
    }
    return true;
}

/* "tangency_of":"constraints[7]" as the number. */
static void as_numbers(struct sga_buf *text)
{
    static const char was[] = "\"tangency_of\":\"constraints[";
    char *s = text->len ? text->data : NULL;
    while (s && (s = strstr(s, was))) {
        char *number = s + sizeof was - 1, *stop = strstr(number, "]\"");
        char *to = s + strlen("\"tangency_of\":");
        if (!stop)
            return;
        size_t n = (size_t)(stop - number), gone = (size_t)(number - to) + 2;
        memmove(to, number, n);
        memmove(to + n, stop + 2, (size_t)(text->data + text->len - (stop + 2)) + 1);
        text->len -= gone;
        s = to;
    }
}

bool folded_each(const struct folded *f, folded_give *give, void *ctx)
{
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
    struct index_scope scope = { .names = 0 };
    struct index_loop loop;
    struct sga_error err = { 0 };
    long place, passes = 0;
    bool numbers = strstr(f->body, "\"tangency_of\":\"") != NULL;
    if (!index_loop_read(&loop, f->loop, &scope, &err))
        return false;
    for (bool more = index_first(&loop, &err); more; more = index_next(&loop, &err)) {
        sga_buf_clear(&text);
        if (++passes > f->count || !index_value(f->place, &scope, &place, &err) || !index_write(f->body, &scope, &text, &err))
            return false;
        if (numbers)
            as_numbers(&text);
        if (!give(ctx, place, &text))
            return false;
    }
    return err.code == SGA_E_OK && passes == f->count;
}

/* "name":value; the length of the name with its quotes, 0: it is no name of a range. */
static size_t range_name(const char *text, size_t length)
{
    const char *quote = length > 2 && *text == '"' ? memchr(text + 1, '"', length - 1) : NULL;
    if (!quote || !memchr(text, '[', (size_t)(quote - text)) || !memchr(text, ':', (size_t)(quote - text)) || quote + 2 >= text + length || quote[1] != ':')
        return 0;
    return (size_t)(quote - text) + 1;
}

bool folded_member_is(const char *text, size_t length)
{
    return range_name(text, length) > 0;
}

bool folded_member_each(const char *text, size_t length, folded_give *give, void *ctx, struct sga_arena *mem)
{
    SGA_ENDS(sga_buf_free) struct sga_buf out = { 0 };
    struct index_scope scope = { .names = 0 };
    struct index_loop loop;
    struct sga_error err = { 0 };
    size_t name = range_name(text, length);
    bool is;
    if (!name)
        return false;
    char *key = copy(mem, text + 1, name - 2), *value = copy(mem, text + name, length - name);
    if (!index_range_read(&loop, key, &scope, &is, &err) || !is)
        return false;
    for (bool more = index_first(&loop, &err); more; more = index_next(&loop, &err)) {
        sga_buf_clear(&out);
        sga_buf_puts(&out, "\"");
        index_put_name(&loop, &out);
        sga_buf_puts(&out, "\"");
        if (!index_write(value, &scope, &out, &err) || !give(ctx, 0, &out))
            return false;
    }
    return err.code == SGA_E_OK;
}

/* Where the entries of a list go. */
struct filled { struct sga_buf *text; struct { size_t at, length; bool has; } *entry; long entries; };

static bool fill(void *ctx, long place, const struct sga_buf *text)
{
    struct filled *f = ctx;
    if (place < 0 || place >= f->entries || f->entry[place].has)
        return false;
    f->entry[place].at = f->text->len;
    f->entry[place].length = text->len;
    f->entry[place].has = true;
    sga_buf_put(f->text, text->data, text->len);
    return true;
}

static bool count_entries(const struct entry *list, int n, struct folded *folded, long *total, struct sga_arena *mem)
{
    *total = 0;
    for (int i = 0; i < n; i++) {
        bool is = folded_read(list[i].text, list[i].length, folded + i, mem);
        if (!is)
            folded[i].count = 0;
        if (folded[i].count > REQUEST_MAX_WRITTEN || (*total += is ? folded[i].count : 1) > REQUEST_MAX_WRITTEN)
            return false;
    }
    return true;
}

/* The list that out is from `start` on, written out. */
static bool expand_list(struct sga_buf *out, size_t start)
{
    SGA_ARENA(mem);
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
    int n;
    long next = 0;
    sga_buf_put(&text, out->data + start, out->len - start);
    const struct entry *list = family_entries(text.data, text.data + text.len, &n, &mem);
    struct folded *folded = sga_zeros(&mem, (size_t)n, sizeof *folded);
    SGA_ENDS(sga_buf_free) struct sga_buf made = { 0 };
    struct filled f = { .text = &made };
    if (!count_entries(list, n, folded, &f.entries, &mem))
        return false;
    f.entry = sga_zeros(&mem, (size_t)f.entries, sizeof *f.entry);
    for (int i = 0; i < n; i++)
        if (folded[i].count && !folded_each(folded + i, fill, &f))
            return false;
    for (int i = 0; i < n; i++) {
        while (next < f.entries && f.entry[next].has)
            next++;
        struct sga_buf own = { .data = (char *)list[i].text, .len = list[i].length };
        if (!folded[i].count && !fill(&f, next, &own))
            return false;
    }
    out->len = start;
    sga_buf_puts(out, "[");
    for (long i = 0; i < f.entries; i++) {
        assert(f.entry[i].has);
        sga_buf_puts(out, i ? "," : "");
        sga_buf_put(out, made.data + f.entry[i].at, f.entry[i].length);
    }
    sga_buf_puts(out, "]");
    return true;
}

struct members { struct sga_buf *out; bool any; };

static bool put_member(void *ctx, long place, const struct sga_buf *text)
{
    struct members *m = ctx;
    (void)place;
    sga_buf_puts(m->out, m->any ? "," : "");
    sga_buf_put(m->out, text->data, text->len);
    m->any = true;
    return true;
}

enum { DEEPEST = 64 };        /* of what sga_json writes */
struct open_list { size_t start; bool folded; };

/* At a quote: the member of a range written out, or the text as it is. *s is then behind it. */
static bool pass_text(const char **s, const char *end, struct sga_buf *out)
{
    const char *from = *s, *p = from + 1;
    while (p < end && *p != '"')
        p += 1 + (*p == '\\');
    p = p < end ? p + 1 : end;
    if (p < end && *p == ':' && memchr(from, '[', (size_t)(p - from)) && memchr(from, ':', (size_t)(p - from))) {
        SGA_ARENA(mem);
        struct members m = { out, false };
        *s = family_value_end(from, end);
        return folded_member_each(from, (size_t)(*s - from), put_member, &m, &mem);
    }
    sga_buf_put(out, from, (size_t)(p - from));
    *s = p;
    return true;
}

bool families_expand(const char *text, size_t length, struct sga_buf *out)
{
    static const char sign[] = "{\"for\":\"";
    struct open_list open[DEEPEST];
    int depth = 0;
    const char *s = text, *end = text + length;
    while (s < end) {
        if (*s == '"') {
            if (!pass_text(&s, end, out))
                return false;
            continue;
        }
        if ((*s == '[' || *s == '{') && depth == DEEPEST)
            return false;
        if (*s == '{' && depth && (size_t)(end - s) >= sizeof sign - 1 && memcmp(s, sign, sizeof sign - 1) == 0)
            open[depth - 1].folded |= out->data[open[depth - 1].start] == '[';
        if (*s == '[' || *s == '{')
            open[depth++] = (struct open_list){ out->len, false };
        sga_buf_put(out, s, 1);
        if ((*s == ']' || *s == '}') && (depth == 0 || (open[--depth].folded && !expand_list(out, open[depth].start))))
            return false;
        s++;
    }
    return depth == 0;
}
