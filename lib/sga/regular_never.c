/* Contradictions that rest on signs, in words. */
#include "regular.h"

#include <stdio.h>

#include "arena.h"
#include "buf.h"
#include "poly.h"
#include "print.h"

enum { SHORT = 220 };

/* ": it is a sum of squares plus a positive number, 3/4*y^2 + (x - 1/2*y)^2 + 1"; nothing where no such sum is found. */
static void squares(struct state *s, expr_id e, struct sga_buf *text)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, s->options->budget);
    struct poly_certificate c;
    SGA_ENDS(sga_buf_free) struct sga_buf sum = { 0 };
    if (!poly_certificate(s->st, e, &limits, &c))
        return;
    sga_buf_puts(text, ": ");
    if (c.factor) {
        sga_buf_puts(text, "the factor ");
        if (!expr_print(s->st, c.factor, SHORT / 2, text))
            sga_buf_puts(text, "(a long expression)");
    } else {
        sga_buf_puts(text, "it");
    }
    if (c.multiplier) {
        sga_buf_puts(text, " times ");
        if (!expr_print(s->st, c.multiplier, SHORT / 2, text))
            sga_buf_puts(text, "1 plus squares");
    }
    sga_buf_puts(text, c.sign > 0 ? " is a sum of squares plus a positive number" : " is minus a sum of squares and a positive number");
    if (expr_print(s->st, c.sum, SHORT, &sum))
        sga_buf_printf(text, c.sign > 0 ? ", %s" : ", -(%s)", sum.data);
}

void regular_never_text(struct state *s, expr_id e, const struct regular *r, char *text, size_t size)
{
    SGA_ENDS(sga_buf_free) struct sga_buf out = { 0 };
    if (r->reduced)
        sga_buf_puts(&out, "with the earlier constraints used up, ");
    sga_buf_puts(&out, r->outside ? "it has no real zero where the equations have values" : "it has no real zero");
    if (!r->outside)
        squares(s, r->reduced ? regular_reduced(s, e) : e, &out);
    snprintf(text, size, "%s", out.data);
}
