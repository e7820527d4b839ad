/* PEM files for the HTTP library, which takes them as texts. */
#include "tls.h"

#include <errno.h>
#include <gnutls/gnutls.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const long PEM_MOST = 1 << 20;

static char *read_text(const char *path, char *why, size_t size)
{
    FILE *f = fopen(path, "re");
    char *text = calloc(1, (size_t)PEM_MOST + 1);
    size_t n = f && text ? fread(text, 1, (size_t)PEM_MOST + 1, f) : 0;
    bool ok = n > 0 && n <= (size_t)PEM_MOST && !ferror(f);
    if (!ok)
        snprintf(why, size, "cannot read %s: %s", path, f ? "it is empty, too long, or there is no memory" : strerror(errno));
    if (f)
        fclose(f);
    if (ok)
        return text;
    free(text);
    return NULL;
}

static bool belong_together(const struct config *c, const struct tls *t, char *why, size_t size)
{
    gnutls_certificate_credentials_t credentials;
    gnutls_datum_t cert = { (unsigned char *)t->cert, (unsigned)strlen(t->cert) }, key = { (unsigned char *)t->key, (unsigned)strlen(t->key) };
    int rc = gnutls_certificate_allocate_credentials(&credentials);
    if (rc == GNUTLS_E_SUCCESS) {
        rc = gnutls_certificate_set_x509_key_mem(credentials, &cert, &key, GNUTLS_X509_FMT_PEM);
        gnutls_certificate_free_credentials(credentials);
    }
    if (rc >= 0)
        return true;
    snprintf(why, size, "%s and %s are no certificate and its key: %s", c->tls_cert, c->tls_key, gnutls_strerror(rc));
    return false;
}

bool tls_read(const struct config *c, struct tls *out, char *why, size_t size)
{
    if (!c->tls_cert)
        return true;
    return (out->cert = read_text(c->tls_cert, why, size)) && (out->key = read_text(c->tls_key, why, size))
        && belong_together(c, out, why, size);
}

void tls_free(struct tls *t)
{
    if (t->key)
        gnutls_memset(t->key, 0, strlen(t->key));
    free(t->key);
    free(t->cert);
    *t = (struct tls){ NULL, NULL };
}
