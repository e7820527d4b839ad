/* Texts of addresses. */
#include "peer.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stddef.h>

_Static_assert(PEER_TEXT == INET6_ADDRSTRLEN, "as long as an address gets");

const char *peer_text(const struct sockaddr *a, char text[PEER_TEXT])
{
    if (a && a->sa_family == AF_INET)
        return inet_ntop(AF_INET, &((const struct sockaddr_in *)a)->sin_addr, text, PEER_TEXT);
    if (a && a->sa_family == AF_INET6)
        return inet_ntop(AF_INET6, &((const struct sockaddr_in6 *)a)->sin6_addr, text, PEER_TEXT);
    return a && a->sa_family == AF_UNIX ? "unix" : NULL;
}
