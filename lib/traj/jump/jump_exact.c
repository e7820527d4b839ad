/* Digits from piece to piece: as constants of the store, which double-double starts from (precise_point.c). */
#include "jump_exact.h"

#include <assert.h>
#include <arf.h>
#include <flint/fmpq.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "dd.h"
#include "error.h"
#include "jump_set.h"
#include "knots.h"
#include "system.h"

bool jump_is_exact(const struct traj_request *rq)
{
    return rq->arithmetic == TRAJ_DOUBLE_DOUBLE;
}

static void add_double(fmpq_t sum, double x)
{
    arf_t d;
    fmpq_t q;
    arf_init(d);
    fmpq_init(q);
    arf_set_d(d, x);
    arf_get_fmpq(q, d);
    fmpq_add(sum, sum, q);
    fmpq_clear(q);
    arf_clear(d);
}

expr_id jump_exact_constant(struct expr_store *st, const char *digits, double about)
{
    fmpq_t sum;
    num_dd x = digits ? num_dd_parse(digits) : num_dd_of(about);
    assert(isfinite(x.hi));
    fmpq_init(sum);
    add_double(sum, x.hi);
    add_double(sum, x.lo);
    expr_id e = expr_fmpq(st, sum);
    fmpq_clear(sum);
    return e;
}

/* A time: of a knot exactly that, or a sliver would be left before it. */
static expr_id instant(const struct jump *j, const char *digits, double about)
{
    struct knots k;
    struct sga_error ignored = { 0 };
    expr_id e = EXPR_UNDEF;
    num_dd t = digits ? num_dd_parse(digits) : num_dd_of(about);
    bool known = knots_init(&k, j->sys, j->rq, &ignored);
    for (int i = 0; known && i < k.count && !e; i++)
        if (fabs(num_dd_sub(num_dd_of_fmpq(k.knot + i), t).hi) <= 16 * NUM_DD_EPSILON * fabs(t.hi))
            e = expr_fmpq(j->sys->store, k.knot + i);
    knots_clear(&k);
    return e ? e : jump_exact_constant(j->sys->store, digits, about);
}

void jump_exact_times(struct jump_piece *q, const struct traj_request *rq, int done)
{
    q->q.exact_time = q->exact ? rq->exact_time + done : NULL;
    q->q.exact_initial = q->exact;
    q->q.exact_start = q->exact ? q->exact_start : EXPR_UNDEF;
}

void jump_exact_start(struct jump_piece *q, const struct traj_request *rq)
{
    if (!q->exact)
        return;
    int n = rq->modes ? rq->modes->start->sys->variables : q->n;
    assert(rq->exact_time && rq->exact_initial);
    q->exact_start = rq->exact_start;
    memset(q->given, 0, (size_t)q->n);
    memcpy(q->given, rq->given, (size_t)n);
    memcpy(q->exact, rq->exact_initial, (size_t)n * sizeof *q->exact);
    jump_exact_times(q, rq, 0);
}

void jump_exact_next(struct jump_piece *q, const struct jump *j, const struct traj_result *piece)
{
    if (!q->exact)
        return;
    size_t wide = (size_t)piece->columns, last = (size_t)piece->happened - 1;
    assert(piece->happened > 0 && piece->happened_digits);
    char *const *digits = piece->happened_digits + last * (wide + 1);
    const double *value = piece->happened_value + last * wide;
    size_t from = wide - (size_t)q->before;
    q->exact_start = instant(j, digits[0], piece->happening[last].t);
    memset(q->given, 0, (size_t)q->n);
    memset(q->exact, 0, (size_t)q->n * sizeof *q->exact);
    for (int k = 0; k < j->rq->modes->start->sys->variables; k++) {
        if (!j->moving[k] && j->bound[k])
            continue;
        q->given[k] = 1;
        q->exact[k] = jump_exact_constant(j->sys->store, digits[1 + from + (size_t)k], value[from + (size_t)k]);
    }
}

void jump_exact_place(struct jump_piece *q, struct expr_store *st, double t, const unsigned char *given, const struct num_dd *x)
{
    q->exact_start = jump_exact_constant(st, NULL, t);
    memcpy(q->given, given, (size_t)q->n);
    for (int k = 0; k < q->n; k++) {
        char *digits = num_dd_text(x[k], NUM_DD_DIGITS);
        q->exact[k] = given[k] ? jump_exact_constant(st, digits, x[k].hi) : EXPR_UNDEF;
        free(digits);
    }
}

double jump_difference(const struct traj_result *a, const struct traj_result *b, size_t at)
{
    if (!a->digits || !b->digits || !a->digits[at] || !b->digits[at])
        return fabs(a->value[at] - b->value[at]);
    return fabs(num_dd_sub(num_dd_parse(a->digits[at]), num_dd_parse(b->digits[at])).hi);
}

double jump_time_difference(const struct traj_result *a, int i, const struct traj_result *b, int k)
{
    const char *s = a->happened_digits ? a->happened_digits[(size_t)i * ((size_t)a->columns + 1)] : NULL, *t = b->happened_digits ? b->happened_digits[(size_t)k * ((size_t)b->columns + 1)] : NULL;
    if (!s || !t)
        return fabs(a->happening[i].t - b->happening[k].t);
    return fabs(num_dd_sub(num_dd_parse(s), num_dd_parse(t)).hi);
}

double jump_epsilon(const struct traj_result *r)
{
    return r->digits ? 4 * NUM_DD_EPSILON : DBL_EPSILON;
}
