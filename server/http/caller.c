/* Bearer tokens (RFC 6750). Only the header counts: a token in a URL ends up in logs. */
#include "caller.h"
#include "budget.h"
#include "log.h"
#include "reply.h"
#include "routes.h"
#include "service.h"
#include "tokens.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "error.h"

static enum MHD_Result count_one(void *cls, enum MHD_ValueKind kind, const char *name, const char *value)
{
    (void)kind;
    (void)value;
    *(int *)cls += strcasecmp(name, "Authorization") == 0;
    return MHD_YES;
}

enum { TOLD_A_SECOND = 20 };      /* of who is refused: one who tries without end shall not fill the log */

/* What was told of one kind: those who have no token leave room for what tokens may not. */
struct telling {
    const char *event;
    atomic_long second, told, left_out;
};

/* An audit line. Those that were left out are counted in the next one of its kind. */
static void tell(struct exchange *e, struct telling *t, const char *reason)
{
    char peer[PEER_TEXT], more[24];
    long now = (long)sga_now();
    if (atomic_exchange(&t->second, now) != now)
        atomic_store(&t->told, 0);
    if (atomic_fetch_add(&t->told, 1) >= TOLD_A_SECOND) {
        atomic_fetch_add(&t->left_out, 1);
        return;
    }
    long missing = atomic_exchange(&t->left_out, 0);
    snprintf(more, sizeof more, "%ld", missing);
    log_event(LOG_L_AUDIT, t->event, "request_id", e->request_id, "method", e->method, "route", e->route->pattern, "peer", exchange_peer(e, peer),
              "token", *e->account->name ? e->account->name : NULL, "reason", reason, "#left_out", missing ? more : NULL, NULL);
}

static bool unknown(struct exchange *e, struct sga_error *err, const char *detail, bool shown)
{
    static struct telling failed = { .event = "login_failed" };
    if (exchange_header(e, "Authorization"))
        tell(e, &failed, detail);
    reply_header(e, "WWW-Authenticate", "Bearer realm=\"sgad\"%s", shown ? ", error=\"invalid_token\"" : "");
    return sga_fail(err, SGA_E_UNAUTHENTICATED, "%s", detail);
}

bool caller_admit(struct exchange *e, unsigned needs, struct sga_error *err)
{
    struct token token;
    int given = 0;
    e->account = e->service->everyone;
    e->scopes = SCOPE_ALL;
    if (!e->service->tokens || !needs)
        return true;
    e->scopes = 0;
    MHD_get_connection_values(e->connection, MHD_HEADER_KIND, count_one, &given);
    const char *text = exchange_header(e, "Authorization");
    if (!text)
        return unknown(e, err, "A token is needed: Authorization: Bearer TOKEN.", false);
    if (given != 1 || strncasecmp(text, "Bearer ", 7) != 0)
        return unknown(e, err, "The only authorization known is one header of the form Authorization: Bearer TOKEN.", false);
    if (!tokens_find(e->service->tokens, text + 7 + strspn(text + 7, " "), &token))
        return unknown(e, err, "This token is not known, or it is no longer valid.", true);
    e->account = token.account;
    e->scopes = token.scopes & SCOPE_ADMIN ? SCOPE_ALL : token.scopes;
    unsigned may = e->scopes | (e->scopes & SCOPE_READ ? SCOPE_WATCH : 0);
    if ((may & needs) == needs)
        return true;
    static struct telling denied = { .event = "access_denied" };
    char names[64];
    scopes_write(needs, names, sizeof names);
    tell(e, &denied, names);
    reply_header(e, "WWW-Authenticate", "Bearer realm=\"sgad\", error=\"insufficient_scope\", scope=\"%s\"", names);
    return sga_fail(err, SGA_E_SCOPE, "This token may not do that; it would need the scope %s.", names);
}
