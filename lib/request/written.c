/* Ranges and loops written out: JSON to JSON. The recursion is as deep as the JSON, which load_json has bounded. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "index.h"
#include "lowered.h"
#include "mem.h"
#include "parse.h"
#include "reader.h"
#include "written_piece.h"

struct walk {
    struct reader *rd;
    struct written *w;
    struct index_scope scope;     /* the sizes, and loop names while a loop is written out */
    json_t *taken;                /* names of the system, without indices */
    unsigned clock;
};

static json_t *write_value(struct walk *k, json_t *v, bool texts);

/* Is there anything to do? texts: sizes are put in wherever they stand, not between [ and ] only. */
static bool touches(const struct walk *k, const json_t *v, bool texts)
{
    const struct index_scope none = { .names = 0 };
    if (json_is_string(v))
        return index_touches(json_string_value(v), texts ? &k->scope : &none);
    if (json_is_array(v)) {
        for (size_t i = 0; i < json_array_size(v); i++)
            if (touches(k, json_array_get(v, i), texts))
                return true;
        return false;
    }
    const char *key;
    json_t *item;
    json_object_foreach((json_t *)v, key, item)
        if (index_touches(key, &none) || strcmp(key, "for") == 0 || (strcmp(key, "name") != 0 && touches(k, item, texts)))
            return true;
    return false;
}

/* An error of index.h, at the present place. */
static void *fault(struct walk *k, const struct sga_error *why, const struct index_loop *l)
{
    struct sga_error *err = k->rd->err;
    SGA_ENDS(sga_buf_free) struct sga_buf pass = { 0 };
    if (l)
        index_put_pass(l, &pass);
    at_fail(k->rd, why->code, "%s%s%s%s", why->detail, pass.len ? " (" : "", pass.len ? pass.data : "", pass.len ? ")" : "");
    err->line = why->line;
    err->column = why->column;
    return NULL;
}

/* One element more, of so many bytes. */
static bool pay(struct walk *k, size_t bytes)
{
    k->w->bytes += bytes;
    if (k->w->bytes > REQUEST_MAX_WRITTEN_BYTES)
        return at_fail(k->rd, SGA_E_LIMIT_VARIABLES, "written out, the texts pass the limit of %d bytes", REQUEST_MAX_WRITTEN_BYTES);
    if (++k->clock % 1024 == 0 && sga_now() > k->rd->r->store.deadline)
        return at_fail(k->rd, SGA_E_LIMIT_SECONDS, "the time limit of %g seconds ended while ranges and loops were written out", k->rd->r->store.seconds);
    return true;
}

/* Counts what a loop makes, before it is made, against the limits: `bytes` is about what each element has. */
static bool afford(struct walk *k, struct index_loop *l, size_t bytes, long *count)
{
    struct sga_error why = { 0 };
    if (!index_count(l, REQUEST_MAX_WRITTEN - k->w->elements, count, &why))
        return fault(k, &why, l->dims > 1 ? l : NULL), false;
    k->w->elements += *count;
    struct reader *rd = k->rd;
    /* What a check may take: eight nodes for an element is little. */
    if (rd->bounds && rd->r->store.max_nodes == rd->bounds->nodes && k->w->elements > rd->bounds->nodes / 8)
        return at_fail(rd, SGA_E_LIMIT_NODES, "ranges and loops make more than %d elements", rd->bounds->nodes / 8);
    if (k->w->bytes + bytes * (size_t)*count > REQUEST_MAX_WRITTEN_BYTES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "written out, the texts pass the limit of %d bytes", REQUEST_MAX_WRITTEN_BYTES);
    return true;
}

static void note(struct walk *k, const char *text, const char *body, const char *member, long start, long count, long index)
{
    struct written *w = k->w;
    struct sga_arena *mem = &k->rd->mem;
    SGA_RESERVE(w->piece, w->cap, w->pieces + 1);
    w->piece[w->pieces++] = (struct piece){ .list = sga_take_text(mem, k->rd->at.data ? k->rd->at.data : ""), .text = sga_take_text(mem, text),
        .body = body ? sga_take_text(mem, body) : NULL, .member = member, .start = start, .count = count, .index = index };
}

