/* The certificate and its key, read and checked before anything listens. */
#ifndef SERVER_TLS_H
#define SERVER_TLS_H

#include <stdbool.h>
#include <stddef.h>

#include "config.h"

/* TLS 1.2 and 1.3 only. */
#define TLS_PRIORITIES "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2"

struct tls { char *cert, *key; };      /* PEM texts; NULL: no TLS */

/* Reads what config names, and checks that the key belongs to the certificate. False with
 * the reason in why. */
bool tls_read(const struct config *c, struct tls *out, char *why, size_t size);
/* Also wipes the key. */
void tls_free(struct tls *t);

#endif
