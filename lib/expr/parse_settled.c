/* Constants that show only once they are sorted. */
#include "arena.h"
#include "buf.h"
#include "error.h"
#include "parser.h"
#include "print.h"
#include "residue.h"

enum {
    SETTLED_BYTES = 4000,     /* of a print that is read back: longer ones are left as they are */
    SETTLED_ROUNDS = 8        /* terms meet when they are sorted, so that a second print may be shorter than the first */
};

expr_id parser_settled(const struct parser *p, expr_id e)
{
    if (p->as_it_stands || !e || expr_is_const(p->st, e) || !expr_seems_constant(p->st, e))
        return e;
    expr_id last = EXPR_UNDEF, now = e;
    for (int k = 0; k < SETTLED_ROUNDS && now && now != last && !expr_is_const(p->st, now); k++) {
        SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
        struct sga_error none = { 0 };
        last = now;
        now = expr_print(p->st, now, SETTLED_BYTES, &text) ? parser_read(p->st, text.data, &p->g, false, true, &none) : EXPR_UNDEF;
    }
    return now && expr_is_const(p->st, now) ? now : e;
}
