/* The interpolation of expr/table.c once more, in balls. */
#include "table_balls.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "ball.h"
#include "buf.h"
#include "flint_ends.h"
#include "mem.h"

/* The decimal that the shortest text of a double is. */
static void decimal(fmpq_t q, double v)
{
    char text[40], digits[40];
    int length = 0, point = -1;
    text[sga_format_double(text, v)] = 0;
    char *exponent = strpbrk(text, "eE");
    long e = exponent ? strtol(exponent + 1, NULL, 10) : 0;
    for (const char *s = text; *s && s != exponent; s++) {
        if (*s == '.')
            point = length;
        else
            digits[length++] = *s;
    }
    digits[length] = 0;
    e -= point < 0 ? 0 : length - point;
    SGA_ENDS(fmpz_end) fmpz_t m = { 0 }, ten = { 0 };
    fmpz_set_str(m, digits, 10);
    fmpz_ui_pow_ui(ten, 10, (ulong)labs(e));
    if (e >= 0)
        fmpz_mul(m, m, ten);
    else
        fmpq_set_fmpz_frac(q, m, ten);
    if (e >= 0)
        fmpq_set_fmpz(q, m);
}

/* Sample k of the times (0) or the values (1), as it was given. */
static expr_id given(const struct expr_table *u, int which, int k)
{
    return u->given ? u->given[which * u->knots + k] : EXPR_UNDEF;
}

int num_table_exact(struct expr_table *u)
{
    if (u->knot)
        return -1;
    int bad = -1;
    u->knot = _fmpq_vec_init(u->knots);
    for (int k = 0; k < u->knots && bad < 0; k++) {
        expr_id e = given(u, 0, k);
        if (e && !expr_is_const(u->store, e))
            bad = k;
        else if (e)
            fmpq_set(u->knot + k, expr_const_value(u->store, e));
        else
            decimal(u->knot + k, u->time[k]);
        if (bad < 0 && k && u->time[k] == u->time[k - 1] && !fmpq_equal(u->knot + k, u->knot + k - 1))
            bad = k;
    }
    if (bad >= 0) {
        _fmpq_vec_clear(u->knot, u->knots);
        u->knot = NULL;
    }
    return bad;
}

static void value_of(arb_t r, const struct expr_table *u, int k, slong prec)
{
    expr_id e = given(u, 1, k);
    SGA_ENDS(fmpq_end) fmpq_t q;
    fmpq_init(q);
    if (!e) {
        decimal(q, u->piece[k][0]);
        arb_set_fmpq(r, q, prec);
    } else if (expr_is_const(u->store, e)) {
        arb_set_fmpq(r, expr_const_value(u->store, e), prec);
    } else {
        SGA_ENDS(expr_cone_clear) struct expr_cone cone;
        struct num_ball b;
        expr_cone_init(&cone);
        num_ball_init(&b, u->store, prec);
        expr_cone_of(u->store, &cone, &e, 1);
        num_ball_list(&b, cone.list, cone.count);
        arb_set(r, num_ball_value(&b, e));
        num_ball_clear(&b);
    }
}

/* How long interval k is, and the chord's slope over it. */
static void chord_of(const struct num_table_balls *b, int k, arb_t h, arb_t chord)
{
    SGA_ENDS(fmpq_end) fmpq_t d;
    fmpq_init(d);
    fmpq_sub(d, b->table->knot + k + 1, b->table->knot + k);
    arb_set_fmpq(h, d, b->prec);
    arb_sub(chord, b->value + k + 1, b->value + k, b->prec);
    arb_div(chord, chord, h, b->prec);
}

/* r = u x + v y. */
static void sum_of_two(arb_t r, const arb_t u, const arb_t x, const arb_t v, const arb_t y, slong prec)
{
    SGA_ENDS(arb_end) arb_t s = { 0 };
    arb_mul(s, u, x, prec);
    arb_addmul(s, v, y, prec);
    arb_swap(r, s);
}

/* An end of the spline, h, chord, next: the length and the chord of its interval and of the one beside it: r = ((h + 2 a) h' chord + h^2 chord') / a,
 * a = h + h'. */
static void end_row(arb_t r, arb_t a, const arb_t h, const arb_t chord, const arb_t next_h, const arb_t next_chord, slong prec)
{
    SGA_ENDS(arb_end) arb_t u = { 0 }, v = { 0 };
    arb_add(a, h, next_h, prec);
    arb_mul_2exp_si(u, a, 1);
    arb_add(u, u, h, prec);
    arb_mul(u, u, next_h, prec);
    arb_sqr(v, h, prec);
    sum_of_two(r, u, chord, v, next_chord, prec);
    arb_div(r, r, a, prec);
}

