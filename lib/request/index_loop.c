/* Loops over whole numbers: several names, the last runs fastest, bounds may depend on the names before. */
#include <assert.h>
#include <string.h>

#include "buf.h"
#include "error.h"
#include "index_read.h"
#include "lowered.h"
#include "parse.h"

/* A new name of the loop; the token is the name. */
static bool add_name(struct index_reader *r, struct index_loop *l, struct index_dim *d)
{
    const char *name = r->text + r->tok.start;
    char text[LEX_SHOWN], what[160];
    lex_show(r->text, r->tok, text);
    if (r->tok.length > 40 || memchr(name, '[', r->tok.length))
        return index_fail(r, r->tok.start, SGA_E_BAD_NAME, "a loop name is a short plain name, such as i");
    if (index_find(l->scope, name, r->tok.length) >= 0) {
        snprintf(what, sizeof what, "%s is already a loop name or a size; take another name", text);
        return index_fail(r, r->tok.start, SGA_E_DUPLICATE_NAME, what);
    }
    d->name_at = r->tok.start;
    d->name_length = r->tok.length;
    return true;
}

static void bind(struct index_loop *l, const struct index_dim *d)
{
    assert(l->scope->names < INDEX_SIZES + INDEX_LOOPS && l->scope->sizes <= l->scope->names);
    l->scope->name[l->scope->names++] = (struct index_name){ l->text + d->name_at, d->name_length, 0 };
}

/* Finds low:high, or one number where `single`; what they are is worked out pass by pass. */
static bool read_bounds(struct index_reader *r, struct index_dim *d, bool single)
{
    d->low_at = r->tok.start;
    int depth = 0;
    bool colon = false;
    for (; r->tok.kind != LEX_END; index_advance(r)) {
        if (depth == 0 && (r->tok.kind == LEX_COMMA || index_is(r, ']')))
            break;
        if (depth == 0 && index_is(r, ':') && colon)
            return index_fail(r, r->tok.start, SGA_E_EXPR_SYNTAX, "a range is low:high, in steps of 1");
        colon |= depth == 0 && index_is(r, ':');
        depth += (r->tok.kind == LEX_OPEN) - (r->tok.kind == LEX_CLOSE);
    }
    d->range = colon;
    return colon || single || index_fail(r, r->tok.start, SGA_E_EXPR_SYNTAX, "a loop needs its bounds: \"i = 1:3\", and further names behind a comma");
}

static bool full(struct index_reader *r, const struct index_loop *l)
{
    bool much = l->dims == INDEX_LOOPS || l->scope->names == INDEX_SIZES + INDEX_LOOPS;
    return much && !index_fail(r, r->tok.start, SGA_E_SHAPE, "there are more than 8 names in a loop or in loops around each other, or indices of a name");
}

static bool starts_name(const struct index_reader *r)
{
    struct lex_token next = lex_next(r->text, r->tok.start + r->tok.length);
    return r->tok.kind == LEX_NAME && next.kind == LEX_EQUAL && next.length == 1;
}

bool index_loop_read(struct index_loop *l, const char *text, struct index_scope *scope, struct sga_error *err)
{
    struct index_reader r;
    *l = (struct index_loop){ .text = text, .scope = scope };
    index_start(&r, text, 0, scope, err);
    do {
        if (l->dims)
            index_advance(&r);
        if (full(&r, l))
            return false;
        struct index_dim *d = l->dim + l->dims;
        if (!starts_name(&r))
            return index_fail(&r, r.tok.start, SGA_E_EXPR_SYNTAX, "a loop is written \"i = 1:3\", several \"i = 1:3, j = 1:4\"");
        if (!add_name(&r, l, d))
            return false;
        char name[41] = "";
        memcpy(name, text + d->name_at, d->name_length);
        if (expr_reserved(name) || lowered_function(name, d->name_length))
            return index_fail(&r, r.tok.start, SGA_E_BAD_NAME, "a loop name is a name of the grammar; take another");
        index_advance(&r);
        index_advance(&r);
        if (!read_bounds(&r, d, false))
            return false;
        bind(l, d);
        l->dims++;
    } while (r.tok.kind == LEX_COMMA);
    return r.tok.kind == LEX_END || index_fail(&r, r.tok.start, SGA_E_EXPR_SYNTAX, "a loop is written \"i = 1:3\", several \"i = 1:3, j = 1:4\"");
}

bool index_range_read(struct index_loop *l, const char *text, struct index_scope *scope, bool *is, struct sga_error *err)
{
    struct index_reader r;
    *l = (struct index_loop){ .text = text, .scope = scope };
    *is = false;
    index_start(&r, text, 0, scope, err);
    const char *open = strchr(text, '['), *close = strrchr(text, ']');
    if (r.tok.kind != LEX_NAME || !open || !close || close < open || !memchr(open, ':', (size_t)(close - open)))
        return true;
    l->base = r.tok.length;
    index_advance(&r);
    size_t inside = strspn(close + 1, "' \t\r\n");
    if (!index_is(&r, '[') || r.tok.start != (size_t)(open - text) || close[1 + inside] || memchr(open + 1, '[', (size_t)(close - open) - 1))
        return true;                                  /* an expression: index_write refuses the range in it */
    *is = true;
    do {
        index_advance(&r);
        if (full(&r, l))
            return false;
        struct index_dim *d = l->dim + l->dims;
        if (starts_name(&r)) {
            if (!add_name(&r, l, d))
                return false;
            index_advance(&r);
            index_advance(&r);
        }
        if (!read_bounds(&r, d, true))
            return false;
        bind(l, d);
        l->dims++;
    } while (r.tok.kind == LEX_COMMA);
    if (!index_is(&r, ']'))
        return index_fail(&r, r.tok.start, SGA_E_EXPR_SYNTAX, "a ] is missing behind an index");
    l->quotes_at = r.tok.start + 1;
    return true;
}

