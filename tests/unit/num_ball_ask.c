/* Values of what is asked for alone, against those of a whole store: random nodes, asked in any order, at points that change more often than rounds
 * have numbers; and nothing is evaluated that no question needs. */
#include <stdlib.h>

#include "ball.h"
#include "check.h"
#include "random_expr.h"

enum { SYMBOLS = 6, NODES = 400, ROUNDS = 600, QUESTIONS = 5 };

static expr_id pool[SYMBOLS + NODES];

static int build(struct random_source *r, struct expr_store *st)
{
    static const char *const name[SYMBOLS] = { "a", "b", "c", "d", "e", "f" };
    int n = 0;
    for (int k = 0; k < SYMBOLS; k++)
        pool[n++] = expr_symbol_add(st, name[k], EXPR_VARIABLE);
    while (n < SYMBOLS + NODES) {
        expr_id e = random_rational(r, st, pool, n);
        if (e)
            pool[n++] = e;
    }
    return n;
}

static void place(struct random_source *r, struct num_ball *b, struct num_ball *whole)
{
    num_ball_forget(b);
    num_ball_forget(whole);
    for (int k = 0; k < SYMBOLS; k++) {
        double v = random_unit(r);
        num_ball_set_d(b, b->st->node[pool[k]].a, v);
        num_ball_set_d(whole, b->st->node[pool[k]].a, v);
    }
}

/* Whether what has a value since the last round is what is below one of the questions. */
static bool no_more(const struct num_ball *b, const expr_id *question, struct expr_cone *cone)
{
    int known = 0;
    for (int e = 0; e < b->st->nodes; e++)
        known += (size_t)e / 64 < b->used_cap && b->asked[e] == b->round;
    expr_cone_of(b->st, cone, question, QUESTIONS);
    return known == cone->count;
}

int main(void)
{
    struct random_source r = { check_seed(20261130) };
    struct expr_store st;
    struct num_ball b, whole;
    struct expr_cone cone;
    expr_store_init(&st);
    expr_cone_init(&cone);
    int n = build(&r, &st);
    num_ball_init(&b, &st, 80);
    num_ball_init(&whole, &st, 80);
    for (int round = 0; round < ROUNDS; round++) {
        expr_id question[QUESTIONS];
        place(&r, &b, &whole);
        num_ball_extend(&whole);
        for (int k = 0; k < QUESTIONS; k++) {
            expr_id e = question[k] = pool[random_below(&r, n)];
            num_ball_ask(&b, e);
            CHECK(arb_equal(num_ball_value(&b, e), num_ball_value(&whole, e)) || !arb_is_finite(num_ball_value(&whole, e)), "round %d, node %d", round, (int)e);
        }
        CHECK(no_more(&b, question, &cone), "round %d: more was evaluated than was asked for", round);
    }
    num_ball_extend(&b);          /* all others, beside what was asked for */
    for (int k = 0; k < n; k++)
        CHECK(arb_equal(num_ball_value(&b, pool[k]), num_ball_value(&whole, pool[k])) || !arb_is_finite(num_ball_value(&whole, pool[k])), "node %d", (int)pool[k]);
    num_ball_clear(&b);
    num_ball_clear(&whole);
    expr_cone_clear(&cone);
    expr_store_clear(&st);
    return CHECK_END();
}
