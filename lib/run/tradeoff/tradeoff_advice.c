/* What follows from the table: the cheapest row for so many digits, what is not known, and what was left out. */
#include "tradeoff.h"

#include <assert.h>
#include <math.h>
#include <string.h>

static const int digits[TRADEOFF_CHOICES] = { 4, 6, 8, 10, 12, 0 };

static bool reached(const struct tradeoff_row *row, int wanted)
{
    return row->compared && (wanted ? row->digits >= wanted : row->within);
}

/* Not, whatever the best solution is wrong by. One that ended elsewhere may be right, and the best one not. */
static bool surely_not(const struct tradeoff_row *row, int wanted)
{
    if (!row->finished || !tradeoff_ends_well(row->ended, row->ended_reason))
        return true;
    return row->compared && (wanted ? row->digits_most < wanted : row->beyond);
}

static struct tradeoff_choice choose(const struct tradeoff *t, int wanted)
{
    struct tradeoff_choice c = { wanted, -1, true };
    for (int i = 0; i < t->rows; i++) {
        if (reached(t->row + i, wanted) && (c.row < 0 || t->row[i].seconds < t->row[c.row].seconds))
            c.row = i;
        c.none = c.none && surely_not(t->row + i, wanted);
    }
    c.none = c.none && c.row < 0;
    return c;
}

static void put_seconds(struct sga_buf *out, double s)
{
    if (s < 1e-3)
        sga_buf_printf(out, "%.3g us", s * 1e6);
    else if (s < 1)
        sga_buf_printf(out, "%.3g ms", s * 1e3);
    else
        sga_buf_printf(out, "%.3g s", s);
}

static void put_choice(struct sga_buf *out, const struct tradeoff *t, const struct tradeoff_choice *c)
{
    if (c->row < 0) {
        sga_buf_puts(out, c->none ? "reached by none of the rows" : "not known to be reached, as the best solution is not known well enough");
        return;
    }
    const struct tradeoff_row *row = t->row + c->row;
    sga_buf_puts(out, row->method);
    if (row->arithmetic != TRAJ_DOUBLE)
        sga_buf_printf(out, " in %s", tradeoff_arithmetic(row->arithmetic));
    sga_buf_printf(out, " at rtol %g, ", row->rtol);
    put_seconds(out, row->seconds);
}

/* The first of several methods that were not begun in an arithmetic: they are told once. */
static bool told_before(const struct tradeoff *t, int place)
{
    const struct tradeoff_left_out *l = t->left_out + place;
    for (int i = 0; i < place; i++)
        if (t->left_out[i].not_begun && l->not_begun && strcmp(t->left_out[i].arithmetic, l->arithmetic) == 0)
            return true;
    return false;
}

/* What time did not allow: more of it might be cheaper, or tighter. */
static void put_left_out(struct sga_buf *out, const struct tradeoff *t)
{
    int told = 0;
    for (int i = 0; i < t->left_outs; i++) {
        const struct tradeoff_left_out *l = t->left_out + i;
        bool longer = strcmp(l->arithmetic, "double") != 0, whole = longer && l->not_begun;
        if (!(l->from > 0) || (whole && told_before(t, i)))
            continue;
        sga_buf_printf(out, "%s%s", told++ ? ", " : "; left out for want of time: ", whole ? l->arithmetic : l->method);
        if (longer && !whole)
            sga_buf_printf(out, " in %s", l->arithmetic);
        sga_buf_printf(out, " from rtol %g on", l->from);
    }
    if (told)
        sga_buf_printf(out, " (%sraise limits.seconds)", t->busy ? "the machine was busy with other work: ask again, or " : "");
}

void tradeoff_advice(struct tradeoff *t, double rtol, double atol)
{
    struct sga_buf *out = &t->advice;
    for (int k = 0; k < TRADEOFF_CHOICES; k++)
        t->choice[k] = choose(t, digits[k]);
    for (int k = 0; k < TRADEOFF_CHOICES && t->best.has; k++) {
        sga_buf_puts(out, k ? "; " : "");
        if (digits[k])
            sga_buf_printf(out, "%d digits: ", digits[k]);
        else
            sga_buf_printf(out, "the tolerances asked for (rtol %g, atol %g): ", rtol, atol);
        put_choice(out, t, t->choice + k);
    }
    if (!t->best.has)
        sga_buf_puts(out, "no errors are known, because no solution could be found in the time whose own error is known: raise "
                     "limits.seconds, or ask for a shorter motion");
    put_left_out(out, t);
    assert(t->advice.data);
}
