/* Each stratum as a system of its own: the same algorithm, restricted to it. */
#include "run_job.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "cases.h"
#include "error.h"
#include "follow.h"
#include "job_texts.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "print.h"
#include "properties.h"
#include "reduce.h"
#include "reduction.h"
#include "request.h"
#include "stage_clock.h"
#include "strata.h"
#include "strata_case.h"
#include "stratum.h"
#include "stratum_frame.h"
#include "texts.h"
#include "warnings.h"
#include "write.h"

/* A stratum of a stratum of a stratum ..., and all of them together. */
enum { DEPTH = SGA_MOST_STRATA_INSIDE, MOST = SGA_MOST_STRATA_SOLVED, MOST_CASES = SGA_MOST_CASES_SOLVED };

/* The set that a stratum was reduced to, as it is written. */
struct reached {
    char *key;                    /* verdict, parameter case and the sorted constraints */
    struct sga_buf where;         /* JSON: the functions that it was restricted to */
    int number, index;            /* the list of strata that it is in, and its place there */
};

struct strata_tree {
    struct reached *reached; int count; size_t cap;
    int solved, lists, cases;      /* cases: of parameters, which are counted apart */
    int restrictions;             /* of the request itself */
    bool cancelled;
};

static int by_text(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Equal keys: the same constraints for the same system, so the same set and answer. NULL where
 * the constraints are written with names. */
static char *key_of(const struct job *j)
{
    struct sga_buf key = { 0 };
    int c = j->solution->constraints;
    if (j->texts->names.count || j->solution->verdict == SGA_INCONSISTENT)
        return NULL;
    SGA_ARENA(mem);
    const char **text = sga_take(&mem, (size_t)(c + 1) * sizeof *text);
    for (int i = 0; i < c; i++)
        text[i] = j->texts->names.root[i];
    qsort(text, (size_t)c, sizeof *text, by_text);
    sga_buf_printf(&key, "%d", j->place.parameter_case);
    for (int i = 0; i < c; i++)
        sga_buf_printf(&key, "|%s", text[i]);
    return sga_buf_take(&key);
}

static void where_json(struct sga_buf *out, const struct stratum *s)
{
    struct sga_json w;
    sga_json_begin(&w, out);
    sga_json_array(&w);
    for (int i = 0; i < s->wheres; i++)
        sga_json_string(&w, s->text[i]);
    sga_json_end_array(&w);
}

static void whole_where(const struct job *j, struct sga_buf *out)
{
    struct sga_json w;
    sga_json_begin(&w, out);
    expr_json_list(&j->request->store, j->request->system.restriction, j->request->system.restrictions, 4000, &w);
}

/* Takes over key, which may be NULL. */
static void note_set(const struct job *j, char *key, int number, int index)
{
    assert(number >= 0 && index >= -1 && (index >= 0 || number == 0));
    struct strata_tree *tree = j->strata.tree;
    if (!key)
        return;
    SGA_RESERVE(tree->reached, tree->cap, tree->count + 1);
    struct reached *r = tree->reached + tree->count++;
    *r = (struct reached){ .key = key, .number = number, .index = index };
    whole_where(j, &r->where);
}

/* j is the solved stratum `to`, at place `index` of list `number`; siblings are the strata of
 * that list. Whether its set was reached before: then that is noted instead. */
static bool known_set(struct job *j, struct stratum *sibling, struct stratum *to, int number)
{
    struct strata_tree *tree = j->strata.tree;
    char *key = key_of(j);
    for (int i = 0; i < tree->count && key; i++) {
        struct reached *r = tree->reached + i;
        if (strcmp(r->key, key) != 0)
            continue;
        if (r->index < 0) {          /* the request's own answer */
            to->state = STRATUM_SKIPPED;
        } else if (r->number == number) {
            struct stratum *first = sibling + r->index;
            if (first->also.len)
                sga_buf_puts(&first->also, ",");
            where_json(&first->also, to);
            to->state = STRATUM_MERGED;
        } else {
            to->state = STRATUM_SAME;
            sga_buf_puts(&to->note, r->where.data);
        }
        free(key);
        return true;
    }
    note_set(j, key, number, (int)(to - sibling));
    return false;
}

/* The reduction and all that is written of it, near a guess or not. */
static bool reduce(struct job *j, double *near, double time)
{
    j->start.x = near;
    j->start.time = time;
    return answer_reduce(j);
}

/* A job that shares the request (whose system is the stratum's) and its place among strata, and nothing else: its warnings are its own. */
static struct job fresh(const struct job *j, struct sga_error *err)
{
    struct job own = { .request = j->request, .host = j->host, .stages = j->stages, .strata = { .tree = j->strata.tree },
                       .err = err, .stage = j->stage, .place = j->place };
    own.place.not_zero = NULL;
    own.place.not_zeros = 0;
    own.clock = sga_zeros(&own.mem, 1, sizeof *own.clock);
    own.warnings = sga_zeros(&own.mem, 1, sizeof *own.warnings);
    own.budget = sga_zeros(&own.mem, 1, sizeof *own.budget);
    *own.budget = *j->budget;
    own.budget->warnings = own.warnings;
    return own;
}

/* Local failures that a better start may mend. */
static bool no_point(enum sga_code code)
{
    return code == SGA_E_NO_REAL_POINT || code == SGA_E_IRREGULAR;
}

/* The Hamiltonian form pulls its equations back by the differentials of `restrict`: where those
 * become dependent, equations are lost, and what is reduced there is not the system. */
static bool pull_back_holds(struct job *j)
{
    const struct sys_system *sys = &j->request->system;
    if (strcmp(j->request->form, "hamiltonian") != 0 || !j->strata.tree->restrictions || !j->oracle->reals)
        return true;
    struct points_space space = j->oracle->space;
    space.constraint = sys->restriction;
    space.constraints = j->strata.tree->restrictions;
    int *variable = sga_malloc((size_t)sys->variables * sizeof *variable);
    for (int i = 0; i < sys->variables; i++)
        variable[i] = sys->variable[i].symbol;
    space.variable = variable;
    int rank = strata_rank_at(j, &space, 0, j->strata.tree->restrictions, &j->oracle->real[0]);
    free(variable);
    return rank == j->strata.tree->restrictions
           || sga_fail(j->err, SGA_E_IRREGULAR, "the differentials of the functions in restrict are dependent on this stratum, so "
                       "the pulled-back equations do not say everything there; restrict to it in another way");
}

/* A part that was solved is known by a point of its final set: near one of a larger set other parts may be nearer. */
static void take_final_point(const struct job *j, struct stratum *s)
{
    const struct points_oracle *w = j->oracle;
    if (!w->reals || !points_oracle_certified(w) || w->space.variables != j->request->system.variables)
        return;
    memcpy(s->point, w->real[0].x, (size_t)w->space.variables * sizeof *s->point);
    s->time = w->real[0].t;
}

static void answer_stratum(struct job *j, struct stratum *sibling, struct stratum *s, int number)
{
    struct sga_error first = { 0 };
    double *near = NULL;
    if (strata_is_part(s))
        near = memcpy(sga_take(&j->mem, (size_t)j->request->system.variables * sizeof *near), s->point,
                      (size_t)j->request->system.variables * sizeof *near);
    bool ok = strata_mechanical(j, j->err) && reduce(j, near, s->time);
    if (!ok && no_point(j->err->code) && s->point && !near) {
        first = *j->err;
        struct sga_error *err = j->err;
        struct mechanical_answer *mechanical = j->mechanical;
        *err = (struct sga_error){ 0 };
        j->mechanical = NULL;
        struct job next = fresh(j, err);
        job_clear(j);
        *j = next;
        j->mechanical = mechanical;
        near = sga_take(&j->mem, (size_t)j->request->system.variables * sizeof *near);
        memcpy(near, s->point, (size_t)j->request->system.variables * sizeof *near);
        ok = reduce(j, near, s->time);
        if (!ok)
            *err = first;
    }
    const struct sga_solution *sol = j->solution;
    ok = ok && (sol->verdict == SGA_INCONSISTENT || pull_back_holds(j))
         && (!j->mechanical || answer_mechanical_motion(j)) && answer_texts(j);
    if (ok && sol->verdict == SGA_INCONSISTENT && (sol->empty_restriction || s->off)) {
        s->state = sol->empty_restriction ? STRATUM_EMPTY : STRATUM_SKIPPED;
        sga_buf_puts(&s->note, sol->contradiction_why);
        return;
    }
    if (ok && !strata_is_part(s) && known_set(j, sibling, s, number))
        return;
    if (ok) {
        answer_strata(j);
        answer_signs(j);
    }
    ok = ok && answer_witness(j) && answer_strata_solve(j);
    ok = ok && answer_write(j, &s->result);
    s->state = ok ? STRATUM_SOLVED : STRATUM_UNSOLVED;
    if (ok && strata_is_part(s))
        take_final_point(j, s);
}

bool strata_mechanical(struct job *j, struct sga_error *err)
{
    const struct sys_system *sys = &j->request->system;
    struct expr_store *st = &j->request->store;
    if (!j->request->mechanical)
        return true;
    SGA_ARENA(mem);
    unsigned char *multiplier = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    for (int k = 2 * j->request->mechanical->coordinates; k < sys->variables; k++)
        multiplier[sys->variable[k].symbol] = 1;
    bool of_multipliers = false;
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, sys->restriction, sys->restrictions);
    for (int i = 0; i < cone.count; i++)
        of_multipliers |= expr_op_of(st, cone.list[i]) == EXPR_SYM && multiplier[st->node[cone.list[i]].a];
    expr_cone_clear(&cone);
    if (of_multipliers)
        return true;
    j->err = err;
    return answer_mechanical(j);
}