static json_t *write_string(struct walk *k, const char *text, const struct index_loop *l)
{
    SGA_ENDS(sga_buf_free) struct sga_buf out = { 0 };
    struct sga_error why = { 0 };
    if (!index_write(text, &k->scope, &out, &why))
        return fault(k, &why, l);
    return pay(k, out.len) ? json_stringn(out.data ? out.data : "", out.len) : NULL;
}

/* No name of a loop may have another meaning. */
static bool free_names(struct walk *k, const struct index_loop *l)
{
    for (int i = 0; i < l->dims; i++) {
        char name[48] = "";
        memcpy(name, l->text + l->dim[i].name_at, l->dim[i].name_length);
        if (name[0] && json_object_get(k->taken, name))
            return at_fail(k->rd, SGA_E_DUPLICATE_NAME, "\"%s\" is a name of the system; take another for the loop", name);
    }
    return true;
}

/* Appends a range's names: x[1:3]. */
static bool write_range(struct walk *k, json_t *list, struct index_loop *l, long index, size_t mark)
{
    struct sga_error why = { 0 };
    SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
    long count, start = (long)json_array_size(list);
    if (!free_names(k, l) || !afford(k, l, strlen(l->text), &count))
        return false;
    for (bool more = index_first(l, &why); more; more = index_next(l, &why)) {
        sga_buf_clear(&name);
        index_put_name(l, &name);
        if (!pay(k, name.len) || json_array_append_new(list, json_stringn(name.data, name.len)))
            return false;
    }
    at_back(k->rd, mark);
    note(k, l->text, NULL, NULL, start, count, index);
    return true;
}

static const char *body_member(struct walk *k, const json_t *loop)
{
    static const char *const members[] = { "for", "equation", "expression", NULL };
    if (!only_members(k->rd, loop, members))
        return NULL;
    const char *one = json_object_get(loop, "equation") ? "equation" : "expression";
    if (!need_member(k->rd, loop, one))
        return NULL;
    if (json_object_size(loop) != 2)
        return at_fail(k->rd, SGA_E_SCHEMA, "a loop has one body: \"equation\", or \"expression\" in other lists"), NULL;
    return one;
}

/* Appends what a loop says once for each pass: {"for", "equation"}. */
static bool write_loop(struct walk *k, json_t *list, const json_t *loop, long index, size_t mark)
{
    struct reader *rd = k->rd;
    size_t here = rd->at.len;
    const char *member = body_member(k, loop), *text;
    if (!member)
        return false;
    at_member(rd, "for");
    if (!(text = read_string(rd, json_object_get(loop, "for"))))
        return false;
    struct sga_error why = { 0 };
    struct index_loop l;
    long count, start = (long)json_array_size(list);
    if (!index_loop_read(&l, text, &k->scope, &why))
        return fault(k, &why, NULL), false;
    at_back(rd, here);
    at_member(rd, member);
    const char *body = read_string(rd, json_object_get(loop, member));
    if (!body)
        return false;
    at_back(rd, here);
    at_member(rd, "for");
    if (!free_names(k, &l) || !afford(k, &l, strlen(body), &count))
        return false;
    at_back(rd, here);
    at_member(rd, member);
    for (bool more = index_first(&l, &why); more; more = index_next(&l, &why)) {
        json_t *e = write_string(k, body, &l);
        if (!e || json_array_append_new(list, e))
            return false;
    }
    at_back(rd, mark);
    note(k, text, body, member, start, count, index);
    return true;
}

/* Is this a name with a range, which stands for several? False, with an error, where it is wrong. The scope has the range's names. */
static bool read_range(struct walk *k, const json_t *v, struct index_loop *l, bool *is)
{
    struct sga_error why = { 0 };
    *is = false;
    if (!json_is_string(v) || !strchr(json_string_value(v), '[') || index_range_read(l, json_string_value(v), &k->scope, is, &why))
        return true;
    return fault(k, &why, NULL), false;
}

