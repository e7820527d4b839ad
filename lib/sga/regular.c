/* Regular forms of constraints, by shape and by factors. */
#include "regular.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "poly.h"

static unsigned facts(struct state *s, expr_id e)
{
    return expr_facts_of(&s->facts, s->st, e);
}

/* What can be taken off without changing the real zeros: signs, powers, roots, absolute
 * values, odd monotone functions, factors and denominators that never vanish. */
static expr_id strip(struct state *s, expr_id e)
{
    for (;;) {
        const struct expr_node n = s->st->node[e];
        switch ((enum expr_op)n.op) {
        case EXPR_NEG: case EXPR_SQRT: case EXPR_CBRT: case EXPR_ABS: case EXPR_SIGN:
        case EXPR_SINH: case EXPR_TANH: case EXPR_ASIN: case EXPR_ATAN: case EXPR_ASINH: case EXPR_ATANH:
        case EXPR_DIV:
            e = n.a;
            break;
        case EXPR_POWI:
            if (n.b < 0)
                return e;
            e = n.a;
            break;
        case EXPR_POW:      /* 0 to a positive power is 0 */
            if (!expr_is_const(s->st, n.b) || fmpq_sgn(expr_const_value(s->st, n.b)) <= 0)
                return e;
            e = n.a;
            break;
        case EXPR_MUL:
            if (facts(s, n.a) & EXPR_NONZERO)
                e = n.b;
            else if (facts(s, n.b) & EXPR_NONZERO)
                e = n.a;
            else
                return e;
            break;
        default:
            return e;
        }
    }
}

static bool depends(struct state *s, expr_id e, int symbol)
{
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count; k++)
        if (s->cone.list[k] == s->st->symbol[symbol].node)
            return true;
    return false;
}

enum graph { NOT_GRAPH, GRAPH, PLAIN_GRAPH };

/* e = a x_j + b with a never zero and free of x_j: the zero set is a graph, so it is
 * regular and of one piece. Plain: a is free of all variables, so it hides no factor. */
