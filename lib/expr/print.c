/* The printer: an explicit stack of things still to be written, so that depth costs
 * memory and never the C stack. */
#include "print.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "flint_ends.h"
#include "mem.h"
#include "print_text.h"

/* What the place where a node stands asks of it, and what a node gives: a node whose
 * level is lower than its place needs parentheses. */
enum level { SUM, TERM, FACTOR, PRIMARY };

struct item {
    const char *text;      /* written as it is, or NULL */
    char *own;             /* as text, freed after */
    expr_id e;
    enum level place;
};

struct term {
    expr_id e;
    bool negative;
    long variables, all;   /* degrees */
    size_t position;
};

struct printer {
    const struct print_request *req;
    expr_id top;
    struct item *item; size_t item_cap, items;
    struct term *term; size_t term_cap, terms;
    struct item *sum; size_t sum_cap;       /* work: parts of a sum; text is non-NULL for a flipped sign */
    struct print_product product;
    struct sga_buf *out;
};

static bool named(const struct printer *p, expr_id e)
{
    return p->req->name && p->req->name[e] && e != p->top;
}

static enum level level_of(const struct printer *p, expr_id e)
{
    const struct expr_store *st = p->req->st;
    if (named(p, e))
        return PRIMARY;
    switch (expr_op_of(st, e)) {
    case EXPR_CONST: {
        const fmpq *q = expr_const_value(st, e);
        if (fmpq_sgn(q) < 0)
            return SUM;
        return fmpz_is_one(fmpq_denref(q)) ? PRIMARY : TERM;
    }
    case EXPR_ADD: case EXPR_SUB: case EXPR_NEG: return SUM;
    case EXPR_MUL: case EXPR_DIV: return TERM;
    case EXPR_POWI: return st->node[e].b < 0 ? TERM : FACTOR;
    case EXPR_POW:  return FACTOR;
    default:        return PRIMARY;
    }
}

static size_t room(const struct printer *p)
{
    return p->req->limit > p->out->len ? p->req->limit - p->out->len : 0;
}

static void push(struct printer *p, struct item it)
{
    SGA_RESERVE(p->item, p->item_cap, p->items + 1);
    p->item[p->items++] = it;
}

static void push_text(struct printer *p, const char *s) { push(p, (struct item){ .text = s }); }
static void push_node(struct printer *p, expr_id e, enum level place) { push(p, (struct item){ .e = e, .place = place }); }

static void push_integer(struct printer *p, const fmpz_t z)
{
    char *digits = fmpz_get_str(NULL, 10, z), *s = sga_strdup(digits);
    flint_free(digits);
    push(p, (struct item){ .own = s });
}

static void push_exponent(struct printer *p, int n)
{
    SGA_ENDS(fmpz_end) fmpz_t z;
    fmpz_init_set_si(z, n);
    push_integer(p, z);
    push_text(p, "^");
}

static void push_factor(struct printer *p, const struct print_factor *f)
{
    if (f->power > 1) {
        push_exponent(p, f->power);
        push_node(p, f->e, PRIMARY);
    } else {
        push_node(p, f->e, FACTOR);
    }
}

/* The factors of one side of the line, number first, joined by '*'. The stack is last in
 * first out, so everything is pushed from the end. */
static int push_side(struct printer *p, bool below, const fmpz_t number, bool show_number)
{
    int count = 0;
    for (int i = p->product.count - 1; i >= 0; i--) {
        if (p->product.factor[i].below != below)
            continue;
        if (count++)
            push_text(p, "*");
        push_factor(p, p->product.factor + i);
    }
    if (show_number) {
        if (count++)
            push_text(p, "*");
        push_integer(p, number);
    }
    return count;
}

/* The product of e without its sign. */
static bool emit_product(struct printer *p, expr_id e)
{
    struct print_product *f = &p->product;
    if (!print_product_of(f, p->req, p->top, e, room(p)))
        return false;
    print_product_sort(f, p->req->st);
    const fmpz *num = fmpq_numref(f->coefficient), *den = fmpq_denref(f->coefficient);
    int above = 0, below = !fmpz_is_one(den);
    for (int i = 0; i < f->count; i++)
        *(f->factor[i].below ? &below : &above) += 1;
    if (below > 0) {
        if (below > 1)
            push_text(p, ")");
        push_side(p, true, den, !fmpz_is_one(den));
        push_text(p, below > 1 ? "/(" : "/");
    }
    push_side(p, false, num, above == 0 || !fmpz_is_one(num));
    return true;
}

static int by_degree(const void *x, const void *y)
{
    const struct term *a = x, *b = y;
    if (a->variables != b->variables)
        return a->variables > b->variables ? -1 : 1;
    if (a->all != b->all)
        return a->all > b->all ? -1 : 1;
    return a->position < b->position ? -1 : 1;
}

