/* Pairs of certificate and key. A handshake may still use a pair that was replaced, so those stay
 * until the end; a pair is replaced only where its files' text has changed. */
#include "tls.h"

#include <assert.h>
#include <errno.h>
#include <gnutls/abstract.h>
#include <gnutls/gnutls.h>
#include <gnutls/x509.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "config.h"

enum { CHAIN = 16 };
static const long PEM_MOST = 1 << 20;

struct pair {
    char *cert_text, *key_text;
    gnutls_pcert_st chain[CHAIN];
    unsigned count;
    gnutls_privkey_t key;
    int64_t expires;
    struct pair *older;
};

static _Atomic(struct pair *) shown;
static int64_t looked_at[2];         /* times of the files, in nanoseconds */

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

static gnutls_datum_t datum(const char *text)
{
    return (gnutls_datum_t){ (unsigned char *)(uintptr_t)text, (unsigned)strlen(text) };
}

/* GnuTLS's own check, as it would be made of a pair of files. */
static int belong_together(const struct pair *p)
{
    gnutls_certificate_credentials_t credentials;
    gnutls_datum_t cert = datum(p->cert_text), key = datum(p->key_text);
    int rc = gnutls_certificate_allocate_credentials(&credentials);
    if (rc != GNUTLS_E_SUCCESS)
        return rc;
    rc = gnutls_certificate_set_x509_key_mem(credentials, &cert, &key, GNUTLS_X509_FMT_PEM);
    gnutls_certificate_free_credentials(credentials);
    return rc < 0 ? rc : 0;
}

static int take_apart(struct pair *p)
{
    gnutls_datum_t cert = datum(p->cert_text), key = datum(p->key_text);
    gnutls_x509_crt_t first;
    p->count = CHAIN;
    int rc = gnutls_pcert_list_import_x509_raw(p->chain, &p->count, &cert, GNUTLS_X509_FMT_PEM, 0);
    if (rc < 0) {
        p->count = 0;
        return rc;
    }
    if ((rc = gnutls_privkey_init(&p->key)) < 0 || (rc = gnutls_privkey_import_x509_raw(p->key, &key, GNUTLS_X509_FMT_PEM, NULL, 0)) < 0
        || (rc = gnutls_pcert_export_x509(&p->chain[0], &first)) < 0)
        return rc;
    p->expires = gnutls_x509_crt_get_expiration_time(first);
    gnutls_x509_crt_deinit(first);
    return 0;
}

static void free_pair(struct pair *p)
{
    if (!p)
        return;
    for (unsigned i = 0; i < p->count; i++)
        gnutls_pcert_deinit(&p->chain[i]);
    if (p->key)
        gnutls_privkey_deinit(p->key);
    if (p->key_text)
        gnutls_memset(p->key_text, 0, strlen(p->key_text));
    free(p->key_text);
    free(p->cert_text);
    free(p);
}

static struct pair *read_pair(const struct config *c, char *why, size_t size)
{
    struct pair *p = calloc(1, sizeof *p);
    snprintf(why, size, "out of memory");
    if (!p || !(p->cert_text = read_text(c->tls_cert, why, size)) || !(p->key_text = read_text(c->tls_key, why, size))) {
        free_pair(p);
        return NULL;
    }
    int rc = belong_together(p);
    if (rc == 0)
        rc = take_apart(p);
    if (rc == 0)
        return p;
    snprintf(why, size, "%s and %s are no certificate and its key: %s", c->tls_cert, c->tls_key, gnutls_strerror(rc));
    free_pair(p);
    return NULL;
}

/* Notes the times of the files; true where they are others than before. */
static bool times_changed(const struct config *c)
{
    const char *path[2] = { c->tls_cert, c->tls_key };
    bool changed = false;
    for (int i = 0; i < 2; i++) {
        struct stat st;
        int64_t now = stat(path[i], &st) == 0 ? (int64_t)st.st_mtim.tv_sec * 1000000000 + st.st_mtim.tv_nsec : 0;
        changed |= now != looked_at[i];
        looked_at[i] = now;
    }
    return changed;
}

enum tls_news tls_renew(const struct config *c, bool always, char *why, size_t size)
{
    struct pair *old = atomic_load(&shown);
    if (!c->tls_cert || (!times_changed(c) && !always))
        return TLS_SAME;
    struct pair *fresh = read_pair(c, why, size);
    if (!fresh)
        return TLS_BAD;
    if (old && strcmp(old->cert_text, fresh->cert_text) == 0 && strcmp(old->key_text, fresh->key_text) == 0) {
        free_pair(fresh);
        return TLS_SAME;
    }
    assert(fresh->count > 0 && fresh->count <= CHAIN && fresh->key);
    fresh->older = old;
    atomic_store(&shown, fresh);
    return TLS_NEW;
}

bool tls_open(const struct config *c, char *why, size_t size)
{
    return tls_renew(c, true, why, size) != TLS_BAD;
}

bool tls_on(void)
{
    return atomic_load(&shown);
}

int64_t tls_expires(void)
{
    struct pair *p = atomic_load(&shown);
    return p ? p->expires : 0;
}

static int retrieve(gnutls_session_t session, const gnutls_datum_t *names, int count, const gnutls_pk_algorithm_t *kinds, int kind_count,
                    gnutls_pcert_st **chain, unsigned *length, gnutls_privkey_t *key)
{
    struct pair *p = atomic_load(&shown);
    (void)session, (void)names, (void)count, (void)kinds, (void)kind_count;
    *chain = p->chain;
    *length = p->count;
    *key = p->key;
    return 0;
}

void *tls_retrieve(void)
{
    gnutls_certificate_retrieve_function2 *f = retrieve;
    void *out;
    memcpy(&out, &f, sizeof out);
    return out;
}

void tls_close(void)
{
    for (struct pair *p = atomic_exchange(&shown, NULL), *older; p; p = older) {
        older = p->older;
        free_pair(p);
    }
}
