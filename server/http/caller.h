/* Who asks: the token of a request, and whether it may do what it asks for. */
#ifndef SERVER_CALLER_H
#define SERVER_CALLER_H

#include "exchange.h"

/* Fills e->account and e->scopes from the Authorization header, and compares with the scope
 * that the route and the method need (0: none). False with err filled, and with
 * WWW-Authenticate set where it belongs. Where access is open everyone may do everything. */
bool caller_admit(struct exchange *e, unsigned needs, struct sga_error *err);

#endif
