/* Bearer tokens (RFC 6750). Only the header counts: a token in a URL ends up in logs. */
#include "caller.h"
#include "reply.h"

#include <string.h>
#include <strings.h>

static enum MHD_Result count_one(void *cls, enum MHD_ValueKind kind, const char *name, const char *value)
{
    (void)kind;
    (void)value;
    *(int *)cls += strcasecmp(name, "Authorization") == 0;
    return MHD_YES;
}

static bool unknown(struct exchange *e, struct sga_error *err, const char *detail, bool shown)
{
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
    if ((e->scopes & needs) == needs)
        return true;
    char names[64];
    scopes_write(needs, names, sizeof names);
    reply_header(e, "WWW-Authenticate", "Bearer realm=\"sgad\", error=\"insufficient_scope\", scope=\"%s\"", names);
    return sga_fail(err, SGA_E_SCOPE, "This token may not do that; it would need the scope %s.", names);
}
