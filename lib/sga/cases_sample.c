/* A point of a part of the parameters, with a proof: exact rationals, and enclosures of roots. */
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "buf.h"
#include "cases.h"
#include "cases_solve.h"
#include "flint_ends.h"
#include "mem.h"
#include "print.h"
#include "system.h"

enum { TRIES = 60, BITS = 192, DIGITS = 20, GRID = 64, HALVINGS = 80 };

/* Small rationals, so that a reader can check what is claimed: 2, 3, 5, 1/2, ... */
static expr_id draw(struct expr_store *st, int parameter, int attempt)
{
    static const signed char p[] = { 2, 3, 5, 7, 1, 3, 11, -2, -3, 5, -1, 13, 4, -5, 9 };
    static const signed char q[] = { 1, 1, 1, 1, 2, 2, 1, 1, 1, 3, 3, 1, 5, 2, 1 };
    int n = (int)(sizeof p), k = (parameter + attempt * (1 + parameter) + attempt / n) % n;
    return expr_rational(st, p[k], q[k]);
}

/* Values of a number; false: it has none. */
static bool number(const struct cases_space *s, expr_id e, arb_t v)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone = { 0 };
    bool ok = e != EXPR_UNDEF;
    if (!ok)
        return false;
    expr_cone_init(&cone);
    expr_cone_of(s->st, &cone, &e, 1);
    for (int i = 0; i < cone.count; i++)
        ok = ok && expr_op_of(s->st, cone.list[i]) != EXPR_SYM;
    if (ok) {
        SGA_ENDS(num_ball_clear) struct num_ball b;
        num_ball_init(&b, s->st, BITS);
        num_ball_list(&b, cone.list, cone.count);
        arb_set(v, num_ball_value(&b, e));
        ok = arb_is_finite(v);
    }
    return ok;
}

static int sign_at(const struct cases_space *s, expr_id e)
{
    SGA_ENDS(arb_end) arb_t v = { 0 };
    return !number(s, e, v) ? 0 : arb_is_positive(v) ? 1 : arb_is_negative(v) ? -1 : 0;
}

/* The bound of v, rounded outward to a decimal. */
static void write_bound(struct sga_json *w, const arb_t v, bool upper)
{
    SGA_ENDS(arb_end) arb_t scaled = { 0 };
    SGA_ENDS(arf_end) arf_t x = { 0 };
    SGA_ENDS(fmpz_end) fmpz_t n = { 0 }, ten;
    fmpz_init_set_ui(ten, 10);
    fmpz_pow_ui(ten, ten, DIGITS);
    arb_mul_fmpz(scaled, v, ten, BITS + 80);
    if (upper)
        arb_get_ubound_arf(x, scaled, BITS + 80);
    else
        arb_get_lbound_arf(x, scaled, BITS + 80);
    arf_get_fmpz(n, x, upper ? ARF_RND_CEIL : ARF_RND_FLOOR);
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
    bool negative = fmpz_sgn(n) < 0;
    fmpz_abs(n, n);
    char *digits = fmpz_get_str(NULL, 10, n);
    int len = (int)strlen(digits), whole = len > DIGITS ? len - DIGITS : 0;
    sga_buf_printf(&text, "%s%.*s%s.", negative ? "-" : "", whole, digits, whole ? "" : "0");
    for (int k = len; k < DIGITS; k++)
        sga_buf_puts(&text, "0");
    sga_buf_puts(&text, digits + whole);
    sga_json_string(w, text.data);
    flint_free(digits);
}

static void write_interval(struct sga_json *w, const arb_t v)
{
    sga_json_array(w);
    write_bound(w, v, false);
    write_bound(w, v, true);
    sga_json_end_array(w);
}

