/* The witness on what is printed: the texts are read back by the parser into a store of
 * their own, so that a slip of the printer or of a normal form cannot pass either. */
#include "run_job.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "buf.h"
#include "error.h"
#include "form.h"
#include "job_texts.h"
#include "mechanical_answer.h"
#include "mem.h"
#include "oracle.h"
#include "parse.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "seeds.h"
#include "set_points.h"
#include "stage_clock.h"
#include "system.h"
#include "texts.h"
#include "witness.h"

enum { WITNESS_POINTS = 2 };

struct readback {
    struct expr_store st;
    int *variable, *parameter, time;
    expr_id *value; int values;      /* by symbol: of parameters that have one in the request */
    expr_id *root;
};

static expr_id derivative_symbol(void *ctx, int symbol, int order)
{
    struct expr_store *st = ctx;
    struct sga_buf name = { 0 };
    sga_buf_puts(&name, st->symbol[symbol].name);
    for (int k = 0; k < order; k++)
        sga_buf_puts(&name, "'");
    int s = expr_symbol_find(st, name.data, name.len);
    sga_buf_free(&name);
    return s < 0 ? EXPR_UNDEF : st->symbol[s].node;
}

static int copy_symbol(struct readback *b, const struct expr_store *from, int symbol)
{
    const struct expr_symbol *s = from->symbol + symbol;
    expr_symbol_add(&b->st, s->name, s->kind);
    return expr_symbol_find(&b->st, s->name, strlen(s->name));
}

expr_id answer_text_read(struct job *j, const char *text)
{
    struct expr_store *st = &j->request->store;
    struct expr_grammar g = { .derivative = derivative_symbol, .ctx = st, .max_length = 1 << 28, .max_depth = 1 << 20,
                              .max_exponent = 1L << 30, .max_digits = 1 << 20 };
    struct sga_error err = { 0 };
    expr_id e = expr_parse(st, text, &g, &err);
    SGA_ARENA(mem);
    expr_id *value = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *value);
    for (int k = 0; k < j->request->knowns; k++)
        value[j->request->known[k].symbol] = j->request->known[k].value;
    if (e)
        expr_substitute(st, &e, 1, value);
    return e;
}

/* A text may call a parameter by its name that has a value: it is read as that. */
static void known_values(const struct job *j, struct readback *b)
{
    const struct expr_store *from = &j->request->store;
    int most = b->st.symbols + j->request->knowns;
    SGA_ARENA(mem);
    expr_id *none = sga_zeros(&mem, (size_t)from->symbols + 1, sizeof *none);
    b->value = sga_calloc((size_t)most + 1, sizeof *b->value);
    for (int k = 0; k < j->request->knowns; k++) {
        expr_id v = j->request->known[k].value;
        int s = copy_symbol(b, from, j->request->known[k].symbol);
        expr_copy(&b->st, from, &v, 1, none);
        b->value[s] = v;
    }
    b->values = b->st.symbols;
}

static bool parse_all(struct job *j, struct readback *b)
{
    struct expr_grammar g = { .derivative = derivative_symbol, .ctx = &b->st, .value = b->value, .values = b->values, .max_length = 1 << 28,
                              .max_depth = 1 << 20, .max_exponent = 1L << 30, .max_digits = 1 << 20 };
    const struct expr_names *t = &j->texts->names;
    int base = b->st.symbols;
    SGA_ARENA(mem);
    expr_id *meaning = sga_zeros(&mem, (size_t)(base + t->count + 1), sizeof *meaning);
    bool ok = true;
    for (int i = 0; i < t->count && ok; i++) {
        expr_id e = expr_parse(&b->st, t->text[i], &g, j->err);
        ok = e != EXPR_UNDEF;
        if (ok) {
            expr_substitute(&b->st, &e, 1, meaning);
            expr_symbol_add(&b->st, t->name[i], EXPR_FREE);
            meaning[expr_symbol_find(&b->st, t->name[i], strlen(t->name[i]))] = e;
        }
    }
    for (int i = 0; i < t->roots && ok; i++) {
        b->root[i] = expr_parse(&b->st, t->root[i], &g, j->err);
        ok = b->root[i] != EXPR_UNDEF;
    }
    if (ok && t->count)
        expr_substitute(&b->st, b->root, t->roots, meaning);
    if (!ok || !expr_store_ok(&b->st)) {
        char detail[600];
        snprintf(detail, sizeof detail, "%.500s", j->err->detail);
        *j->err = (struct sga_error){ 0 };
        return sga_fail(j->err, SGA_E_INTERNAL, "a printed expression does not read back: %s", detail);
    }
    return true;
}