/* Appends an element of a list, or what it stands for. index -1: it stands alone. */
static bool write_item(struct walk *k, json_t *list, json_t *item, long index, bool texts)
{
    size_t mark = index < 0 ? k->rd->at.len : at_index(k->rd, (size_t)index);
    int names = k->scope.names;                       /* those of loops around it stay */
    struct index_loop l;
    bool is, ok = read_range(k, item, &l, &is);
    if (ok && is)
        ok = write_range(k, list, &l, index, mark);
    else if (ok && json_is_object(item) && json_object_get(item, "for"))
        ok = write_loop(k, list, item, index, mark);
    else if (ok)
        ok = json_array_append_new(list, write_value(k, item, texts)) == 0;
    assert(!ok || k->scope.names >= names);
    k->scope.names = names;
    if (ok)
        at_back(k->rd, mark);
    return ok;
}

static json_t *write_list(struct walk *k, json_t *v, bool texts)
{
    json_t *list = json_array();
    bool ok = list != NULL;
    if (!json_is_array(v))
        ok = ok && write_item(k, list, v, -1, texts);
    for (size_t i = 0; ok && json_is_array(v) && i < json_array_size(v); i++)
        ok = write_item(k, list, json_array_get(v, i), (long)i, texts);
    if (!ok)
        json_decref(list);
    return ok ? list : NULL;
}

static bool set_member(struct walk *k, json_t *object, const char *key, json_t *value)
{
    if (value && json_object_get(object, key)) {
        json_decref(value);
        return at_fail(k->rd, SGA_E_DUPLICATE_NAME, "\"%.100s\" is given twice", key);
    }
    return json_object_set_new(object, key, value) == 0;
}

/* A member of bounds: one pair for all names, or a list of pairs. */
static bool is_pair(const struct walk *k, const json_t *value)
{
    return k->rd->at.data && strstr(k->rd->at.data, "/bounds/") && json_is_array(value) && !json_is_array(json_array_get(value, 0));
}

/* What a member of a range has: the same for all, one for each, or a text with the names of the range in it. */
static json_t *value_of(struct walk *k, json_t *value, long pass, const struct index_loop *l)
{
    if (is_pair(k, value))
        return write_value(k, value, true);
    if (json_is_array(value))
        value = json_array_get(value, (size_t)pass);
    if (json_is_array(value))
        return write_value(k, value, true);
    return json_is_string(value) ? write_string(k, json_string_value(value), l) : pay(k, 0) ? json_incref(value) : NULL;
}

/* Members of a range: "x[1:3]": 0, "x[i = 1:3]": "i/10", "x[1:3]": [0, 1, 0]. */
static bool write_range_members(struct walk *k, json_t *object, struct index_loop *l, json_t *value)
{
    struct sga_error why = { 0 };
    SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
    long count, pass = 0;
    size_t bytes = strlen(l->text) + (json_is_string(value) ? json_string_length(value) : 0);
    if (!free_names(k, l) || !afford(k, l, bytes, &count))
        return false;
    if (json_is_array(value) && !is_pair(k, value) && json_array_size(value) != (size_t)count)
        return at_fail(k->rd, SGA_E_SHAPE, "there are %zu values, but %ld names", json_array_size(value), count);
    for (bool more = index_first(l, &why); more; more = index_next(l, &why), pass++) {
        sga_buf_clear(&name);
        index_put_name(l, &name);
        if (!set_member(k, object, name.data, value_of(k, value, pass, l)))
            return false;
    }
    return true;
}

static bool write_member(struct walk *k, json_t *object, const char *key, json_t *value, bool texts)
{
    size_t mark = at_member(k->rd, key);
    struct sga_error why = { 0 };
    struct index_loop l;
    int names = k->scope.names;
    bool is = false, ok;
    if (strchr(key, '[') && !index_range_read(&l, key, &k->scope, &is, &why)) {
        k->scope.names = names;
        return fault(k, &why, NULL), false;
    }
    if (is) {
        ok = write_range_members(k, object, &l, value);
        k->scope.names = names;
        if (ok) {
            size_t inside = k->rd->at.len;
            at_back(k->rd, mark);
            note(k, l.text, NULL, NULL, -1, 0, 0);
            k->rd->at.len = inside;
        }
    } else {
        SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
        const struct index_scope sizes = k->scope;
        ok = strchr(key, '[') ? index_write(key, &sizes, &name, &why) || (fault(k, &why, NULL), false) : true;
        static const char *const words[] = { "name", "form", "time", "direction", "action", "interpolation" };
        bool as_is = false;
        for (size_t i = 0; i < sizeof words / sizeof *words; i++)
            as_is |= strcmp(key, words[i]) == 0;
        ok = ok && set_member(k, object, name.len ? name.data : key, as_is ? json_incref(value) : write_value(k, value, texts));
    }
    if (ok)
        at_back(k->rd, mark);
    return ok;
}

