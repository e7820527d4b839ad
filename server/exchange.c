/* What handlers ask of an exchange. */
#include "exchange.h"
#include "budget.h"
#include "prefer.h"

const char *exchange_header(struct exchange *e, const char *name)
{
    return MHD_lookup_connection_value(e->connection, MHD_HEADER_KIND, name);
}

const char *exchange_query(struct exchange *e, const char *name)
{
    return MHD_lookup_connection_value(e->connection, MHD_GET_ARGUMENT_KIND, name);
}

void exchange_prefer(struct exchange *e, long otherwise)
{
    long asked = prefer_wait(exchange_header(e, "Prefer"));
    e->preferred = asked >= 0;
    e->wait_seconds = e->preferred ? asked : otherwise;
    if (e->wait_seconds > e->service->config.max_wait)
        e->wait_seconds = e->service->config.max_wait;
    e->wait_until = sga_now() + (double)e->wait_seconds;
}

bool exchange_wait(struct exchange *e, enum wait_kind kind, double until)
{
    e->waiter = (struct waiter){ .connection = e->connection, .account = e->account, .kind = kind, .deadline = until };
    /* Before the wait: once suspended, the exchange may be resumed on another thread. */
    conn_deadline(e->conn, 0);
    return jobs_wait(e->service->jobs, e->job, &e->waiter);
}
