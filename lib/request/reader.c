/* Strict access to JSON values, with the pointer of the place. */
#include "reader.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "suggest.h"

size_t at_member(struct reader *rd, const char *key)
{
    size_t mark = rd->at.len;
    sga_buf_put(&rd->at, "/", 1);
    for (const char *s = key; *s; s++) {
        if (*s == '~')
            sga_buf_put(&rd->at, "~0", 2);
        else if (*s == '/')
            sga_buf_put(&rd->at, "~1", 2);
        else
            sga_buf_put(&rd->at, s, 1);
    }
    return mark;
}

size_t at_index(struct reader *rd, size_t index)
{
    size_t mark = rd->at.len;
    sga_buf_printf(&rd->at, "/%zu", index);
    return mark;
}

void at_back(struct reader *rd, size_t mark)
{
    assert(mark <= rd->at.len);
    rd->at.len = mark;
    if (rd->at.data)
        rd->at.data[mark] = 0;
}

bool at_fail(struct reader *rd, enum sga_code code, const char *fmt, ...)
{
    assert(code != SGA_E_OK);
    char text[sizeof rd->err->detail];
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    return sga_fail_at(rd->err, code, rd->at.data ? rd->at.data : "", "%s", text);
}

const char *kind_of(const json_t *v)
{
    switch (v ? json_typeof(v) : JSON_NULL) {
    case JSON_OBJECT:  return "an object";
    case JSON_ARRAY:   return "an array";
    case JSON_STRING:  return "a string";
    case JSON_INTEGER:
    case JSON_REAL:    return "a number";
    case JSON_TRUE:    return "true";
    case JSON_FALSE:   return "false";
    default:           return "null";
    }
}

bool expected(struct reader *rd, const char *what, const json_t *v)
{
    return at_fail(rd, SGA_E_SCHEMA, "expected %s, found %s", what, kind_of(v));
}

/* Members as other programs call them, where the one that is meant is known. */
static const char *foreign_member(const char *key, const char *const *allowed)
{
    static const struct { const char *name, *beside, *advice; } foreign[] = {
        { "E", "B", "the form linear is A x' = B x + C u: what is E here is A there, A is B, and B is C" },
        { "states", "variables", "write \"variables\"" }, { "unknowns", "variables", "write \"variables\"" },
        { "eqs", "equations", "write \"equations\"" }, { "params", "parameters", "write \"parameters\"" },
        { "constants", "parameters", "write \"parameters\"" }, { "initial_conditions", "initial", "write \"initial\"" },
        { "x0", "initial", "write \"initial\": an object of variables and values" }, { "tspan", "stop", "write \"start\" and \"stop\"" },
        { "t_end", "stop", "write \"stop\"" }, { "tf", "stop", "write \"stop\"" }, { "reltol", "rtol", "write \"rtol\"" },
        { "abstol", "atol", "write \"atol\"" }, { "tolerance", "rtol", "write \"rtol\"" },
    };
    for (size_t i = 0; i < sizeof foreign / sizeof *foreign; i++)
        for (const char *const *a = allowed; *a && strcmp(key, foreign[i].name) == 0; a++)
            if (strcmp(*a, foreign[i].beside) == 0)
                return foreign[i].advice;
    return NULL;
}

/* The object of a request that has this member, where it is often looked for in another; or NULL, as in that object itself (whose form may have no such). */
static const char *home_of(const struct reader *rd, const char *key)
{
    static const struct { const char *name, *home; } homes[] = {
        { "rtol", "accuracy" }, { "atol", "accuracy" }, { "arithmetic", "accuracy" }, { "method", "accuracy" },
        { "seconds", "limits" }, { "megabytes", "limits" },
        { "start", "trajectory" }, { "stop", "trajectory" }, { "samples", "trajectory" }, { "times", "trajectory" }, { "initial", "trajectory" },
        { "events", "trajectory" }, { "outputs", "trajectory" }, { "sliding", "trajectory" }, { "sensitivities", "trajectory" },
        { "form", "system" }, { "variables", "system" }, { "equations", "system" }, { "parameters", "system" }, { "tables", "system" },
    };
    for (size_t i = 0; i < sizeof homes / sizeof *homes; i++)
        if (strcmp(key, homes[i].name) == 0)
            return rd->at.len && strcmp(rd->at.data + 1, homes[i].home) == 0 ? NULL : homes[i].home;
    return NULL;
}

/* The members of a request itself. */
static bool is_top(const char *key)
{
    static const char *const top[] = { "system", "want", "trajectory", "accuracy", "limits", "linearization", "transfer", "equilibria", "fit", "sweep", "symmetries", "strata" };
    for (size_t i = 0; i < sizeof top / sizeof *top; i++)
        if (strcmp(key, top[i]) == 0)
            return true;
    return false;
}

bool only_members(struct reader *rd, const json_t *v, const char *const *allowed)
{
    if (!json_is_object(v))
        return expected(rd, "an object", v);
    const char *key;
    json_t *item;
    json_object_foreach((json_t *)v, key, item) {
        const char *const *a = allowed;
        while (*a && strcmp(*a, key) != 0)
            a++;
        if (*a)
            continue;
        struct suggest s;
        suggest_begin(&s, key, strlen(key));
        SGA_ENDS(sga_buf_free) struct sga_buf known = { 0 };
        for (a = allowed; *a; a++) {
            suggest_offer(&s, *a);
            sga_buf_printf(&known, "%s%s", known.len ? ", " : "", *a);
        }
        const char *foreign = foreign_member(key, allowed), *home = home_of(rd, key);
        size_t mark = at_member(rd, key);
        if (foreign)
            at_fail(rd, SGA_E_UNKNOWN_MEMBER, "the member \"%.60s\" is not known; %s", key, foreign);
        else if (home)
            at_fail(rd, SGA_E_UNKNOWN_MEMBER, "the member \"%.60s\" is not known here; it stands in the object \"%s\" of the request", key, home);
        else if (is_top(key))
            at_fail(rd, SGA_E_UNKNOWN_MEMBER, "the member \"%.60s\" is not known here; it stands in the request itself, beside \"system\"", key);
        else if (s.best)
            at_fail(rd, SGA_E_UNKNOWN_MEMBER, "the member \"%.60s\" is not known; did you mean \"%s\"?", key, s.best);
        else
            at_fail(rd, SGA_E_UNKNOWN_MEMBER, "the member \"%.60s\" is not known here; known are %.500s", key, known.data);
        if (!at_pass(rd, mark))
            return false;
    }
    return true;
}

