/* libcurl, loaded where a server is asked: with what it needs itself, forty libraries, it is half of the time in which a program starts that
 * solves here. */
#ifndef CLIENTS_LIBCURL_H
#define CLIENTS_LIBCURL_H

#include <stdbool.h>
#include <curl/curl.h>

/* The functions that are called, without curl_ before their names. */
#define LIBCURL_TABLE(X) \
    X(easy_init) X(easy_cleanup) X(easy_setopt) X(easy_perform) X(easy_getinfo) X(easy_header) X(easy_strerror) X(slist_append) X(slist_free_all) \
    X(url) X(url_cleanup) X(url_get) X(url_set) X(free)

struct libcurl {
#define X(name) __typeof__(&curl_##name) name;
    LIBCURL_TABLE(X)
#undef X
};

/* Only after libcurl_load. */
extern struct libcurl libcurl;
/* Loads it, unless it is there. False: it is not installed. By one thread. */
bool libcurl_load(void);

#endif