bool strata_enter(struct job *j, struct stratum *s, struct strata_frame *f, struct sga_error *err)
{
    if (!strata_case_make(&f->part, &j->request->system, j->request->mechanical, s, err))
        return false;
    assert(j->place.inside <= j->place.depth && (!j->place.is_case || j->place.part));
    f->keep = *j;
    *j = fresh(j, err);
    j->place.depth++;
    j->place.above = &f->keep;
    j->place.is_case = s->part.puts > 0;
    j->place.inside = f->keep.place.inside + !j->place.is_case;
    j->place.part = j->place.is_case ? &s->part : f->keep.place.part;
    j->place.on_part = f->keep.place.on_part || strata_is_part(s);
    f->request = *j->request;
    j->request->system = f->part.system;
    if (f->part.mechanical.mass)
        j->request->mechanical = &f->part.mechanical;
    j->request->name = NULL;
    return true;
}

void strata_leave(struct job *j, struct strata_frame *f)
{
    assert(j->place.above == &f->keep && f->request.store.nodes <= j->request->store.nodes);
    job_clear(j);
    f->part.system = j->request->system;
    strata_case_clear(&f->part);
    f->request.store = j->request->store;      /* it grew */
    *j = f->keep;
    *j->request = f->request;
}

static void solve_one(struct job *j, struct stratum *s, int number)
{
    struct strata_frame f;
    struct stratum *sibling = j->strata.at;
    if (!strata_enter(j, s, &f, &s->error)) {
        s->state = STRATUM_UNSOLVED;
        if (s->part.wheres)
            cases_sample(&j->request->system, &s->part, NULL, 0, &s->sample);
        return;
    }
    j->request->want &= REQUEST_CONSTRAINTS | REQUEST_INDEX | REQUEST_VECTOR_FIELD | REQUEST_GAUGE;
    if (s->part.puts)
        j->place.parameter_case = j->strata.tree->cases;
    answer_stratum(j, sibling, s, number);
    if (s->part.wheres)
        cases_sample(&f.request.system, &s->part, j->place.not_zero, j->place.not_zeros, &s->sample);
    strata_leave(j, &f);
    if (!expr_store_ok(&j->request->store)) {      /* what is known already can still be written */
        if (s->error.code == SGA_E_OK)
            s->error = *j->request->store.error;
        s->state = STRATUM_UNSOLVED;
        *j->request->store.error = (struct sga_error){ 0 };
    }
    j->strata.tree->cancelled |= s->error.code == SGA_E_CANCELLED;
}

