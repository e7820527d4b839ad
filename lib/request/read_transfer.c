/* The member `transfer`: from which inputs to which outputs, and at which frequencies. */
#include <math.h>

#include "arena.h"
#include "error.h"
#include "reader.h"

static const double LEAST = 1e-300, MOST = 1e300;

static bool take(struct reader *rd, size_t n, struct request_transfer *t)
{
    if (n < 1 || n > REQUEST_MAX_FREQUENCIES)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu frequencies; there must be 1 to %d", n, REQUEST_MAX_FREQUENCIES);
    t->frequency = sga_zeros(&rd->r->mem, n, sizeof *t->frequency);
    return true;
}

static bool read_list_of(struct reader *rd, const json_t *v, struct request_transfer *t)
{
    if (!take(rd, list_size(v), t))
        return false;
    for (size_t i = 0; i < list_size(v); i++) {
        size_t here = at_item(rd, v, i);
        if (!read_value(rd, list_item(v, i), t->frequency + i, NULL))
            return false;
        if (t->frequency[i] < 0 || t->frequency[i] > MOST)
            return at_fail(rd, SGA_E_SCHEMA, "a frequency is 0 or more");
        t->frequencies++;
        at_back(rd, here);
    }
    return true;
}

static bool read_end(struct reader *rd, const json_t *v, const char *member, double *out)
{
    const json_t *m = need_member(rd, v, member);
    size_t mark = at_member(rd, member);
    if (!m || !read_value(rd, m, out, NULL))
        return false;
    if (*out < LEAST || *out > MOST)
        return at_fail(rd, SGA_E_SCHEMA, "frequencies that are spaced by their logarithms are above 0");
    at_back(rd, mark);
    return true;
}

static double between(double from, double to, double part)
{
    double ratio = to / from;      /* of numbers from 1e-300 to 1e300: it may leave the doubles, powers of them do not */
    return isnormal(ratio) ? from * pow(ratio, part) : pow(from, 1 - part) * pow(to, part);
}

/* Evenly spaced by their logarithms, both ends included. */
static bool read_range(struct reader *rd, const json_t *v, struct request_transfer *t)
{
    static const char *const members[] = { "from", "to", "points", NULL };
    double from = 0, to = 0;
    long points = 0;
    if (!only_members(rd, v, members) || !read_end(rd, v, "from", &from) || !read_end(rd, v, "to", &to))
        return false;
    const json_t *m = need_member(rd, v, "points");
    if (!m)
        return false;
    size_t mark = at_member(rd, "points");
    if (!read_integer(rd, m, 2, REQUEST_MAX_FREQUENCIES, &points))
        return false;
    at_back(rd, mark);
    if (!take(rd, (size_t)points, t))
        return false;
    for (long i = 0; i < points; i++)
        t->frequency[i] = i == 0 ? from : i == points - 1 ? to : between(from, to, (double)i / (double)(points - 1));
    t->frequencies = (int)points;
    return true;
}

bool read_transfer(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "inputs", "outputs", "frequencies", NULL };
    struct request_transfer *t = &rd->r->transfer;
    size_t mark = at_member(rd, "transfer");
    if (!only_members(rd, v, members) || !read_ports(rd, v, &t->ports))
        return false;
    const json_t *f = json_object_get(v, "frequencies");
    size_t here = at_member(rd, "frequencies");
    if (f && !(json_is_object(f) ? read_range : read_list_of)(rd, f, t))
        return false;
    at_back(rd, here);
    at_back(rd, mark);
    return true;
}
