/* Pieces of a time span against what is known of a function: narrow pulses anywhere, waves, singular places. */
#include <math.h>

#include "check.h"
#include "smooth_pieces.h"

static struct expr_store st;
static expr_id t;
static int time_symbol;

static expr_id square_of(expr_id e) { return expr_powi(&st, e, 2); }
static expr_id shifted(long p, long q) { return expr_sub(&st, t, expr_rational(&st, p, q)); }

/* The step allowed at a place. */
static double step_at(const struct enc_pieces *q, double at)
{
    int i = 0;
    while (i + 1 < q->count && q->end[i] < at)
        i++;
    return q->step[i];
}

static void test_pulses(void)
{
    unsigned long seed = check_seed(5);
    for (int k = 0; k < check_scale(60); k++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        long at = (long)(seed >> 33) % 997;
        double width = pow(10, -2.0 - (double)(k % 5)), place = (double)at / 997;
        expr_id rate = expr_int(&st, (long)lround(1 / (width * width)));
        expr_id arg = expr_mul(&st, rate, square_of(shifted(at, 997)));
        expr_id shape[] = { expr_fun(&st, EXPR_EXP, expr_neg(&st, arg)), expr_div(&st, expr_int(&st, 1), expr_add(&st, expr_int(&st, 1), arg)),
                            expr_add(&st, expr_fun(&st, EXPR_SIN, t), expr_fun(&st, EXPR_EXP, expr_neg(&st, arg))) };
        struct enc_pieces q;
        CHECK(enc_pieces_find(&q, &st, shape[k % 3], time_symbol, 0, 1, 1e-9, 3000) && q.complete);
        CHECK(step_at(&q, place) <= 10 * width, "width %g: step %g", width, step_at(&q, place));
        CHECK(fabs(place - 0.5) < 0.1 || k % 3 == 1 || step_at(&q, place < 0.5 ? 0.99 : 0.01) >= 0.05, "far away: %g", step_at(&q, place < 0.5 ? 0.99 : 0.01));
        CHECK(q.count < 1000, "%d", q.count);
        for (int i = 1; i < q.count; i++)
            CHECK(q.end[i] > q.end[i - 1]);
        CHECK(q.end[q.count - 1] == 1);
        enc_pieces_clear(&q);
    }
}

static void test_others(void)
{
    struct enc_pieces q;
    CHECK(enc_pieces_find(&q, &st, expr_add(&st, square_of(t), t), time_symbol, -3, 8, 1e-9, 100) && q.count == 1 && q.complete);
    enc_pieces_clear(&q);
    CHECK(enc_pieces_find(&q, &st, expr_fun(&st, EXPR_SIN, t), time_symbol, 0, 100, 1e-9, 3000) && q.count <= 64 && q.complete, "%d", q.count);
    enc_pieces_clear(&q);
    expr_id fast = expr_fun(&st, EXPR_SIN, expr_mul(&st, expr_int(&st, 100000), t));
    CHECK(enc_pieces_find(&q, &st, fast, time_symbol, 0, 100, 1e-9, 300) && q.count == 300 && !q.complete);
    enc_pieces_clear(&q);
    expr_id smooth = expr_div(&st, expr_fun(&st, EXPR_SIN, t), t);      /* at 0: no series in balls, and no reason for short steps */
    CHECK(enc_pieces_find(&q, &st, smooth, time_symbol, -1, 1, 1e-9, 3000) && q.complete && isinf(step_at(&q, 1e-4)) && isinf(step_at(&q, 0)));
    enc_pieces_clear(&q);
    expr_id outside = expr_fun(&st, EXPR_LOG, expr_sub(&st, t, expr_int(&st, 5)));
    CHECK(enc_pieces_find(&q, &st, outside, time_symbol, 0, 1, 1e-9, 5000) && q.complete);
    enc_pieces_clear(&q);
}

int main(void)
{
    expr_store_init(&st);
    t = expr_symbol_add(&st, "t", EXPR_TIME);
    time_symbol = st.node[t].a;
    test_pulses();
    test_others();
    expr_store_clear(&st);
    return CHECK_END();
}