static void tree_clear(struct strata_tree *tree)
{
    for (int i = 0; i < tree->count; i++) {
        free(tree->reached[i].key);
        sga_buf_free(&tree->reached[i].where);
    }
    free(tree->reached);
}

static void refuse(struct stratum *s, const char *what, int limit)
{
    s->state = STRATUM_UNSOLVED;
    sga_fail(&s->error, SGA_E_LIMIT_STRATA, "not solved: the limit of %d %s was reached; give its functions in restrict "
             "to solve it by itself", limit, what);
}

static void undescribed(struct stratum *s)
{
    s->state = STRATUM_UNSOLVED;
    sga_fail(&s->error, SGA_E_NOT_SUPPORTED, "not solved: what vanishes there is too long to be written out as a restriction; give functions that say "
             "where it is in restrict");
}

bool answer_strata_solve(struct job *j)
{
    struct strata_tree own = { 0 };
    bool top = !j->strata.tree;
    if (!j->request->strata || !texts_written(j))
        return true;
    stage_begin(j->clock, STAGE_STRATA);
    if (top) {
        j->strata.tree = &own;
        own.restrictions = j->request->system.restrictions;
        note_set(j, key_of(j), 0, -1);
    }
    int number = ++j->strata.tree->lists;
    for (int i = 0; i < j->strata.count && !j->strata.tree->cancelled; i++) {
        struct stratum *s = j->strata.at + i;
        if (strcmp(s->kind, "excess") == 0)      /* no solution: that was asked of its point */
            continue;
        if (!strata_solvable(s) && !strata_is_part(s)) {
            if (!s->wheres)
                undescribed(s);
            continue;
        }
        bool is_case = s->part.wheres > 0;
        if (!is_case && j->place.inside >= DEPTH) {
            refuse(s, "strata inside each other", DEPTH);
            sga_limit_met(j->budget, SGA_LIMIT_STRATA_INSIDE);
        } else if (is_case ? j->strata.tree->cases++ >= MOST_CASES : j->strata.tree->solved++ >= MOST) {
            refuse(s, is_case ? "cases of parameters" : "strata", is_case ? MOST_CASES : MOST);
            sga_limit_met(j->budget, is_case ? SGA_LIMIT_CASES_SOLVED : SGA_LIMIT_STRATA_SOLVED);
        } else {
            solve_one(j, s, number);
        }
    }
    bool cancelled = j->strata.tree->cancelled;
    for (int i = 0; i < j->strata.count && !cancelled; i++)
        assert(stratum_sane(j->strata.at + i));
    if (cancelled)
        sga_fail(j->err, SGA_E_CANCELLED, "the job was cancelled");
    if (top) {
        tree_clear(&own);
        j->strata.tree = NULL;
    }
    return !cancelled;
}
