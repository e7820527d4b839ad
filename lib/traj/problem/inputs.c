/* Inputs: which they are, and their pieces (enclose/smooth_pieces.h) put together. */
#include "inputs.h"
#include "warnings.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "ode.h"
#include "smooth_pieces.h"
#include "system.h"

enum { TAME = 8, WILD = 100 };
enum { MOST_INPUTS = SGA_MOST_INPUTS, MOST_PIECES = SGA_MOST_PIECES, LEAST_PIECES = 60 };
/* Pieces of all inputs, times operations. */
static const double MOST_WORK = 60000;
/* Variation below this part of the largest value is none (as far as the tolerance is above it). */
static const double SMALLEST = 1e-14;

enum { NO_TIME = 1, OF_TIME, MIXED };      /* numbers and parameters; what can be looked at; all else */

/* By the kinds of its operands: switches are no operations (the arguments are looked at), nor are tables. */
static int kind_of(const struct expr_store *st, const unsigned char *kind, expr_id e, int time)
{
    int op = expr_op_of(st, e), children = expr_children(st, e), most = NO_TIME;
    if (op == EXPR_SYM)
        return st->node[e].a == time ? OF_TIME : st->symbol[st->node[e].a].kind == EXPR_PARAMETER ? NO_TIME : MIXED;
    for (int k = 0; k < children; k++) {
        int c = kind[expr_child(st, e, k)];
        most = c > most ? c : most;
    }
    bool plain = op != EXPR_ABS && op != EXPR_SIGN && op != EXPR_MIN && op != EXPR_MAX && op != EXPR_SOLVE;
    return most == OF_TIME && !plain ? MIXED : most;
}

/* Sums and products of few powers of time and of few sines and cosines of a t + b, with any numbers a, b: nothing of these
 * is narrow beside the rest. */
struct tame {
    int factors;               /* of the longest product; WILD: none of these */
    bool waves;                /* sines among them */
};

static struct tame tame_of(const struct expr_store *st, const struct tame *known, expr_id e, int time)
{
    struct expr_node n = st->node[e];
    int args = n.op == EXPR_SYM || n.op == EXPR_CONST || n.op == EXPR_SOLVE ? 0 : expr_op_args((enum expr_op)n.op);
    struct tame a = args > 0 ? known[n.a] : (struct tame){ 0 }, b = args > 1 ? known[n.b] : (struct tame){ 0 };
    bool waves = a.waves || b.waves, still = a.factors == 0 && b.factors == 0;
    long factors = WILD;
    switch (n.op) {
    case EXPR_CONST: case EXPR_PI: factors = 0; break;
    case EXPR_SYM: factors = n.a == time ? 1 : st->symbol[n.a].kind == EXPR_PARAMETER ? 0 : WILD; break;
    case EXPR_SOLVE: break;
    case EXPR_NEG: factors = a.factors; break;
    case EXPR_ADD: case EXPR_SUB: factors = a.factors > b.factors ? a.factors : b.factors; break;
    case EXPR_MUL: factors = a.factors + b.factors; break;
    case EXPR_DIV: factors = b.factors == 0 ? a.factors : WILD; break;
    case EXPR_POWI: factors = still ? 0 : n.b > 0 ? (long)a.factors * n.b : WILD; break;
    case EXPR_SIN: case EXPR_COS:
        factors = still ? 0 : a.factors == 1 && !a.waves ? 1 : WILD;
        waves = !still;
        break;
    default: factors = still ? 0 : WILD;
    }
    return (struct tame){ factors <= TAME ? (int)factors : WILD, waves };
}