/* The elimination of slopes() in expr/table.c. */
static void eliminate(int n, arb_srcptr h, arb_srcptr chord, arb_ptr s, slong prec)
{
    SGA_ARENA(mem);
    arb_ptr diagonal = arbs_take(&mem, n), upper = arbs_take(&mem, n);
    SGA_ENDS(arb_end) arb_t f = { 0 }, lower = { 0 };
    arb_set(diagonal, h + 1);
    end_row(s, upper, h, chord, h + 1, chord + 1, prec);
    for (int i = 1; i < n; i++) {
        bool last = i == n - 1;
        if (last) {
            end_row(s + i, lower, h + i - 1, chord + i - 1, h + i - 2, chord + i - 2, prec);
            arb_set(diagonal + i, h + i - 2);
        } else {
            arb_set(lower, h + i);
            arb_add(diagonal + i, h + i - 1, h + i, prec);
            arb_mul_2exp_si(diagonal + i, diagonal + i, 1);
            sum_of_two(s + i, h + i, chord + i - 1, h + i - 1, chord + i, prec);
            arb_mul_ui(s + i, s + i, 3, prec);
            arb_set(upper + i, h + i - 1);
        }
        arb_div(f, lower, diagonal + i - 1, prec);
        arb_submul(diagonal + i, f, upper + i - 1, prec);
        arb_submul(s + i, f, s + i - 1, prec);
    }
    for (int i = n - 1; i >= 0; i--) {
        if (i < n - 1)
            arb_submul(s + i, upper + i, s + i + 1, prec);
        arb_div(s + i, s + i, diagonal + i, prec);
    }
}

/* Of the parabola through three samples. */
static void three_slopes(arb_srcptr h, arb_srcptr chord, arb_ptr s, slong prec)
{
    SGA_ENDS(arb_end) arb_t curve = { 0 }, whole = { 0 };
    arb_sub(curve, chord + 1, chord, prec);
    arb_add(whole, h, h + 1, prec);
    arb_div(curve, curve, whole, prec);
    arb_set(s, chord);
    arb_submul(s, curve, h, prec);
    arb_set(s + 1, chord);
    arb_addmul(s + 1, curve, h, prec);
    arb_set(s + 2, chord + 1);
    arb_addmul(s + 2, curve, h + 1, prec);
}

/* The slopes at n samples without a step, from this one. */
static void slopes(struct num_table_balls *b, int first, int n)
{
    SGA_ARENA(mem);
    arb_ptr h = arbs_take(&mem, n), chord = arbs_take(&mem, n);
    for (int i = 0; i + 1 < n; i++)
        chord_of(b, first + i, h + i, chord + i);
    if (n == 3)
        three_slopes(h, chord, b->slope + first, b->prec);
    else if (n > 3)
        eliminate(n, h, chord, b->slope + first, b->prec);
}

void num_table_balls_init(struct num_table_balls *b, const struct expr_table *u, slong prec)
{
    assert(u->knot && prec > 1);
    *b = (struct num_table_balls){ .table = u, .prec = prec, .value = _arb_vec_init(u->knots), .slope = u->kind == EXPR_CUBIC ? _arb_vec_init(u->knots) : NULL };
    for (int k = 0; k < u->knots; k++)
        value_of(b->value + k, u, k, prec);
    for (int from = 0, to; b->slope && from < u->knots; from = to) {
        for (to = from + 1; to < u->knots && u->time[to] > u->time[to - 1]; to++)
            ;
        slopes(b, from, to - from);
    }
}

void num_table_balls_clear(struct num_table_balls *b)
{
    if (b->value)
        _arb_vec_clear(b->value, b->table->knots);
    if (b->slope)
        _arb_vec_clear(b->slope, b->table->knots);
    *b = (struct num_table_balls){ 0 };
}

/* A step's neighbours on both sides: two samples alone make a line. */
static bool straight(const struct num_table_balls *b, int k)
{
    const struct expr_table *u = b->table;
    return !b->slope || ((k == 0 || u->time[k] == u->time[k - 1]) && (k + 2 == u->knots || u->time[k + 2] == u->time[k + 1]));
}

void num_table_balls_piece(const struct num_table_balls *b, int k, arb_ptr out)
{
    assert(k >= 0 && k + 1 < b->table->knots);
    slong prec = b->prec;
    SGA_ENDS(arb_end) arb_t h = { 0 }, chord = { 0 }, bend = { 0 };
    _arb_vec_zero(out, NUM_TABLE_PIECE);
    arb_set_fmpq(out, b->table->knot + k, prec);
    arb_set(out + 1, b->value + k);
    if (b->table->time[k + 1] == b->table->time[k])        /* a step itself has no length */
        return;
    chord_of(b, k, h, chord);
    arb_set(out + 2, chord);
    if (straight(b, k))
        return;
    arb_add(bend, b->slope + k, b->slope + k + 1, prec);
    arb_submul_ui(bend, chord, 2, prec);
    arb_div(bend, bend, h, prec);
    arb_set(out + 2, b->slope + k);
    arb_sub(out + 3, chord, b->slope + k, prec);
    arb_div(out + 3, out + 3, h, prec);
    arb_sub(out + 3, out + 3, bend, prec);
    arb_div(out + 4, bend, h, prec);
}

void num_table_balls_value(arb_t r, arb_srcptr piece, int order, const arb_t t, slong prec)
{
    SGA_ENDS(arb_end) arb_t x = { 0 }, v = { 0 }, c = { 0 };
    arb_sub(x, t, piece, prec);
    for (int i = EXPR_TABLE_DEGREE; i >= order; i--) {
        arb_set(c, piece + 1 + i);
        for (int k = 0; k < order; k++)
            arb_mul_ui(c, c, (ulong)(i - k), prec);
        arb_mul(v, v, x, prec);
        arb_add(v, v, c, prec);
    }
    arb_swap(r, v);
}