/* The last condition of an open part by a change of its sign along one parameter, the others having values: the zero lies in v. */
static bool bracket(const struct cases_space *s, expr_id f, int symbol, arb_t v)
{
    struct expr_store *st = s->st;
    int before = 0;
    long lo = 0;
    bool found = false;
    for (long k = -GRID; k <= GRID && !found; k++) {
        int sign = sign_at(s, cases_at(s->st, f, &(struct cases_put){ symbol, expr_rational(st, k, 8) }, 1));
        found = before * sign < 0;
        lo = k - 1;
        if (!found)
            before = sign;
    }
    if (!found)
        return false;
    SGA_ENDS(fmpq_end) fmpq_t a = { { 0, 1 } }, h = { { 0, 1 } };
    fmpq_set_si(a, lo, 8);
    fmpq_set_si(h, 1, 8);
    for (int i = 0; i < HALVINGS; i++) {
        fmpq_div_2exp(h, h, 1);
        fmpq_add(a, a, h);
        int sign = sign_at(s, cases_at(s->st, f, &(struct cases_put){ symbol, expr_fmpq(st, a) }, 1));
        if (sign != before)
            fmpq_sub(a, a, h);
    }
    SGA_ENDS(arb_end) arb_t end = { 0 };
    arb_set_fmpq(v, a, BITS);
    fmpq_add(a, a, h);
    arb_set_fmpq(end, a, BITS);
    arb_union(v, v, end, BITS);
    return true;
}

/* Where everything has a value, and nothing of these vanishes. */
static bool fits(const struct cases_space *s, const struct cases_put *all, int n, const expr_id *e, int count)
{
    for (int i = 0; i < count; i++)
        if (!sign_at(s, cases_at(s->st, e[i], all, n)))
            return false;
    return true;
}

struct sample {
    struct cases_put *all; int n;      /* free ones first, then those that are put in, at their values */
    int bracketed;                     /* symbol; -1: none */
    arb_t interval;
};

static bool draw_all(const struct cases_space *s, const struct cases_part *part, int attempt, struct sample *x)
{
    const struct sys_system *sys = s->system;
    expr_id f = part->open ? part->where[part->wheres - 1] : EXPR_UNDEF;
    x->n = 0;
    x->bracketed = -1;
    for (int i = 0; i < sys->parameters; i++) {
        bool is_put = s->st->symbol[sys->parameter[i]].kind != EXPR_PARAMETER;
        for (int k = 0; k < part->puts; k++)
            is_put = is_put || part->put[k].symbol == sys->parameter[i];
        if (!is_put)
            x->all[x->n++] = (struct cases_put){ sys->parameter[i], draw(s->st, x->n, attempt) };
    }
    int drawn = x->n;
    for (int i = 0; f && i < drawn && x->bracketed < 0; i++) {
        struct cases_put keep = x->all[i];
        x->all[i].value = s->st->symbol[keep.symbol].node;
        if (bracket(s, cases_at(s->st, f, x->all, drawn), keep.symbol, x->interval))
            x->bracketed = keep.symbol;
        else
            x->all[i] = keep;
    }
    for (int k = 0; k < part->puts; k++) {
        expr_id v = cases_at(s->st, part->put[k].value, x->all, drawn);
        SGA_ENDS(arb_end) arb_t ball = { 0 };
        bool ok = part->open || number(s, v, ball);
        if (!ok)
            return false;
        x->all[x->n++] = (struct cases_put){ part->put[k].symbol, v };
    }
    return !part->open || x->bracketed >= 0;
}

static bool write_sample(const struct cases_space *s, const struct sample *x, struct sga_buf *json)
{
    struct sga_json w;
    bool ok = true;
    sga_json_begin(&w, json);
    sga_json_object(&w);
    for (int i = 0; i < x->n && ok; i++) {
        SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
        SGA_ENDS(arb_end) arb_t v = { 0 };
        sga_json_key(&w, s->st->symbol[x->all[i].symbol].name);
        if (x->all[i].symbol == x->bracketed) {
            write_interval(&w, x->interval);
        } else if (expr_is_const(s->st, x->all[i].value) && expr_print(s->st, x->all[i].value, 200, &text)) {
            sga_json_string(&w, text.data);
        } else {
            ok = number(s, x->all[i].value, v);
            write_interval(&w, v);
        }
    }
    sga_json_end_object(&w);
    if (!ok)
        sga_buf_free(json);
    return ok;
}

bool cases_sample(const struct sys_system *system, const struct cases_part *part, const expr_id *other, int others, struct sga_buf *json)
{
    struct cases_space s = cases_space_of(system, NULL);
    struct sample x = { .all = sga_malloc(((size_t)system->parameters + 1) * sizeof *x.all) };
    bool found = false;
    arb_init(x.interval);
    for (int t = 0; t < TRIES && !found; t++)
        found = draw_all(&s, part, t, &x)
                && (part->open || (fits(&s, x.all, x.n, part->excluded, part->excludeds) && fits(&s, x.all, x.n, other, others)));
    found = found && write_sample(&s, &x, json);
    arb_clear(x.interval);
    free(x.all);
    return found;
}
