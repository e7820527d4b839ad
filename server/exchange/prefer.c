/* Reading Prefer and Accept. Both are lists with commas; what cannot be read is passed over. */
#include "prefer.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char *blank(const char *s)
{
    return s + strspn(s, " \t");
}

long prefer_wait(const char *header)
{
    long wait = -1;
    for (const char *p = header; p && *p;) {
        p = blank(p);
        if (strncasecmp(p, "wait", 4) == 0) {
            const char *v = blank(p + 4);
            if (*v == '=') {
                v = blank(v + 1);
                v += *v == '"';
                size_t digits = strspn(v, "0123456789");
                if (digits > 0)
                    wait = digits > 9 ? 999999999 : strtol(v, NULL, 10);
            }
        } else if (strncasecmp(p, "respond-async", 13) == 0 && wait < 0) {
            wait = 0;
        }
        p += strcspn(p, ",;");
        p += *p != 0;
    }
    return wait;
}

/* How well the range at r (length n) fits a type: 3 exact, 2 type slash star, 1 anything, 0 no. */
static int fit(const char *r, size_t n, const char *type)
{
    if (n == 3 && memcmp(r, "*/*", 3) == 0)
        return 1;
    size_t slash = strcspn(type, "/") + 1;
    if (n == slash + 1 && r[n - 1] == '*' && strncasecmp(r, type, slash) == 0)
        return 2;
    return strlen(type) == n && strncasecmp(r, type, n) == 0 ? 3 : 0;
}

static double quality(const char *p, const char *end)
{
    for (; p < end; p++) {
        if (*p != ';')
            continue;
        const char *q = blank(p + 1);
        if ((*q == 'q' || *q == 'Q') && q[1] == '=')
            return atof(q + 2);
    }
    return 1;
}

/* The quality that the most specific fitting range gives to a type. */
static double wish(const char *accept, const char *type)
{
    int best = 0;
    double q = 0;
    for (const char *p = accept; *p;) {
        p = blank(p);
        const char *end = p + strcspn(p, ",");
        int f = fit(p, strcspn(p, ",; \t"), type);
        if (f > best) {
            best = f;
            q = quality(p, end);
        }
        p = end + (*end != 0);
    }
    return q;
}

int prefer_type(const char *accept, const char *const *offered, int count)
{
    if (!accept || !*blank(accept))
        return 0;
    int best = -1;
    double best_q = 0;
    for (int i = 0; i < count; i++) {
        double q = wish(accept, offered[i]);
        if (q > best_q) {
            best_q = q;
            best = i;
        }
    }
    return best;
}

/* The weight of a coding by its own name; -1: it is not named. */
static double coding(const char *header, const char *name)
{
    size_t n = strlen(name);
    for (const char *p = header; *p;) {
        p = blank(p);
        const char *end = p + strcspn(p, ",");
        if (strcspn(p, ",; \t") == n && strncasecmp(p, name, n) == 0)
            return quality(p, end);
        p = end + (*end != 0);
    }
    return -1;
}

bool prefer_gzip(const char *header)
{
    if (!header)
        return false;
    double gzip = coding(header, "gzip"), any = coding(header, "*"), plain = coding(header, "identity");
    if (gzip < 0)
        gzip = coding(header, "x-gzip");
    if (gzip < 0)
        gzip = any;
    return gzip > 0 && gzip >= plain;
}