/* Where the witness looks first: near the guess, but 0 where nothing is given is no place for a root. */
static const double *witness_near(const struct job *j)
{
    return j->start.x && !(j->solution->definitions && j->oracle->reals) ? j->start.x : NULL;
}

/* Acceleration and reaction as printed against the formulas, at a point of W. */
static bool check_motion(struct job *j, struct readback *b)
{
    assert(j->mechanical->has_motion && j->mechanical->first_root + 4 * j->request->mechanical->coordinates <= j->texts->names.roots);
    struct mechanical_answer *m = j->mechanical;
    struct expr_store *st = &j->request->store;
    int n = j->request->mechanical->coordinates;
    const expr_id *part[4] = { m->motion.total, m->motion.tangent, m->motion.orthogonal, m->motion.reaction };
    struct num_ball *here = &m->fibre.oracle->real[0].ball, there;
    bool ok = true;
    if (!m->fibre.oracle->reals)
        return true;
    num_ball_extend(here);
    num_ball_init(&there, &b->st, here->prec);
    for (int i = 0; i < st->symbols; i++) {
        int s = expr_symbol_find(&b->st, st->symbol[i].name, strlen(st->symbol[i].name));
        if (s >= 0)
            num_ball_set(&there, s, here->symbol + i);
    }
    num_ball_extend(&there);
    for (int k = 0; k < 4 * n && ok; k++) {
        arb_srcptr a = num_ball_value(here, part[k / n][k % n]), c = num_ball_value(&there, b->root[m->first_root + k]);
        ok = !arb_is_finite(a) || !arb_is_finite(c) || arb_overlaps(a, c);
    }
    num_ball_clear(&there);
    return ok || sga_fail(j->err, SGA_E_WITNESS, "a printed acceleration or reaction differs from its formula at a point");
}

static bool check_texts(struct job *j)
{
    struct readback b = { 0 };
    const struct sys_system *sys = &j->request->system;
    int n = sys->variables, c = j->solution->constraints;
    expr_store_init(&b.st);
    b.variable = sga_malloc((size_t)(n + 1) * sizeof *b.variable);
    b.parameter = sga_malloc((size_t)(sys->parameters + 1) * sizeof *b.parameter);
    b.root = sga_calloc((size_t)(j->texts->names.roots + 1), sizeof *b.root);
    b.time = copy_symbol(&b, sys->store, sys->time);
    for (int i = 0; i < n; i++)
        b.variable[i] = copy_symbol(&b, sys->store, sys->variable[i].symbol);
    for (int i = 0; i < sys->parameters; i++)
        b.parameter[i] = copy_symbol(&b, sys->store, sys->parameter[i]);
    known_values(j, &b);
    bool ok = parse_all(j, &b);
    if (ok) {
        bool field = j->solution->field && j->request->want & (REQUEST_VECTOR_FIELD | REQUEST_GAUGE);
        bool gauge = field && j->solution->gauge && j->request->want & REQUEST_GAUGE;
        assert(c + (field ? n : 0) + (gauge ? n * j->solution->free_columns : 0) <= j->texts->names.roots);
        struct sga_claim claim = {
            .st = &b.st, .variable = b.variable, .variables = n, .parameter = b.parameter, .parameters = sys->parameters,
            .time = b.time, .constraint = b.root, .constraints = c, .solution = j->solution, .field = field ? b.root + c : NULL,
            .gauge = gauge ? b.root + c + n : NULL, .gauges = gauge ? j->solution->free_columns : 0,
        };
        ok = sga_witness_check(sys, &claim, j->oracle, witness_near(j), j->start.time, 77, WITNESS_POINTS, j->budget, j->witness, j->err);
        if (ok && j->mechanical && j->mechanical->has_motion)
            ok = check_motion(j, &b);
    }
    free(b.variable);
    free(b.parameter);
    free(b.value);
    free(b.root);
    expr_store_clear(&b.st);
    return ok;
}

