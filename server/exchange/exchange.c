/* What handlers ask of an exchange. */
#include "exchange.h"
#include "budget.h"
#include "config.h"
#include "conns.h"
#include "jobs.h"
#include "prefer.h"
#include "service.h"

#include <assert.h>
#include <stdlib.h>

#include "error.h"

const char *exchange_header(struct exchange *e, const char *name)
{
    return MHD_lookup_connection_value(e->connection, MHD_HEADER_KIND, name);
}

const char *exchange_peer(struct exchange *e, char text[PEER_TEXT])
{
    const union MHD_ConnectionInfo *info = MHD_get_connection_info(e->connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    return peer_text(info ? info->client_addr : NULL, text);
}

const char *exchange_query(struct exchange *e, const char *name)
{
    return MHD_lookup_connection_value(e->connection, MHD_GET_ARGUMENT_KIND, name);
}

bool exchange_grow(struct exchange *e, size_t capacity)
{
    struct service *sv = e->service;
    assert(capacity >= e->capacity && e->capacity >= e->length);
    long more = (long)(capacity - e->capacity);
    if (atomic_fetch_add(&sv->body_bytes, more) + more <= atomic_load(&sv->config->body_memory))
        return true;
    atomic_fetch_sub(&sv->body_bytes, more);
    exchange_free_body(e);
    return sga_fail(&e->refusal, SGA_E_BUSY, "Too many bytes of requests are being read at this moment. Try again soon.");
}

void exchange_free_body(struct exchange *e)
{
    long booked = atomic_fetch_sub(&e->service->body_bytes, (long)e->capacity);
    assert(booked >= (long)e->capacity);
    free(e->body);
    sga_buf_free(&e->check.canonical);
    e->body = NULL;
    e->length = e->capacity = 0;
}

void exchange_prefer(struct exchange *e, long otherwise)
{
    long asked = prefer_wait(exchange_header(e, "Prefer"));
    e->preferred = asked >= 0;
    e->wait_seconds = e->preferred ? asked : otherwise;
    if (e->wait_seconds > e->service->config->max_wait)
        e->wait_seconds = e->service->config->max_wait;
    e->wait_until = sga_now() + (double)e->wait_seconds;
}

bool exchange_wait(struct exchange *e, enum wait_kind kind, double until)
{
    assert(e->job && !e->waiter.waiting);
    e->waiter = (struct waiter){ .connection = e->connection, .account = e->account, .kind = kind, .deadline = until, .left = e->waiter.left };
    /* Before the wait: once suspended, the exchange may be resumed on another thread. */
    conn_deadline(e->conn, 0);
    return jobs_wait(e->service->jobs, e->job, &e->waiter);
}