static json_t *write_object(struct walk *k, json_t *v, bool texts)
{
    json_t *object = json_object(), *item;
    const char *key;
    bool ok = object != NULL;
    json_object_foreach(v, key, item)
        if (!(ok = ok && write_member(k, object, key, item, texts)))
            break;
    if (!ok)
        json_decref(object);
    return ok ? object : NULL;
}

static json_t *write_value(struct walk *k, json_t *v, bool texts)
{
    if (!touches(k, v, texts))
        return json_incref(v);
    struct index_loop l;
    int names = k->scope.names;
    bool is, ok = read_range(k, v, &l, &is);
    k->scope.names = names;
    if (!ok)
        return NULL;
    if (is || json_is_array(v) || json_object_get(v, "for"))
        return write_list(k, v, texts);
    return json_is_string(v) ? write_string(k, json_string_value(v), NULL) : write_object(k, v, texts);
}

/* Names of the system without their indices; sizes and loops may not have them. */
static void take_names(json_t *taken, const json_t *v)
{
    for (size_t i = 0; v && !json_is_object(v) && i < list_size(v); i++) {
        const char *s = json_string_value(list_item(v, i));
        if (s)
            json_object_set_new(taken, s, json_true());
    }
    const char *key;
    json_t *item;
    json_object_foreach((json_t *)v, key, item)
        json_object_set_new(taken, key, json_true());
}

static bool take_all(struct walk *k, const json_t *system)
{
    static const char *const lists[] = { "variables", "coordinates", "unknowns", "states", "inputs", "outputs", "parameters", "modes", "tables", "time" };
    json_t *names = json_object();
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        take_names(names, json_object_get(system, lists[i]));
    const char *key;
    json_t *item;
    json_object_foreach(names, key, item) {
        size_t n = strcspn(key, "[");
        json_object_setn_new(k->taken, key, n, json_true());
    }
    if (!json_object_get(system, "time"))
        json_object_set_new(k->taken, "t", json_true());
    json_decref(names);
    return true;
}

/* A size whose value may stand for others that are not known yet: then *later. */
static bool read_size(struct walk *k, const char *key, const json_t *v, bool *later)
{
    long value;
    struct sga_error why = { 0 };
    if (json_is_integer(v)) {
        value = json_integer_value(v) >= 0 && json_integer_value(v) <= INDEX_MOST ? (long)json_integer_value(v) : -1;
    } else if (!json_is_string(v)) {
        return expected(k->rd, "a whole number, or a text of whole numbers and other sizes", v);
    } else if (!index_value(json_string_value(v), &k->scope, &value, &why)) {
        if ((*later &= why.code == SGA_E_EXPR_NAME))
            return true;
        return fault(k, &why, NULL), false;
    }
    *later = false;
    if (value < 0)
        return at_fail(k->rd, SGA_E_SCHEMA, "a size is a whole number from 0 to %d", INDEX_MOST);
    assert(k->scope.names == k->scope.sizes && k->scope.names < INDEX_SIZES);
    k->scope.name[k->scope.names] = (struct index_name){ sga_take_text(&k->rd->mem, key), strlen(key), value };
    k->scope.sizes = ++k->scope.names;
    return true;
}

static bool size_name(struct walk *k, const char *key)
{
    bool reserved = expr_reserved(key) || lowered_function(key, strlen(key));
    if (!is_identifier(key) || strchr(key, '[') || reserved || strlen(key) > REQUEST_MAX_NAME)
        return at_fail(k->rd, SGA_E_BAD_NAME, reserved ? "\"%.60s\" is a name of the grammar and cannot be a size" : "\"%.60s\" is no name: letters, digits and _", key);
    return !json_object_get(k->taken, key) || at_fail(k->rd, SGA_E_DUPLICATE_NAME, "\"%.60s\" is a name of the system; a size needs one of its own", key);
}

