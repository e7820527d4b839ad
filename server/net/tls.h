/* The certificate that the service shows, and its key: read and checked before anything listens,
 * and read anew while it runs. One for the process. */
#ifndef SERVER_TLS_H
#define SERVER_TLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct config;

/* TLS 1.2 and 1.3, keys that nobody can work out later (forward secrecy), authenticated encryption. */
#define TLS_PRIORITIES "PFS:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2:-CIPHER-ALL:+AES-256-GCM:+CHACHA20-POLY1305:+AES-128-GCM:-MAC-ALL:+AEAD"

enum tls_news { TLS_SAME, TLS_NEW, TLS_BAD };

/* Reads what config names (nothing: true), and checks that the key belongs to the certificate.
 * False with the reason in why. */
bool tls_open(const struct config *c, char *why, size_t size);
/* Has the files changed since they were last looked at (always: looks in any case)? Then the new
 * pair is shown from the next connection on. TLS_BAD with the reason in why: the old one stays.
 * One thread at a time. */
enum tls_news tls_renew(const struct config *c, bool always, char *why, size_t size);
bool tls_on(void);
/* When the certificate ends, in seconds since 1970; 0 where there is none. */
int64_t tls_expires(void);
/* For the HTTP library: of the kind gnutls_certificate_retrieve_function2. */
void *tls_retrieve(void);
/* Once nobody is served any more. Wipes the keys. */
void tls_close(void);

#endif
