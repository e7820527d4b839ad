/* An address: what libcurl makes of it, and what follows for the token and the proxy. */
#include "http_client.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "libcurl.h"

static const char *environment(const char *name)
{
    const char *value = getenv(name);
    return value && *value ? value : NULL;
}

/* The names that libcurl itself takes for this machine, and its addresses. */
static bool loopback(const char *host)
{
    struct in_addr four;
    if (inet_pton(AF_INET, host, &four) == 1)
        return ntohl(four.s_addr) >> 24 == 127;
    return strcasecmp(host, "localhost") == 0 || strcmp(host, "[::1]") == 0;
}

static bool has(CURLU *u, CURLUPart part)
{
    char *text = NULL;
    bool there = libcurl.url_get(u, part, &text, 0) == CURLUE_OK;
    libcurl.free(text);
    return there;
}

/* Fills all but token and certificates. */
static bool read_url(CURLU *u, struct http_server *server)
{
    char *scheme = NULL, *host = NULL, *port = NULL, *all = NULL;
    bool ok = !has(u, CURLUPART_QUERY) && !has(u, CURLUPART_FRAGMENT) && libcurl.url_get(u, CURLUPART_SCHEME, &scheme, 0) == CURLUE_OK &&
              libcurl.url_get(u, CURLUPART_HOST, &host, 0) == CURLUE_OK && libcurl.url_get(u, CURLUPART_PORT, &port, CURLU_DEFAULT_PORT) == CURLUE_OK &&
              libcurl.url_get(u, CURLUPART_URL, &all, 0) == CURLUE_OK;
    if (ok) {
        server->tls = strcasecmp(scheme, "https") == 0;
        server->here = loopback(host);
        int name = snprintf(server->name, sizeof server->name, "%s port %s", host, port), url = snprintf(server->url, sizeof server->url, "%s", all);
        ok = (server->tls || strcasecmp(scheme, "http") == 0) && name < (int)sizeof server->name && url < (int)sizeof server->url;
        for (; ok && url > 0 && server->url[url - 1] == '/'; url--)
            server->url[url - 1] = 0;
    }
    libcurl.free(scheme);
    libcurl.free(host);
    libcurl.free(port);
    libcurl.free(all);
    return ok;
}

bool http_parse(const char *url, struct http_server *server)
{
    const char *token = environment("SGA_TOKEN");
    *server = (struct http_server){ .token = token && !strpbrk(token, "\r\n") ? token : NULL, .ca = environment("SGA_CA") };
    if (strncmp(url, "unix:/", 6) == 0 && strlen(url + 5) < sizeof server->socket) {
        strcpy(server->socket, url + 5);
        strcpy(server->name, server->socket);
        strcpy(server->url, "http://localhost");
        server->here = true;
        return true;
    }
    if (!libcurl_load()) {            /* which http_ask says */
        snprintf(server->name, sizeof server->name, "%s", url);
        return true;
    }
    CURLU *u = libcurl.url();
    bool ok = u && strpbrk(url, " \t\r\n") == NULL && libcurl.url_set(u, CURLUPART_URL, url, CURLU_DISALLOW_USER) == CURLUE_OK && read_url(u, server);
    libcurl.url_cleanup(u);
    return ok;
}