/* The largest subexpressions that are of time alone: those that others use, and roots. Returns how many. */
static int find(const struct sys_system *sys, const expr_id *root, int roots, expr_id *found)
{
    const struct expr_store *st = sys->store;
    struct expr_cone cone;
    int count = 0;
    if (!roots)
        return 0;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, root, roots);
    unsigned char *kind = sga_calloc((size_t)st->nodes + 1, 1), *taken = sga_calloc((size_t)st->nodes + 1, 1);
    struct tame *tame = sga_malloc(((size_t)st->nodes + 1) * sizeof *tame);
    for (int i = 0; i < cone.count; i++) {
        expr_id e = cone.list[i];
        kind[e] = (unsigned char)kind_of(st, kind, e, sys->time);
        tame[e] = tame_of(st, tame, e, sys->time);
    }
    for (int i = 0; i < cone.count + roots; i++) {
        expr_id e = i < cone.count ? cone.list[i] : root[i - cone.count];
        int children = i < cone.count ? expr_children(st, e) : 1;
        for (int k = 0; k < children && (i >= cone.count || kind[e] == MIXED); k++) {
            expr_id c = i < cone.count ? expr_child(st, e, k) : e;
            if (kind[c] != OF_TIME || taken[c] || tame[c].factors < WILD || count == MOST_INPUTS)
                continue;
            taken[c] = 1;
            found[count++] = c;
        }
    }
    free(kind);
    free(tame);
    free(taken);
    expr_cone_clear(&cone);
    return count;
}

static int most_pieces(const struct expr_store *st, expr_id u, int inputs)
{
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &u, 1);
    double most = MOST_WORK / (2.0 + cone.count) / inputs;
    expr_cone_clear(&cone);
    return (int)fmin(MOST_PIECES, fmax(LEAST_PIECES, most));
}

/* The pieces so far, and those of one more input: on each part of either the shorter step. */
static void add(struct inputs *q, const struct enc_pieces *p)
{
    struct ode_piece *all = sga_malloc((size_t)(q->count + p->count + 1) * sizeof *all);
    int count = 0, i = 0, j = 0;
    while (i < q->count || j < p->count) {
        double a = i < q->count ? q->piece[i].end : INFINITY, b = j < p->count ? p->end[j] : INFINITY, end = fmin(a, b);
        double width = j < p->count ? p->step[j] : INFINITY;
        all[count++] = (struct ode_piece){ end, fmin(width, i < q->count ? q->piece[i].step : INFINITY) };
        i += a == end;
        j += b == end;
    }
    free(q->piece);
    q->piece = all;
    q->count = count;
}

/* Times that go down: the list from behind, each piece with its other end. */
static void turn_round(struct inputs *q, double from)
{
    for (int i = 0, j = q->count - 1; i < j; i++, j--) {
        struct ode_piece c = q->piece[i];
        q->piece[i] = q->piece[j];
        q->piece[j] = c;
    }
    for (int i = 0; i < q->count; i++)
        q->piece[i].end = i + 1 < q->count ? q->piece[i + 1].end : from;
}

/* Ends in the order of the motion, to its end; steps that lead on. */
static bool inputs_sane(const struct inputs *q, double start, double stop)
{
    bool sane = !q->count || q->piece[q->count - 1].end == stop;
    for (int i = 0; i < q->count && sane; i++)
        sane = q->piece[i].step > 0 && (q->piece[i].end - (i > 0 ? q->piece[i - 1].end : start)) * (stop - start) > 0;
    return sane;
}

void inputs_examine(struct inputs *q, const struct sys_system *sys, const struct traj_request *rq, const expr_id *root, int roots)
{
    expr_id found[MOST_INPUTS];
    *q = (struct inputs){ .complete = true };
    if (!rq->samples || !rq->times)
        return;
    double stop = rq->times[rq->samples - 1], from = fmin(rq->start, stop), to = fmax(rq->start, stop);
    if (!(from < to) || !isfinite(to - from))
        return;
    int count = find(sys, root, roots, found);
    if (count == MOST_INPUTS) {
        q->complete = false;
        sga_limit_met(rq->budget, SGA_LIMIT_INPUTS);
    }
    for (int k = 0; k < count; k++) {
        struct enc_pieces p;
        double small = fmax(SMALLEST, 0.1 * rq->rtol);
        if (!enc_pieces_find(&p, sys->store, found[k], sys->time, from, to, small, most_pieces(sys->store, found[k], count))) {
            q->complete = false;
            continue;
        }
        if (!p.complete) {
            q->complete = false;
            sga_limit_met(rq->budget, SGA_LIMIT_PIECES);
        }
        if (p.count > 1)
            add(q, &p);
        enc_pieces_clear(&p);
    }
    if (stop < rq->start)
        turn_round(q, stop);
    assert(inputs_sane(q, rq->start, stop));
}

void inputs_clear(struct inputs *q)
{
    free(q->piece);
    *q = (struct inputs){ 0 };
}
