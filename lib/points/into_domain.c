/* A random start lies outside of the domain of roots and logarithms half of the time for each
 * of them, so that starts are not drawn again as a whole: node by node, from the leaves up, the
 * variables of one without a value are. */
#include "into_domain.h"

#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "budget.h"
#include "mem.h"
#include "points_random.h"
#include "points_space.h"

enum { PASSES = 16, TRIES = 40, WORK = 60, LEAST_WORK = 5000 };

struct domain {
    const struct points_space *s;
    struct points_point *p;
    double box;
    uint64_t *random;
    int *column;                  /* by symbol: variable or -1 */
    struct expr_cone all, part, inner;
    double work;                  /* nodes that may still be evaluated */
};

/* The first node of the list without a value: its operands have one. */
static int missing(struct num_ball *b, const struct expr_cone *c)
{
    for (int k = 0; k < c->count; k++)
        if (!arb_is_finite(num_ball_value(b, c->list[k])))
            return k;
    return -1;
}

/* Variables of the node take new values; false where it has none. */
static bool draw_again(struct domain *d, expr_id node, int attempt)
{
    const struct points_space *s = d->s;
    bool any = false;
    expr_cone_of(s->st, &d->inner, &node, 1);
    for (int k = 0; k < d->inner.count; k++) {
        const struct expr_node *n = s->st->node + d->inner.list[k];
        int v = n->op == EXPR_SYM ? d->column[n->a] : -1;
        if (v < 0)
            continue;
        any = true;
        if (attempt & 1 && points_random(d->random) & 1)
            continue;             /* some of them only: others may stand well where they are */
        double u = 2 * points_uniform(d->random) - 1, size = d->p->scaled && s->scale ? ldexp(1, s->scale[v]) : 1;
        int wide = attempt / 4 + 1;
        if (s->near)              /* nearer and nearer to the guess */
            d->p->x[v] = points_short(s->near[v] + ldexp(fmax(d->box, 0.01), -attempt) * (size + 0.02 * fabs(s->near[v])) * u);
        else                      /* smaller, and in the end larger */
            d->p->x[v] = points_short(1.5 * size * u * ldexp(1, (int)(points_random(d->random) % (unsigned)(2 * wide)) - wide));
        num_ball_set_d(&d->p->ball, s->variable[v], d->p->x[v]);
    }
    return any;
}

/* The node gets a value, if new values of variables can give one. */
static void mend(struct domain *d, expr_id node)
{
    expr_cone_of(d->s->st, &d->part, &node, 1);
    for (int attempt = 0; attempt < TRIES && d->work > 0; attempt++) {
        d->work -= d->part.count;
        num_ball_list(&d->p->ball, d->part.list, d->part.count);
        int k = missing(&d->p->ball, &d->part);
        if (k >= 0 && d->s->st->node[d->part.list[k]].op == EXPR_SYM)
            d->work = 0;          /* a coordinate out of range: no start to be mended */
        else if (k < 0 || !draw_again(d, d->part.list[k], attempt))
            return;
    }
}

static void begin(struct domain *d)
{
    const struct points_space *s = d->s;
    SGA_FREED expr_id *root = sga_malloc((size_t)(s->constraints + s->defineds + 1) * sizeof *root);
    int roots = 0;
    for (int i = 0; i < s->constraints; i++)
        root[roots++] = s->constraint[i];
    for (int i = 0; i < s->defineds; i++)
        root[roots++] = s->defined[i];
    expr_cone_init(&d->all);
    expr_cone_init(&d->part);
    expr_cone_init(&d->inner);
    expr_cone_of(s->st, &d->all, root, roots);
    d->work = LEAST_WORK + (double)WORK * d->all.count;
    d->column = sga_malloc((size_t)(s->st->symbols + 1) * sizeof *d->column);
    for (int i = 0; i < s->st->symbols; i++)
        d->column[i] = -1;
    for (int i = 0; i < s->variables; i++)
        d->column[s->variable[i]] = i;
}

bool points_into_domain(const struct points_space *s, double box, uint64_t *random, struct points_point *p)
{
    struct domain d = { .s = s, .p = p, .box = box, .random = random };
    bool clean = false;
    begin(&d);
    for (int pass = 0; pass < PASSES && !clean && d.work > 0 && sga_budget_ok(s->budget, NULL); pass++) {
        num_ball_list(&p->ball, d.all.list, d.all.count);
        clean = missing(&p->ball, &d.all) < 0;
        for (int i = 0; i < d.all.count && !clean && d.work > 0; i++)
            if (!arb_is_finite(num_ball_value(&p->ball, d.all.list[i])))
                mend(&d, d.all.list[i]);
    }
    num_ball_forget(&p->ball);
    expr_cone_clear(&d.all);
    expr_cone_clear(&d.part);
    expr_cone_clear(&d.inner);
    free(d.column);
    return clean;
}

bool points_in_domain(const struct points_space *s, struct points_point *p)
{
    bool in = true;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    if (s->defineds) {
        expr_cone_of(s->st, &cone, s->defined, s->defineds);
        num_ball_list(&p->ball, cone.list, cone.count);
        for (int i = 0; i < s->defineds && in; i++)
            in = arb_is_finite(num_ball_value(&p->ball, s->defined[i]));
        num_ball_forget(&p->ball);
    }
    return in;
}