static enum graph graph_of(struct state *s, expr_id e)
{
    SGA_RESERVE(s->active, s->active_cap, s->st->symbols);
    memset(s->active, 0, (size_t)s->st->symbols);
    for (int j = 0; j < s->sys->variables; j++)
        s->active[s->variable[j]] = 1;
    struct expr_term *term = NULL;
    size_t cap = 0;
    int n = expr_gradient(s->st, &s->cone, e, s->active, &term, &cap);
    enum graph graph = NOT_GRAPH;
    for (int k = 0; k < n && graph != PLAIN_GRAPH; k++) {
        unsigned f = facts(s, term[k].value);
        if (!(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
            graph = PLAIN_GRAPH;
        else if (f & EXPR_NONZERO && !depends(s, term[k].value, term[k].symbol))
            graph = GRAPH;
    }
    free(term);
    return graph;
}

/* |f| at the guess, or infinity without one. */
static double value_near(struct state *s, expr_id f)
{
    if (!s->options->near)
        return INFINITY;
    struct num_ball b;
    num_ball_init(&b, s->st, 64);
    for (int i = 0; i < s->sys->parameters; i++)
        num_ball_set_d(&b, s->parameter_symbol[i], 1.25);
    for (int j = 0; j < s->sys->variables; j++)
        num_ball_set_d(&b, s->variable[j], s->options->near[j]);
    num_ball_set_d(&b, s->sys->time, s->options->near_time);
    expr_cone_of(s->st, &s->cone, &f, 1);
    num_ball_list(&b, s->cone.list, s->cone.count);
    double v = fabs(arf_get_d(arb_midref(num_ball_value(&b, f)), ARF_RND_NEAR));
    num_ball_clear(&b);
    return isfinite(v) ? v : INFINITY;
}

static void add_option(struct regular *r, const expr_id *out, int count)
{
    r->option = sga_realloc(r->option, (size_t)(r->options + 1) * sizeof *r->option);
    struct regular_option *o = r->option + r->options++;
    o->count = count;
    o->out = memcpy(sga_malloc((size_t)count * sizeof *out), out, (size_t)count * sizeof *out);
}

/* A factor matters if it depends on variables or time, may vanish, and does not keep one
 * value, not zero, all over the present set. */
static bool matters(struct state *s, const struct poly_factor *q, int factors)
{
    if (q->never_zero || !(q->depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
        return false;
    for (int k = 0; k < q->radicals; k++)      /* it would need a relation between parameters */
        if (!(facts(s, q->radical[k]) & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
            return false;
    if (factors == 1 || !s->sol->constraints)
        return true;
    return ech_zero(&s->ctx, q->expr) != 0 || !state_locally_constant(s, q->expr);
}

/* A factor in parameters only is taken as not zero, and that is remembered. */
static void assume(struct state *s, expr_id factor)
{
    for (int i = 0; i < s->assumptions; i++)
        if (s->assumed[i] == factor)
            return;
    SGA_RESERVE(s->assumed, s->assumed_cap, s->assumptions + 1);
    s->assumed[s->assumptions++] = factor;
}

/* cos u = 1 and its like hold where the cosine is at an end of its range, so the
 * differential vanishes with them: a function of half the angle has the same zeros and is
 * regular. Otherwise e itself. */
static expr_id at_extreme(struct state *s, expr_id e)
{
    struct expr_store *st = s->st;
    struct expr_node n = st->node[e];
    if (n.op != EXPR_ADD && n.op != EXPR_SUB)
        return e;
    bool first = expr_is_const(st, n.a);
    expr_id k = first ? n.a : n.b, f = first ? n.b : n.a;
    bool one = expr_is_one(st, k), minus = expr_is_int(st, k, -1);
    if (!one && !minus)
        return e;
    bool top = one == (n.op == EXPR_SUB);          /* f = 1, or f = -1 */
    expr_id half = EXPR_UNDEF, u = st->node[f].a;
    enum expr_op op = expr_op_of(st, f);
    if (op == EXPR_COS || op == EXPR_SIN)
        half = expr_mul(st, expr_rational(st, 1, 2), u);
    if (op == EXPR_COS)
        return expr_fun(st, top ? EXPR_SIN : EXPR_COS, half);
    if (op == EXPR_SIN) {
        expr_id shift = expr_mul(st, expr_rational(st, top ? -1 : 1, 4), expr_pi(st));
        return expr_fun(st, EXPR_SIN, expr_add(st, half, shift));
    }
    return op == EXPR_COSH && top ? u : e;
}

static struct regular from_shape(struct state *s, expr_id e, bool alone);

static void move_options(struct regular *to, struct regular *from)
{
    for (int k = 0; k < from->options; k++)
        add_option(to, from->option[k].out, from->option[k].count);
    regular_clear(from);
}

/* The factors that matter are the branches. */
static void from_factors(struct state *s, expr_id e, struct regular *r, const struct poly_factors *f)
{
    bool plain = true;       /* one simple factor, nothing else dropped */
    for (int i = 0; i < f->factors; i++) {
        const struct poly_factor *q = f->factor + i;
        bool in = matters(s, q, f->factors);
        plain &= in && q->multiplicity == 1;
        if (!q->never_zero && q->depends == EXPR_HAS_PARAMETER)
            assume(s, q->expr);
        if (!in)
            continue;
        if (q->sum_of_even_powers && q->radicals > 0) {
            plain = false;
            add_option(r, q->radical, q->radicals);
            struct regular_option *o = r->option + r->options - 1;
            for (int k = 0; k < o->count; k++)
                o->out[k] = strip(s, o->out[k]);
            continue;
        }
        expr_id better = at_extreme(s, q->expr), inner = strip(s, better);
        plain = plain && inner == q->expr;
        if (inner == better) {
            add_option(r, &better, 1);
        } else {              /* abs(u), sqrt(u), ... vanish with u, which may be a product */
            struct regular sub = from_shape(s, inner, true);
            move_options(r, &sub);
        }
    }
    r->answer = !r->options ? REGULAR_NEVER : REGULAR_REPLACED;
    if (r->options == 1 && plain) {
        r->answer = REGULAR_KEEP;
        r->option[0].out[0] = e;
    }
}

/* Nearest to the guess first. */
static void sort_options(struct state *s, struct regular *r)
{
    for (int i = 1; i < r->options; i++)
        for (int k = i; k > 0 && value_near(s, r->option[k].out[0]) < value_near(s, r->option[k - 1].out[0]); k--) {
            struct regular_option o = r->option[k];
            r->option[k] = r->option[k - 1];
            r->option[k - 1] = o;
        }
}

/* Begin with the branch that the route takes; those before it come last. */
static void follow_route(struct state *s, expr_id product, struct regular *r)
{
    struct route *w = s->route;
    int i = 0, first;
    while (i < w->count && w->at[i].product != product)
        i++;
    if (i == w->count) {
        SGA_RESERVE(w->at, w->cap, w->count + 1);
        w->at[w->count++] = (struct decision){ product, r->options, 0 };
    }
    first = w->at[i].chosen < r->options ? w->at[i].chosen : 0;
    for (; first > 0; first--) {
        struct regular_option o = r->option[0];
        memmove(r->option, r->option + 1, (size_t)(r->options - 1) * sizeof o);
        r->option[r->options - 1] = o;
    }
}

static const struct poly_limits small = { .max_terms = 400, .max_bits = 4000, .max_degree = 60, .max_generators = 24 };

/* What a product, power, quotient or odd function is made of, by its shape alone: the parts
 * that may vanish, each once. Returns how many, at most `most`. */
static int shape_factors(struct state *s, expr_id e, expr_id *part, int most)
{
    expr_id stack[64];
    int depth = 0, count = 0;
    stack[depth++] = e;
    while (depth) {
        const expr_id top = stack[--depth];
        const struct expr_node n = s->st->node[top];
        if (facts(s, top) & EXPR_NONZERO)
            continue;
        if (n.op == EXPR_MUL && depth + 2 <= 64) {
            stack[depth++] = n.b;
            stack[depth++] = n.a;
            continue;
        }
        expr_id inner = strip(s, top);
        if (inner != top && depth < 64) {
            stack[depth++] = inner;
            continue;
        }
        bool known = false;
        for (int i = 0; i < count; i++)
            known |= part[i] == top;
        if (!known && count < most)
            part[count++] = top;
    }
    return count;
}

/* Part by part: what is too large to factor as a whole, or (alone) what stood inside a
 * function that vanishes with it. */
static struct regular from_shape(struct state *s, expr_id e, bool alone)
{
    enum { PARTS = 24 };
    struct regular r = { .answer = REGULAR_REPLACED };
    expr_id part[PARTS];
    int parts = shape_factors(s, e, part, PARTS);
    for (int i = 0; i < parts; i++) {
        struct poly_limits limits = small;
        struct poly_factors f;
        limits.budget = s->options->budget;
        if ((parts > 1 || alone) && poly_numerator_factors(s->st, part[i], &limits, &f)) {
            struct regular q = { .answer = REGULAR_KEEP };
            from_factors(s, part[i], &q, &f);
            poly_factors_clear(&f);
            move_options(&r, &q);
        } else {
            add_option(&r, part + i, 1);
        }
    }
    if (!r.options)
        r.answer = REGULAR_NEVER;
    else if (r.options == 1 && r.option[0].count == 1 && r.option[0].out[0] == e)
        r.answer = REGULAR_KEEP;
    return r;
}

static struct regular form_of(struct state *s, expr_id e)
{
    struct regular r = { .answer = REGULAR_KEEP };
    if (facts(s, e) & EXPR_NONZERO) {
        r.answer = REGULAR_NEVER;
        return r;
    }
    enum graph graph = graph_of(s, e);
    if (graph == PLAIN_GRAPH) {
        add_option(&r, &e, 1);
        return r;
    }
    struct poly_limits limits = small;
    struct poly_factors f;
    limits.budget = s->options->budget;
    if (poly_numerator_factors(s->st, e, &limits, &f)) {
        from_factors(s, e, &r, &f);
        poly_factors_clear(&f);
    } else if (graph == GRAPH) {
        add_option(&r, &e, 1);
    } else {
        r = from_shape(s, e, false);
        s->sol->not_factored = true;
    }
    sort_options(s, &r);
    if (r.options > 1)
        follow_route(s, e, &r);
    return r;
}

/* Whether e divides by something that may vanish. */
static bool has_poles(struct state *s, expr_id e)
{
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count; k++) {
        const struct expr_node n = s->st->node[s->cone.list[k]];
        expr_id below = n.op == EXPR_DIV ? n.b : n.op == EXPR_POWI && n.b < 0 ? n.a : EXPR_UNDEF;
        if (below && !(facts(s, below) & EXPR_NONZERO))
            return true;
    }
    return false;
}

/* e = a x_j + b, a never zero, where no earlier constraint contains x_j: over each point
 * of the present set e has exactly one zero, so it brings no branches and no singular
 * points of its own. */
static bool fresh_graph(struct state *s, expr_id e)
{
    struct expr_term *term = NULL;
    size_t cap = 0;
    SGA_RESERVE(s->active, s->active_cap, s->st->symbols);
    memset(s->active, 0, (size_t)s->st->symbols);
    for (int j = 0; j < s->sys->variables; j++)
        s->active[s->variable[j]] = 1;
    for (int pass = 0; pass < 2; pass++) {
        int count = pass ? s->pendings : s->sol->constraints;
        if (!count)
            continue;
        expr_cone_of(s->st, &s->cone, pass ? s->pending : s->con, count);
        for (int k = 0; k < s->cone.count; k++) {
            const struct expr_node *n = s->st->node + s->cone.list[k];
            if (n->op == EXPR_SYM)
                s->active[n->a] = 0;
        }
    }
    int n = expr_gradient(s->st, &s->cone, e, s->active, &term, &cap);
    bool fresh = false;
    for (int k = 0; k < n && !fresh; k++) {
        unsigned f = facts(s, term[k].value);
        bool plain = !(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME));
        fresh = plain || (f & EXPR_NONZERO && !depends(s, term[k].value, term[k].symbol));
    }
    free(term);
    return fresh;
}

/* A function may be a product, or irregular, on the present set only. */
struct regular regular_form(struct state *s, expr_id e)
{
    struct regular r = form_of(s, e);
    int c = s->sol->constraints + s->pendings;
    s->sol->not_factored |= c > REGULAR_REDUCE;
    if (r.answer != REGULAR_KEEP || c == 0 || c > REGULAR_REDUCE || fresh_graph(s, e)
        || regular_all_affine(s, e))
        return r;
    expr_id reduced = regular_reduced(s, e);
    if (reduced == e || expr_is_zero(s->st, reduced))
        return r;
    struct regular q = form_of(s, reduced);
    if (q.answer == REGULAR_KEEP && has_poles(s, e) && !has_poles(s, reduced))
        q.answer = REGULAR_REPLACED;
    struct regular *drop = q.answer == REGULAR_KEEP ? &q : &r;
    struct regular take = q.answer == REGULAR_KEEP ? r : q;
    regular_clear(drop);
    return take;
}

void regular_clear(struct regular *r)
{
    for (int i = 0; i < r->options; i++)
        free(r->option[i].out);
    free(r->option);
    *r = (struct regular){ 0 };
}