/* The order of members says nothing: sizes that wait for others are read again, while there are more of them known. */
static bool read_all_sizes(struct walk *k, const json_t *sizes)
{
    bool waits = true, may_wait = true;
    while (waits) {
        int known = k->scope.names;
        const char *key;
        json_t *v;
        waits = false;
        json_object_foreach((json_t *)sizes, key, v) {
            size_t here = at_member(k->rd, key);
            bool later = may_wait;
            if (index_find(&k->scope, key, strlen(key)) < 0 && (!size_name(k, key) || !read_size(k, key, v, &later)))
                return false;
            waits |= index_find(&k->scope, key, strlen(key)) < 0;
            at_back(k->rd, here);
        }
        may_wait = k->scope.names > known;
    }
    return true;
}

static bool read_sizes(struct walk *k, const json_t *system)
{
    const json_t *sizes = json_object_get(system, "sizes");
    if (!sizes)
        return true;
    size_t mark = at_member(k->rd, "system");
    at_member(k->rd, "sizes");
    if (!json_is_object(sizes))
        return expected(k->rd, "an object of names and whole numbers", sizes);
    if (json_object_size(sizes) > INDEX_SIZES)
        return at_fail(k->rd, SGA_E_SCHEMA, "there are %zu sizes; the limit is %d", json_object_size(sizes), INDEX_SIZES);
    if (!read_all_sizes(k, sizes))
        return false;
    at_back(k->rd, mark);
    return true;
}

/* A member of the request: whether texts in it may have sizes anywhere. */
static bool write_part(struct walk *k, json_t *request, const char *key, json_t *part)
{
    size_t mark = at_member(k->rd, key);
    bool system = strcmp(key, "system") == 0;
    json_t *v = write_value(k, part, system || strcmp(key, "trajectory") == 0 || strcmp(key, "sweep") == 0);
    if (!v)
        return false;
    at_back(k->rd, mark);
    if (system && json_object_get(v, "sizes")) {
        json_t *copy = json_copy(v);
        json_decref(v);
        v = copy;
        json_object_del(v, "sizes");
    }
    return json_object_set_new(request, key, v) == 0;
}

static bool is_taken(const void *names, const char *name)
{
    return json_object_get(names, name) != NULL;
}

json_t *write_out(struct reader *rd, json_t *v)
{
    static const char *const parts[] = { "system", "trajectory", "sweep", "linearization", "transfer", "equilibria", "fit", "symmetries" };
    const json_t *system = json_object_get(v, "system");
    struct walk k = { .rd = rd };
    bool any = json_is_object(system) && json_object_get(system, "sizes");
    for (size_t i = 0; i < sizeof parts / sizeof *parts && !any; i++)
        any = json_object_get(v, parts[i]) && touches(&k, json_object_get(v, parts[i]), false);
    if (!any || !json_is_object(system))
        return json_incref(v);
    rd->written = k.w = sga_zeros(&rd->mem, 1, sizeof *k.w);
    k.taken = json_object();
    json_t *out = json_copy(v);
    bool ok = out && k.taken && take_all(&k, system) && read_sizes(&k, system);
    bool checked = rd->bounds && rd->r->store.max_nodes == rd->bounds->nodes;
    k.scope.taken = is_taken;
    k.scope.of = k.taken;
    k.scope.terms = &k.w->elements;
    k.scope.most_terms = checked && rd->bounds->nodes / 8 < REQUEST_MAX_WRITTEN ? rd->bounds->nodes / 8 : REQUEST_MAX_WRITTEN;
    for (size_t i = 0; i < sizeof parts / sizeof *parts && ok; i++)
        if (json_object_get(v, parts[i]))
            ok = write_part(&k, out, parts[i], json_object_get(v, parts[i]));
    assert(!ok || k.scope.names == k.scope.sizes);
    k.w->sizes = k.scope;
    k.w->sizes.taken = NULL;
    k.w->sizes.terms = NULL;
    json_decref(k.taken);
    if (ok)
        return out;
    written_end(rd->written);         /* places are those of the request as it stands */
    rd->written = NULL;
    json_decref(out);
    if (rd->err->code == SGA_E_OK)
        at_fail(rd, SGA_E_LIMIT_MEMORY, "no memory is left to write out ranges and loops");
    return NULL;
}

void written_end(struct written *w)
{
    free(w->piece);
    w->piece = NULL;
    w->pieces = 0;
}