static bool check_handles(struct job *j)
{
    const struct sys_system *sys = &j->request->system;
    int n = sys->variables, c = j->solution->constraints;
    SGA_ARENA(mem);
    int *variable = sga_take(&mem, (size_t)n * sizeof *variable);
    expr_id *constraint = sga_take(&mem, (size_t)(c + 1) * sizeof *constraint);
    for (int i = 0; i < n; i++)
        variable[i] = sys->variable[i].symbol;
    for (int i = 0; i < c; i++)
        constraint[i] = j->solution->constraint[i].expr;
    struct sga_claim claim = {
        .st = sys->store, .variable = variable, .variables = n, .parameter = sys->parameter, .parameters = sys->parameters,
        .time = sys->time, .constraint = constraint, .constraints = c, .solution = j->solution, .field = j->solution->field,
        .gauge = j->solution->gauge, .gauges = j->solution->gauge ? j->solution->free_columns : 0,
    };
    bool ok = sga_witness_check(sys, &claim, j->oracle, witness_near(j), j->start.time, 77, 1, j->budget, j->witness, j->err);
    return ok;
}

/* Whether e cannot be told from 0 at p, with as many bits as may be needed: what differs
 * from 0 may be as small as the request's smallest number. */
static bool seems_zero(const struct points_space *space, struct points_point *p, expr_id e)
{
    static const slong bits[] = { 0, 700, 2800, 12000, 50000 };
    for (int l = 0; l < 5; l++) {
        if (l && !(space->constraints ? points_refine(space, p, bits[l]) : (p->ball.prec = bits[l])))
            break;
        num_ball_forget(&p->ball);
        num_ball_extend(&p->ball);
        arb_srcptr v = num_ball_value(&p->ball, e);
        if (!arb_is_finite(v) && l == 0)
            return false;
        if (!arb_contains_zero(v))
            return false;
    }
    return true;
}

/* The function that would have to vanish must not vanish at fresh points of the earlier
 * constraints. */
static bool check_contradiction(struct job *j)
{
    const struct sga_solution *sol = j->solution;
    double begin = sga_now();
    struct set_points on;
    set_points_init(&on, &j->request->system, sol, sol->constraints, 0, 0);
    on.space.near = j->start.x;
    on.space.near_time = j->start.time;
    on.space.scale = sol->scale;
    on.space.time_unit = sol->time_unit;
    on.space.side = sol->side;
    on.space.sides = sol->sides;
    on.space.budget = j->budget;
    bool ok = true;
    uint64_t random = SGA_SEED_WITNESS;
    *j->witness = (struct sga_witness){ .certified = true, .digits = 40 };
    bool near = j->start.x;
    for (int k = 0; k < (near ? 2 : 1) * WITNESS_POINTS && ok && (k < WITNESS_POINTS || !j->witness->points); k++) {
        struct points_point p;
        if (k >= WITNESS_POINTS)       /* the constraints may not come near the start */
            on.space.near = NULL;
        if (points_find_staged(&on.space, on.end, on.stages, on.space.near ? 0.04 * (k + 1) : 1, &random, 192, &p) == POINTS_OK) {
            j->witness->points++;
            j->witness->certified &= p.certified;
            if (seems_zero(&on.space, &p, sol->contradiction))
                ok = sga_fail(j->err, SGA_E_WITNESS, "the witness found a point at which what was called a contradiction vanishes");
        }
        points_point_clear(&p);
    }
    if (ok && !j->witness->points)
        ok = job_goes_on(j)
             && sga_fail(j->err, SGA_E_UNDECIDED, "the witness found no fresh point of the constraints before the contradiction");
    set_points_clear(&on);
    j->witness->seconds = sga_now() - begin;
    return ok;
}

/* Values of so many nodes at each point are some of a job's memory: the witness has its own. */
enum { MANY_NODES = 1000000 };

bool answer_witness(struct job *j)
{
    assert(j->solution && j->oracle);         /* the reduction comes before its witness */
    stage_begin(j->clock, STAGE_WITNESS);
    answer_witness_clear(j);
    j->witness = sga_zeros(&j->mem, 1, sizeof *j->witness);
    if (j->request->system.store->nodes > MANY_NODES)
        points_oracle_release(j->oracle);
    bool ok = j->solution->verdict == SGA_INCONSISTENT ? check_contradiction(j) : texts_written(j) ? check_texts(j) : check_handles(j);
    if (!ok)
        answer_witness_clear(j);
    return ok;
}

void answer_witness_clear(struct job *j)
{
    j->witness = NULL;
}
