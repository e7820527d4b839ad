/* Places of what was written out: back to the request as it was sent. */
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "lex.h"
#include "reader.h"
#include "written_piece.h"

/* What follows the pointer of the list: a / and more, or NULL. */
static const char *below(const char *pointer, const char *list)
{
    size_t n = strlen(list);
    return strncmp(pointer, list, n) == 0 && pointer[n] == '/' ? pointer + n + 1 : NULL;
}

/* The loop at its pass of a number, or of a name. */
static bool seek(struct index_loop *l, const struct piece *p, struct index_scope *scope, long pass, const char *name, size_t length)
{
    struct sga_error none = { 0 };
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
    bool is = true, found = false;
    if (!(p->body ? index_loop_read(l, p->text, scope, &none) : index_range_read(l, p->text, scope, &is, &none)))
        return false;
    for (bool more = index_first(l, &none); more && !found; more = more && !found ? index_next(l, &none) : more) {
        sga_buf_clear(&text);
        if (name)
            index_put_name(l, &text);
        found = name ? text.len == length && memcmp(text.data, name, length) == 0 : pass-- == 0;
        if (found)
            break;
    }
    return found;
}

static void tell(struct sga_error *err, const struct index_loop *l, const struct piece *p, const struct index_scope *scope)
{
    SGA_ENDS(sga_buf_free) struct sga_buf pass = { 0 }, text = { 0 };
    struct sga_error none = { 0 };
    index_put_pass(l, &pass);
    if (p->body)
        index_write(p->body, scope, &text, &none);
    size_t n = strlen(err->detail);
    snprintf(err->detail + n, sizeof err->detail - n, text.len ? " (where %.100s: %.200s)" : " (%.100s)", pass.data, text.len ? text.data : "");
}

/* The new pointer: the list, the element, the member of the body, and what follows. */
static void move(struct sga_error *err, const struct piece *p, long index, const char *member, const char *rest)
{
    SGA_ENDS(sga_buf_free) struct sga_buf at = { 0 };
    sga_buf_puts(&at, p->list);
    if (index >= 0)
        sga_buf_printf(&at, "/%ld", index);
    sga_buf_printf(&at, "%s%s%s", member ? "/" : "", member ? member : "", rest);
    snprintf(err->pointer, sizeof err->pointer, "%s", at.data);
}

/* The value at a pointer, or NULL. */
static const json_t *value_at(const json_t *v, const char *pointer)
{
    SGA_ENDS(sga_buf_free) struct sga_buf key = { 0 };
    while (v && *pointer == '/') {
        sga_buf_clear(&key);
        for (pointer++; *pointer && *pointer != '/'; pointer++) {
            bool escape = pointer[0] == '~' && (pointer[1] == '0' || pointer[1] == '1');
            sga_buf_put(&key, escape ? pointer[1] == '0' ? "~" : "/" : pointer, 1);
            pointer += escape;
        }
        const char *name = key.data ? key.data : "";
        v = json_is_array(v) ? json_array_get(v, (size_t)strtoul(name, NULL, 10)) : json_object_get(v, name);
    }
    return v;
}

/* Line and column were those of the text as it was written out. */
static void place(const json_t *v, const struct index_scope *scope, struct sga_error *err)
{
    const char *text = json_string_value(value_at(v, err->pointer));
    SGA_ENDS(sga_buf_free) struct sga_buf out = { 0 };
    struct sga_error none = { 0 };
    bool known = err->column > 0 && text && index_write(text, scope, &out, &none);
    size_t at = 0;
    for (int line = 1, column = 1; known && out.data && out.data[at] && (line < err->line || (line == err->line && column < err->column)); at++) {
        bool ends = out.data[at] == '\n';
        line += ends;
        column = ends ? 1 : column + (((unsigned char)out.data[at + 1] & 0xC0) != 0x80);
    }
    err->line = err->column = 0;
    if (known)
        lex_place(text, index_source(text, scope, at), &err->line, &err->column);
}

/* An element of a list: in a piece, or behind the last one that begins before it. */
static void element(const struct written *w, const json_t *v, struct sga_error *err, const struct piece *p, const char *segment)
{
    struct index_scope scope = w->sizes;
    struct index_loop l;
    char *rest;
    long k = strtol(segment, &rest, 10);
    if (k >= p->start + p->count) {
        move(err, p, p->index + 1 + k - p->start - p->count, NULL, rest);
    } else {
        if (seek(&l, p, &scope, k - p->start, NULL, 0))
            tell(err, &l, p, &scope);
        move(err, p, p->index, p->member, rest);
        if (!p->body)
            err->line = err->column = 0;              /* the whole name is meant */
    }
    place(v, &scope, err);
}

/* The member of an object, if it is one of the range's. */
static bool member(const struct written *w, const json_t *v, struct sga_error *err, const struct piece *p, const char *segment)
{
    struct index_scope scope = w->sizes;
    struct index_loop l;
    size_t n = strcspn(segment, "/");
    if (!strchr(segment, '[') || !seek(&l, p, &scope, 0, segment, n))
        return false;
    SGA_ENDS(sga_buf_free) struct sga_buf at = { 0 };
    sga_buf_printf(&at, "%s/%s%s", p->list, p->text, segment + n);
    tell(err, &l, p, &scope);
    snprintf(err->pointer, sizeof err->pointer, "%s", at.data);
    place(v, &scope, err);
    return true;
}

void written_place(const struct written *w, const json_t *v, struct sga_error *err)
{
    for (size_t i = w->pieces; i-- > 0 && err->code != SGA_E_OK;) {
        const struct piece *p = w->piece + i;
        const char *segment = below(err->pointer, p->list);
        if (!segment || (p->start >= 0 && (*segment < '0' || *segment > '9' || strtol(segment, NULL, 10) < p->start)))
            continue;
        if (p->start >= 0) {
            element(w, v, err, p, segment);
            return;
        }
        if (member(w, v, err, p, segment))
            return;
    }
    if (err->code != SGA_E_OK)
        place(v, &w->sizes, err);
}