/* The last names of the scope are those of the loop. */
static bool own_names(const struct index_loop *l)
{
    const struct index_scope *s = l->scope;
    bool own = s->names - l->dims >= s->sizes;
    for (int k = 0; k < l->dims && own; k++)
        own = s->name[s->names - l->dims + k].text == l->text + l->dim[k].name_at;
    return own;
}

/* The bounds of a name, given the values of those before. */
static bool enter(struct index_loop *l, int k, struct sga_error *err)
{
    struct index_dim *d = l->dim + k;
    struct index_scope *s = l->scope;
    int names = s->names;
    struct index_reader r;
    assert(k >= 0 && k < l->dims && own_names(l));
    s->names = names - l->dims + k;
    l->known = k;
    index_start(&r, l->text, d->low_at, s, err);
    bool ok = index_expression(&r, 0, &d->low);
    d->high = d->low;
    if (ok && index_is(&r, ':')) {
        index_advance(&r);
        ok = index_expression(&r, 0, &d->high);
    }
    if (ok && r.tok.kind != LEX_COMMA && r.tok.kind != LEX_END && !index_is(&r, ']'))
        ok = index_fail(&r, r.tok.start, SGA_E_EXPR_SYNTAX, "more follows where a bound ends; whole numbers are joined by + - * /");
    if (ok && l->base && d->low < 0)
        ok = index_fail(&r, d->low_at, SGA_E_EXPR_NAME, "an index lies below 0; raise the lower bound");
    if (ok && d->low > d->high && !r.varies) {
        char what[160];
        snprintf(what, sizeof what, "nothing lies in the range %ld:%ld: its first number is larger than its last; leave it out, or turn it around", d->low, d->high);
        ok = index_fail(&r, d->low_at, SGA_E_SHAPE, what);
    }
    s->names = names;
    assert(l->known <= l->dims);
    d->value = d->low <= d->high ? d->low : d->high;
    s->name[names - l->dims + k].value = d->value;
    l->known += ok;
    l->turns++;
    return ok;
}

/* Enters the names from k on; where one has no value, goes on with those before it. */
static bool settle(struct index_loop *l, int k, struct sga_error *err)
{
    for (;;) {
        bool some = true;
        for (; k < l->dims && some; k++) {
            if (!enter(l, k, err))
                return false;
            some = l->dim[k].low <= l->dim[k].high;
        }
        if (some)
            return true;
        for (k--; k >= 0 && l->dim[k].value >= l->dim[k].high; k--)
            ;
        if (k < 0)
            return false;
        l->scope->name[l->scope->names - l->dims + k].value = ++l->dim[k].value;
        if (l->turns > INDEX_MOST / 100)
            return sga_fail(err, SGA_E_LIMIT_VARIABLES, "a loop has too many empty ranges inside");
        k++;
    }
}

bool index_first(struct index_loop *l, struct sga_error *err)
{
    l->turns = 0;
    return settle(l, 0, err);
}

bool index_next(struct index_loop *l, struct sga_error *err)
{
    int k = l->dims - 1;
    while (k >= 0 && l->dim[k].value >= l->dim[k].high)
        k--;
    if (k < 0)
        return false;
    assert(own_names(l));
    l->scope->name[l->scope->names - l->dims + k].value = ++l->dim[k].value;
    return settle(l, k + 1, err);
}

bool index_count(struct index_loop *l, long most, long *out, struct sga_error *err)
{
    long n = 0;
    for (bool more = index_first(l, err); more; more = index_next(l, err)) {
        struct index_dim *last = l->dim + l->dims - 1;
        n += last->high - last->value + 1;            /* at most INDEX_MOST + 1 more than `most` */
        last->value = last->high;
        if (n > most)
            return sga_fail(err, SGA_E_LIMIT_VARIABLES, "written out, this is more than the %ld elements that are left of those that all ranges and loops of a request may make", most);
    }
    if (!n)
        sga_fail(err, SGA_E_SHAPE, "the loop has no pass: its ranges are all empty");
    assert(n <= most);
    *out = n;
    return err->code == SGA_E_OK;
}

void index_end(struct index_loop *l)
{
    l->scope->names = l->scope->sizes;
}

void index_put_name(const struct index_loop *l, struct sga_buf *out)
{
    size_t start = lex_next(l->text, 0).start;
    sga_buf_put(out, l->text + start, l->base);
    for (int k = 0; k < l->dims; k++)
        sga_buf_printf(out, "%s%ld", k ? "," : "[", l->dim[k].value);
    sga_buf_puts(out, "]");
    for (const char *s = l->text + l->quotes_at; *s; s++)
        if (*s == '\'')
            sga_buf_puts(out, "'");
}

void index_put_pass(const struct index_loop *l, struct sga_buf *out)
{
    const char *comma = "";
    for (int k = 0; k < l->known; k++)
        if (l->dim[k].name_length) {
            sga_buf_printf(out, "%s%.*s = %ld", comma, (int)l->dim[k].name_length, l->text + l->dim[k].name_at, l->dim[k].value);
            comma = ", ";
        }
    if (!*comma && l->base && l->known == l->dims)
        index_put_name(l, out);
}
