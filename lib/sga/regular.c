/* Regular forms of constraints, by shape and by factors. */
#include "regular.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ends.h"
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

double regular_value(struct state *s, expr_id f, const double *x, double t)
{
    struct num_ball b;
    num_ball_init(&b, s->st, 64);
    for (int i = 0; i < s->sys->parameters; i++)
        num_ball_set_d(&b, s->parameter_symbol[i], 1.25);
    for (int j = 0; j < s->sys->variables; j++)
        num_ball_set_d(&b, s->variable[j], x[j]);
    num_ball_set_d(&b, s->sys->time, t);
    expr_cone_of(s->st, &s->cone, &f, 1);
    num_ball_list(&b, s->cone.list, s->cone.count);
    double v = arf_get_d(arb_midref(num_ball_value(&b, f)), ARF_RND_NEAR);
    num_ball_clear(&b);
    return v;
}

/* How far o's functions are from 0 at a place. */
static double option_value(struct state *s, const struct regular_option *o, const double *x, double t)
{
    double far = 0;
    for (int i = 0; i < o->count && isfinite(far); i++) {
        double v = fabs(regular_value(s, o->out[i], x, t));
        far = isfinite(v) ? fmax(far, v) : INFINITY;
    }
    return far;
}

enum { DEPTH = 5 };

static struct regular form_at(struct state *s, expr_id e, int depth);

static bool same_option(const struct regular_option *o, const expr_id *out, int count)
{
    bool same = o->count == count;
    for (int i = 0; i < count && same; i++) {
        bool in = false;
        for (int k = 0; k < count; k++)
            in |= o->out[k] == out[i];
        same = in;
    }
    return same;
}

/* Each option once. */
static void add_option(struct regular *r, const expr_id *out, int count)
{
    for (int i = 0; i < r->options; i++)
        if (same_option(r->option + i, out, count))
            return;
    r->option = sga_realloc(r->option, (size_t)(r->options + 1) * sizeof *r->option);
    struct regular_option *o = r->option + r->options++;
    o->count = count;
    o->out = sga_malloc((size_t)(count + 1) * sizeof *out);
    if (count)
        memcpy(o->out, out, (size_t)count * sizeof *out);
}

/* The functions of both, each once. */
static void add_joined(struct regular *r, const struct regular_option *a, const struct regular_option *b)
{
    int n = 0;
    expr_id *out = sga_malloc((size_t)(a->count + b->count + 1) * sizeof *out);
    for (int i = 0; i < a->count + b->count; i++) {
        expr_id f = i < a->count ? a->out[i] : b->out[i - a->count];
        bool known = false;
        for (int k = 0; k < n; k++)
            known |= out[k] == f;
        if (!known)
            out[n++] = f;
    }
    add_option(r, out, n);
    free(out);
}

/* Functions that vanish together, each in its regular form: the ways in which they can. No
 * option comes out where one of them never vanishes. */
static struct regular together(struct state *s, const expr_id *f, int count, int depth)
{
    enum { WAYS = 16 };
    struct regular all = { .answer = REGULAR_REPLACED };
    add_option(&all, NULL, 0);
    for (int i = 0; i < count && all.options; i++) {
        struct regular own = form_at(s, f[i], depth + 1), next = { .answer = REGULAR_REPLACED };
        if (own.options * all.options > WAYS) {     /* too many: left as it is */
            regular_clear(&own);
            add_option(&own, f + i, 1);
        }
        for (int k = 0; k < all.options; k++)
            for (int m = 0; m < own.options; m++)
                add_joined(&next, all.option + k, own.option + m);
        regular_clear(&all);
        regular_clear(&own);
        all = next;
    }
    return all;
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


static void move_options(struct regular *to, struct regular *from)
{
    for (int k = 0; k < from->options; k++)
        add_option(to, from->option[k].out, from->option[k].count);
    regular_clear(from);
}

/* What f = 0 says of its parts, where that is more than f itself: true, with the options. */
static bool by_ends(struct state *s, expr_id f, int depth, struct regular *r)
{
    struct ends e = ends_of(s, f);
    bool changed = e.changed;
    for (int i = 0; i < e.options; i++)
        changed = changed && e.option[i].count > 0;
    for (int i = 0; i < e.options && changed; i++) {
        struct regular sub = together(s, e.option[i].out, e.option[i].count, depth);
        move_options(r, &sub);
    }
    ends_clear(&e);
    return changed;
}

/* The factors that matter are the branches. */
static void from_factors(struct state *s, expr_id e, struct regular *r, const struct poly_factors *f, int depth)
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
            struct regular sub = together(s, q->radical, q->radicals, depth);
            move_options(r, &sub);
        } else if (depth < DEPTH && by_ends(s, q->expr, depth, r)) {
            plain = false;
        } else {
            add_option(r, &q->expr, 1);
        }
    }
    r->answer = !r->options ? REGULAR_NEVER : REGULAR_REPLACED;
    if (r->options == 1 && plain) {
        r->answer = REGULAR_KEEP;
        r->option[0].out[0] = e;
    }
}