const json_t *need_member(struct reader *rd, const json_t *object, const char *key)
{
    const json_t *v = json_object_get(object, key);
    if (!v)
        at_fail(rd, SGA_E_MISSING_MEMBER, "the member \"%s\" is missing", key);
    return v;
}

size_t list_size(const json_t *v)
{
    return json_is_array(v) ? json_array_size(v) : 1;
}

const json_t *list_item(const json_t *v, size_t i)
{
    return json_is_array(v) ? json_array_get(v, i) : v;
}

size_t at_item(struct reader *rd, const json_t *list, size_t i)
{
    return json_is_array(list) ? at_index(rd, i) : rd->at.len;
}

bool store_ok(struct reader *rd)
{
    const struct sga_error *e = rd->r->store.error;
    return expr_store_ok(&rd->r->store) || at_fail(rd, e->code, "%s", e->detail);
}

static expr_id integer_constant(struct reader *rd, json_int_t v)
{
    expr_id e = expr_int(&rd->r->store, (long)v);
    return store_ok(rd) ? e : EXPR_UNDEF;
}

expr_id read_expression(struct reader *rd, const json_t *v, char **text)
{
    char decimal[40] = "";
    const char *s = decimal;
    if (json_is_string(v))
        s = json_string_value(v);
    else if (json_is_integer(v))
        snprintf(decimal, sizeof decimal, "%lld", (long long)json_integer_value(v));
    else if (json_is_real(v))
        sga_format_double(decimal, json_real_value(v));
    else
        return (expr_id)expected(rd, "an expression (a string or a number)", v);
    expr_id e = json_is_integer(v) ? integer_constant(rd, json_integer_value(v))
                                   : expr_parse(&rd->r->store, s, &rd->grammar, rd->err);
    if (!e) {
        if (rd->err && !rd->err->pointer[0] && rd->at.data)
            snprintf(rd->err->pointer, sizeof rd->err->pointer, "%s", rd->at.data);
    } else if (text) {
        *text = sga_take_text(&rd->r->mem, s);
    }
    return e;
}

bool read_exact(struct reader *rd, const json_t *v, double *out, expr_id *exact, char **text)
{
    char *own = NULL;
    expr_id e = read_expression(rd, v, &own);
    bool ok = e && (constant_value(&rd->r->store, e, out)
                    || at_fail(rd, SGA_E_SCHEMA, "expected a constant: a finite number, or an expression of numbers%s",
                               rd->symbolic[0] ? " and parameters that have a value" : " and parameters"));
    if (ok && text)
        *text = own;
    if (exact)
        *exact = e;
    return ok;
}

bool read_value(struct reader *rd, const json_t *v, double *out, char **text)
{
    return read_exact(rd, v, out, NULL, text);
}

bool read_number(struct reader *rd, const json_t *v, double low, double high, double *out)
{
    if (!json_is_number(v) && !json_is_string(v))
        return expected(rd, "a number", v);
    if (!read_value(rd, v, out, NULL))
        return false;
    if (*out >= low && *out <= high)
        return true;
    return at_fail(rd, SGA_E_SCHEMA, "the number %g lies outside its limits %g to %g", *out, low, high);
}

bool read_integer(struct reader *rd, const json_t *v, long low, long high, long *out)
{
    assert(low <= high);
    double d = json_is_number(v) ? json_number_value(v) : NAN;
    if (!(d == floor(d)) || isinf(d))
        return expected(rd, "an integer", v);
    if (d < (double)low || d > (double)high)
        return at_fail(rd, SGA_E_SCHEMA, "the integer %.0f lies outside its limits %ld to %ld", d, low, high);
    *out = (long)d;
    return true;
}

bool read_boolean(struct reader *rd, const json_t *v, bool *out)
{
    if (!json_is_boolean(v))
        return expected(rd, "true or false", v);
    *out = json_is_true(v);
    return true;
}

const char *read_string(struct reader *rd, const json_t *v)
{
    if (!json_is_string(v))
        expected(rd, "a string", v);
    return json_string_value(v);
}

int read_word(struct reader *rd, const json_t *v, const char *const *word, int n, const char *what)
{
    assert(n > 0);
    const char *s = read_string(rd, v);
    if (!s)
        return -1;
    struct suggest near;
    suggest_begin(&near, s, strlen(s));
    SGA_ENDS(sga_buf_free) struct sga_buf known = { 0 };
    for (int i = 0; i < n; i++) {
        if (strcmp(word[i], s) == 0)
            return i;
        suggest_offer(&near, word[i]);
        sga_buf_printf(&known, "%s\"%s\"", i ? ", " : "", word[i]);
    }
    if (near.best)
        at_fail(rd, SGA_E_SCHEMA, "\"%.60s\" is not %s; did you mean \"%s\"?", s, what, near.best);
    else
        at_fail(rd, SGA_E_SCHEMA, "\"%.60s\" is not %s; known are %.500s", s, what, known.data);
    return -1;
}
