/* Normal forms without keeping a bridge. */
#include "arena.h"
#include "bridge.h"

bool poly_normal(struct expr_store *st, expr_id e, const struct poly_limits *limits, expr_id *out)
{
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(st, &e, 1, limits);
    return b && poly_bridge_normal(b, e, out);
}

int poly_normal_all(struct expr_store *st, const expr_id *e, int n, const struct poly_limits *limits, expr_id *out)
{
    SGA_ENDS(poly_bridge_end) struct poly_bridge *all = poly_bridge_new(st, e, n, limits);
    int found = 0;
    for (int i = 0; i < n; i++) {
        expr_id root = e[i];        /* out may be e */
        out[i] = root;
        found += all ? poly_bridge_normal(all, root, out + i) : poly_normal(st, root, limits, out + i);
    }
    return found;
}