/* The terms of e, flattened through sums and signs. */
static bool collect_terms(struct printer *p, expr_id e)
{
    const struct expr_store *st = p->req->st;
    p->terms = 0;
    SGA_RESERVE(p->sum, p->sum_cap, 2);
    p->sum[0] = (struct item){ .e = e };
    for (size_t n = 1; n > 0;) {
        struct item it = p->sum[--n];
        struct expr_node node = st->node[it.e];
        bool apart = !named(p, it.e);
        const char *flipped = it.text ? NULL : "-";
        SGA_RESERVE(p->sum, p->sum_cap, n + 2);
        if (apart && (node.op == EXPR_ADD || node.op == EXPR_SUB)) {
            p->sum[n++] = (struct item){ .e = node.b, .text = node.op == EXPR_SUB ? flipped : it.text };
            p->sum[n++] = (struct item){ .e = node.a, .text = it.text };
        } else if (apart && node.op == EXPR_NEG) {
            p->sum[n++] = (struct item){ .e = node.a, .text = flipped };
        } else {
            if (!print_product_of(&p->product, p->req, p->top, it.e, room(p)))
                return false;
            struct term t = { .e = it.e, .negative = p->product.negative != (it.text != NULL), .position = p->terms };
            print_product_degrees(&p->product, st, &t.variables, &t.all);
            SGA_RESERVE(p->term, p->term_cap, p->terms + 1);
            p->term[p->terms++] = t;
        }
        if (n + p->terms > room(p))
            return false;
    }
    return true;
}

static bool emit_sum(struct printer *p, expr_id e)
{
    if (!collect_terms(p, e))
        return false;
    qsort(p->term, p->terms, sizeof *p->term, by_degree);
    size_t first = 0;
    while (first < p->terms && p->term[first].negative)
        first++;
    if (first < p->terms) {     /* a positive term leads */
        struct term t = p->term[first];
        memmove(p->term + 1, p->term, first * sizeof t);
        p->term[0] = t;
    }
    for (size_t i = p->terms; i-- > 0;) {
        push_node(p, p->term[i].e, TERM);
        if (i)
            push_text(p, p->term[i].negative ? " - " : " + ");
        else if (p->term[i].negative)
            push_text(p, "-");
    }
    return true;
}

static bool emit_primary(struct printer *p, expr_id e)
{
    const struct expr_store *st = p->req->st;
    const struct expr_node n = st->node[e];
    switch ((enum expr_op)n.op) {
    case EXPR_UNDEF_OP: case EXPR_SOLVE:
        return false;
    case EXPR_CONST:
        push_integer(p, fmpq_numref(st->constant + n.a));
        return true;
    case EXPR_PI:
        push_text(p, expr_op_text(EXPR_PI));
        return true;
    case EXPR_SYM:
        push_text(p, st->symbol[n.a].name);
        return true;
    case EXPR_POWI:
        push_exponent(p, n.b);
        push_node(p, n.a, PRIMARY);
        return true;
    case EXPR_POW:
        push_node(p, n.b, PRIMARY);
        push_text(p, "^");
        push_node(p, n.a, PRIMARY);
        return true;
    default:
        push_text(p, ")");
        if (expr_op_args((enum expr_op)n.op) == 2) {
            push_node(p, n.b, SUM);
            push_text(p, ", ");
        }
        push_node(p, n.a, SUM);
        push_text(p, "(");
        push_text(p, expr_op_text((enum expr_op)n.op));
        return true;
    }
}

static bool emit_node(struct printer *p, expr_id e, enum level place)
{
    enum level level = level_of(p, e);
    if (named(p, e)) {
        push_text(p, p->req->name[e]);
        return true;
    }
    if (place == TERM && level != PRIMARY)    /* its sign is written already */
        return emit_product(p, e);
    if (level < place) {
        push_text(p, ")");
        push_node(p, e, SUM);
        push_text(p, "(");
        return true;
    }
    return level <= TERM ? emit_sum(p, e) : emit_primary(p, e);
}

bool print_tree(const struct print_request *r, expr_id e, struct sga_buf *out)
{
    struct printer p = { .req = r, .top = e, .out = out };
    print_product_init(&p.product);
    push_node(&p, e, SUM);
    bool ok = true;
    while (ok && p.items > 0) {
        struct item it = p.item[--p.items];
        const char *text = it.own ? it.own : it.text;
        if (text) {
            size_t n = strlen(text);
            ok = n <= room(&p);
            if (ok)
                sga_buf_put(out, text, n);
        } else {
            ok = p.items <= room(&p) + 16 && emit_node(&p, it.e, it.place);
        }
        free(it.own);
    }
    while (p.items > 0)
        free(p.item[--p.items].own);
    print_product_clear(&p.product);
    free(p.item);
    free(p.term);
    free(p.sum);
    return ok;
}

bool expr_print(const struct expr_store *st, expr_id e, size_t max_bytes, struct sga_buf *out)
{
    size_t start = out->len;
    struct print_request r = { .st = st, .limit = start + (max_bytes ? max_bytes : (size_t)1 << 20) };
    if (print_tree(&r, e, out))
        return true;
    out->len = start;
    if (out->data)
        out->data[start] = 0;
    return false;
}

char *expr_text(const struct expr_store *st, expr_id e, size_t max_bytes)
{
    struct sga_buf text = { 0 };
    if (!e || !expr_print(st, e, max_bytes, &text))
        sga_buf_puts(&text, "(a long expression)");
    return sga_buf_take(&text);
}

bool expr_json(const struct expr_store *st, expr_id e, size_t max_bytes, struct sga_json *w)
{
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
    bool shown = e && expr_print(st, e, max_bytes, &text);
    if (shown)
        sga_json_string(w, text.data);
    else
        sga_json_null(w);
    return shown;
}

void expr_json_list(const struct expr_store *st, const expr_id *e, int count, size_t max_bytes, struct sga_json *w)
{
    sga_json_array(w);
    for (int i = 0; i < count; i++) {
        SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
        if (expr_print(st, e[i], max_bytes, &text))
            sga_json_string(w, text.data);
    }
    sga_json_end_array(w);
}
