/* One HTTP request and its reply, from the first header to the last byte. Handlers may be
 * called again after their connection was suspended, so what they know is kept here. */
#ifndef SERVER_EXCHANGE_H
#define SERVER_EXCHANGE_H

#include <microhttpd.h>
#include <stdbool.h>

#include "buf.h"
#include "digest.h"
#include "error.h"
#include "peer.h"
#include "waiter.h"

struct account;
struct conn;
struct route;
struct service;

enum { EXCHANGE_HEADERS = 12 };

struct exchange {
    struct service *service;
    struct MHD_Connection *connection;
    struct conn *conn;
    const struct route *route;       /* NULL until it is known */
    int route_number;                /* in the metrics */
    char request_id[72];
    char method[16];
    char traceparent[64];            /* "" where there is none */
    struct account *account;         /* on which it runs jobs and waits */
    unsigned scopes;
    bool begun;                      /* the headers were looked at */
    bool bad_path;                   /* a %00 in the path */
    bool last;                       /* nothing more is read from this connection */
    struct sga_error refusal;        /* already refused: the body is dropped, then this is the reply */
    double began;                    /* sga_now() */
    int status;                      /* of the reply; 0: none yet */
    enum sga_code problem;           /* that the reply tells of; SGA_E_OK: none */

    char segment[ID_LENGTH + 32];    /* the variable part of the path */
    unsigned char *body;
    size_t length, capacity, received;

    /* Of a body that another thread checks. */
    struct {
        bool done, ok;
        bool review;                 /* all that there is to say of it is asked for, and stands in canonical */
        unsigned char sum[DIGEST_BYTES];
        struct sga_buf canonical;
        struct sga_error err;
        struct exchange *next;
    } check;

    struct { const char *name; char value[160]; } header[EXCHANGE_HEADERS];
    int headers;                     /* for the reply */
    bool tagged, packs;              /* it has an entity tag; its body is to be packed */

    /* Of the handlers that wait. */
    struct job *job;
    struct waiter waiter;
    bool preferred;                  /* the client said how long to wait */
    long wait_seconds;               /* granted */
    double wait_until;
    bool withdrawn;                  /* its interest is: only the disk is waited for */
    double stored_until;             /* how long it waits for the disk; 0: not asked yet */
};

/* A header of the request; NULL where there is none. */
const char *exchange_header(struct exchange *e, const char *name);
/* Who asks, for the log: peer.h; NULL where that is not known. */
const char *exchange_peer(struct exchange *e, char text[PEER_TEXT]);
/* A parameter of the query; NULL where there is none. */
const char *exchange_query(struct exchange *e, const char *name);
/* Books the body's new size against the bound on all bodies. False where it is too much: then
 * the body is given up, and the refusal stands in e->refusal. */
bool exchange_grow(struct exchange *e, size_t capacity);
/* Frees the body and its booking; allowed twice. */
void exchange_free_body(struct exchange *e);
/* How long this request waits: as Prefer says, else so many seconds; never past the limit. */
void exchange_prefer(struct exchange *e, long otherwise);
/* Waits for the job in e->job: true where the connection was suspended. */
bool exchange_wait(struct exchange *e, enum wait_kind kind, double until);

#endif