/* The same at the guess; infinity without one. */
static double option_near(struct state *s, const struct regular_option *o)
{
    return s->options->near ? option_value(s, o, s->options->near, s->options->near_time) : INFINITY;
}

/* Nearest to the guess first. */
static void sort_options(struct state *s, struct regular *r)
{
    for (int i = 1; i < r->options; i++)
        for (int k = i; k > 0 && option_near(s, r->option + k) < option_near(s, r->option + k - 1); k--) {
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

/* Part by part: what is too large to factor as a whole. */
static struct regular from_shape(struct state *s, expr_id e)
{
    enum { PARTS = 24 };
    struct regular r = { .answer = REGULAR_REPLACED };
    expr_id part[PARTS];
    int parts = shape_factors(s, e, part, PARTS);
    for (int i = 0; i < parts; i++) {
        struct poly_limits limits = small;
        struct poly_factors f;
        limits.budget = s->options->budget;
        if (parts > 1 && poly_numerator_factors(s->st, part[i], &limits, &f)) {
            struct regular q = { .answer = REGULAR_KEEP };
            from_factors(s, part[i], &q, &f, DEPTH);
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

static struct regular form_at(struct state *s, expr_id e, int depth)
{
    struct regular r = { .answer = REGULAR_KEEP };
    if (facts(s, e) & EXPR_NONZERO) {
        r.answer = REGULAR_NEVER;
        return r;
    }
    enum graph graph = graph_of(s, e);
    if (graph == PLAIN_GRAPH || depth > DEPTH) {
        add_option(&r, &e, 1);
        return r;
    }
    if (by_ends(s, e, depth, &r)) {
        r.answer = r.options ? REGULAR_REPLACED : REGULAR_NEVER;
        return r;
    }
    struct poly_limits limits = small;
    struct poly_factors f;
    limits.budget = s->options->budget;
    if (poly_numerator_factors(s->st, e, &limits, &f)) {
        from_factors(s, e, &r, &f, depth);
        poly_factors_clear(&f);
    } else if (graph == GRAPH) {
        add_option(&r, &e, 1);
    } else {
        r = from_shape(s, e);
        s->sol->not_factored = true;
    }
    return r;
}

static struct regular form_of(struct state *s, expr_id e)
{
    struct regular r = form_at(s, e, 0);
    sort_options(s, &r);
    if (r.options > 1)
        follow_route(s, e, &r);
    return r;
}

struct regular_option regular_nearest(struct state *s, expr_id e, const double *x, double t)
{
    struct regular r = form_at(s, e, 0);
    struct regular_option best = { 0 };
    int at = -1;
    double least = INFINITY;
    for (int k = 0; k < r.options; k++) {
        double v = option_value(s, r.option + k, x, t);
        if (v < least) {
            least = v;
            at = k;
        }
    }
    if (at >= 0) {
        best = r.option[at];
        r.option[at].out = NULL;
    }
    regular_clear(&r);
    return best;
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
