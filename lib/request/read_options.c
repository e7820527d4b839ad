/* The small members: want, accuracy, limits. */
#include <math.h>
#include <string.h>

#include "error.h"
#include "reader.h"

static const char *const want_text[REQUEST_WANTS] = {
#define X(sym, text) text,
    REQUEST_WANT_TABLE(X)
#undef X
};

const char *request_want_text(int place)
{
    return want_text[place];
}

/* v is NULL where the member is absent: the default, which the caller completes. */
bool read_want(struct reader *rd, const json_t *v)
{
    if (!v) {
        rd->r->want = REQUEST_CONSTRAINTS | REQUEST_INDEX | REQUEST_VECTOR_FIELD | REQUEST_GAUGE;
        return true;
    }
    size_t mark = at_member(rd, "want");
    if (list_size(v) == 0)
        return at_fail(rd, SGA_E_SCHEMA, "nothing is wanted; leave `want` out for the default");
    for (size_t i = 0; i < list_size(v); i++) {
        size_t here = at_item(rd, v, i);
        int k = read_word(rd, list_item(v, i), want_text, REQUEST_WANTS, "something to want");
        if (k >= 0 && rd->r->want & 1u << k)
            k = (at_fail(rd, SGA_E_SCHEMA, "\"%s\" is wanted twice", want_text[k]), -1);
        if (k < 0 && !at_pass(rd, here))
            return false;
        if (k >= 0)
            rd->r->want |= 1u << k;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

static bool member_number(struct reader *rd, const json_t *v, const char *member, double low, double high, double *out)
{
    const json_t *m = json_object_get(v, member);
    if (!m)
        return true;
    size_t mark = at_member(rd, member);
    double given = *out;
    if (read_number(rd, m, low, high, &given))
        *out = given;
    else if (!at_pass(rd, mark))
        return false;
    at_back(rd, mark);
    return true;
}

static bool member_integer(struct reader *rd, const json_t *v, const char *member, long low, long high, int *out)
{
    const json_t *m = json_object_get(v, member);
    long given = *out;
    if (!m)
        return true;
    size_t mark = at_member(rd, member);
    if (read_integer(rd, m, low, high, &given))
        *out = (int)given;
    else if (!at_pass(rd, mark))
        return false;
    at_back(rd, mark);
    return true;
}

static bool read_method(struct reader *rd, const json_t *v)
{
    const json_t *m = json_object_get(v, "method");
    if (!m)
        return true;
    size_t mark = at_member(rd, "method");
    const char *name = read_string(rd, m);
    if (!name)
        return false;
    if (!*name || strlen(name) > REQUEST_MAX_NAME)
        return at_fail(rd, SGA_E_SCHEMA, "the name of a method has 1 to %d bytes, not %zu", REQUEST_MAX_NAME, strlen(name));
    rd->r->accuracy.method = sga_take_text(&rd->r->mem, name);
    at_back(rd, mark);
    return true;
}

bool read_accuracy(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "rtol", "atol", "arithmetic", "method", NULL };
    static const char *const arithmetic[] = { "auto", "double", "double-double", "ball" };
    struct request_accuracy *a = &rd->r->accuracy;
    size_t mark = at_member(rd, "accuracy");
    if (!only_members(rd, v, members))
        return false;
    const json_t *m = json_object_get(v, "arithmetic");
    if (m) {
        size_t here = at_member(rd, "arithmetic");
        int k = read_word(rd, m, arithmetic, 4, "an arithmetic");
        if (k < 0 && !at_pass(rd, here))
            return false;
        a->arithmetic = k < 0 ? REQUEST_AUTO : (enum request_arithmetic)k;
        at_back(rd, here);
    }
    /* doubles carry 2e-16; longer arithmetics go further */
    double finest = a->arithmetic == REQUEST_DOUBLE ? 1e-14 : a->arithmetic == REQUEST_BALL ? 1e-300 : 1e-30;
    if (!member_number(rd, v, "rtol", finest, 0.1, &a->rtol))
        return false;
    a->atol = fmax(a->rtol * REQUEST_ATOL_OF_RTOL, fmin(a->rtol, REQUEST_LEAST_ATOL));
    if (!member_number(rd, v, "atol", 1e-300, 1e300, &a->atol) || !read_method(rd, v))
        return false;
    a->own_atol = json_object_get(v, "atol") != NULL;
    at_back(rd, mark);
    return true;
}

bool read_families(struct reader *rd, const json_t *v)
{
    static const char *const words[] = { "auto", "fold", "whole" };
    size_t mark = at_member(rd, "families");
    int k = read_word(rd, v, words, 3, "a way to write what repeats");
    if (k >= 0)
        rd->r->families = (enum request_families)k;
    else if (!at_pass(rd, mark))
        return false;
    at_back(rd, mark);
    return true;
}

bool read_limits(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "seconds", "megabytes", "nodes", "generations", "terms", "bits", NULL };
    struct request_limits *l = &rd->r->limits;
    size_t mark = at_member(rd, "limits");
    if (!only_members(rd, v, members) || !member_number(rd, v, "seconds", 1e-3, 86400, &l->seconds)
        || !member_number(rd, v, "megabytes", 1, 1048576, &l->megabytes)
        || !member_integer(rd, v, "nodes", 1000, 1000000000, &l->nodes)
        || !member_integer(rd, v, "generations", 1, 100000, &l->generations)
        || !member_integer(rd, v, "terms", 1, 1000000, &l->terms)
        || !member_integer(rd, v, "bits", 64, REQUEST_MAX_BITS, &l->bits))
        return false;
    at_back(rd, mark);
    return true;
}
