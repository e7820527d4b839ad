/* libcurl by its name on this system: with GnuTLS as Debian's client is built, or with OpenSSL; the calls are the same. */
#include "libcurl.h"

#include <dlfcn.h>
#include <stddef.h>
#include <string.h>

struct libcurl libcurl;

static void *opened(void)
{
    static const char *const name[] = { "libcurl-gnutls.so.4", "libcurl.so.4" };
    void *at = NULL;
    for (size_t k = 0; k < sizeof name / sizeof *name && !at; k++)
        at = dlopen(name[k], RTLD_NOW | RTLD_LOCAL);
    return at;
}

/* Pointers to functions are taken as the bytes that they are. */
static bool take(void *from, const char *name, void *to, size_t size)
{
    void *at = dlsym(from, name);
    _Static_assert(sizeof at == sizeof libcurl.easy_init, "a function's address");
    if (at)
        memcpy(to, &at, size);
    return at != NULL;
}

bool libcurl_load(void)
{
    static bool there;
    if (there)
        return true;
    void *from = opened();
    if (!from)
        return false;
    there = true;
#define X(name) there = take(from, "curl_" #name, &libcurl.name, sizeof libcurl.name) && there;
    LIBCURL_TABLE(X)
#undef X
    return there;
}
