/* What follows from the table: the cheapest row for so many digits. */
#include "tradeoff.h"

#include <math.h>

static const int digits[TRADEOFF_CHOICES] = { 4, 6, 8, 10, 12, 0 };

static int cheapest(const struct tradeoff *t, int wanted)
{
    int best = -1;
    for (int i = 0; i < t->rows; i++) {
        const struct tradeoff_row *row = t->row + i;
        bool reached = row->compared && (wanted ? row->digits >= wanted : row->within);
        if (reached && (best < 0 || row->seconds < t->row[best].seconds))
            best = i;
    }
    return best;
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

static void put_choice(struct sga_buf *out, const struct tradeoff *t, int place)
{
    if (place < 0) {
        sga_buf_puts(out, "reached by none of the rows");
        return;
    }
    const struct tradeoff_row *row = t->row + place;
    sga_buf_puts(out, row->method);
    if (row->arithmetic != TRAJ_DOUBLE)
        sga_buf_printf(out, " in %s", tradeoff_arithmetic(row->arithmetic));
    sga_buf_printf(out, " at rtol %g, ", row->rtol);
    put_seconds(out, row->seconds);
}

void tradeoff_advice(struct tradeoff *t, double rtol, double atol)
{
    if (!t->best.has)
        sga_buf_puts(&t->advice, "no errors are known, because no solution could be found in the time whose own error is known: raise "
                     "limits.seconds, or ask for a shorter motion; ");
    for (int k = 0; k < TRADEOFF_CHOICES; k++) {
        t->choice[k] = (struct tradeoff_choice){ digits[k], cheapest(t, digits[k]) };
        sga_buf_puts(&t->advice, k ? "; " : "");
        if (digits[k])
            sga_buf_printf(&t->advice, "%d digits: ", digits[k]);
        else
            sga_buf_printf(&t->advice, "the tolerances asked for (rtol %g, atol %g): ", rtol, atol);
        put_choice(&t->advice, t, t->choice[k].row);
    }
}
