/* All stages of a Runge-Kutta step as one piece of machine code.
 *
 * The field's instructions are written out once for each stage; between them stand the sums x + h sum a k, two
 * variables at a time. A stage's state goes from its sum to the field in registers, and the field's values
 * to the next sum likewise: in memory each such way would cost more than the arithmetic does. The
 * operations and their order are those of the contract in base/stages.h, so results are the same to
 * the bit whether this runs or the stages one by one. */
#include "tape_stages.h"

#include <assert.h>
#include <float.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "exec.h"
#include "mem.h"
#include "tape.h"
#include "tape_code.h"
#include "tape_compiler.h"

/* Beyond so many instructions the code is no longer quick to fetch, and what it saves is little
 * against the field itself. */
enum { INSTRUCTIONS_MOST = 3000, VARIABLES_MOST = 40 };
/* What is where in `place`: h twice, what fields that are wrong are multiplied by, times, coefficients. */
enum { ASIDE_AT = 2, TIMES_AT = 4, COEFFICIENTS_AT = TIMES_AT + SGA_STAGES_MOST };

struct writer {
    struct compiler c;
    const struct sga_stages *plan;
    int n, s;                  /* variables; the present stage */
    size_t coefficient;        /* the place of its row's first */
    int h;                     /* the register of h, twice; NONE: in its place */
    int *first_use, *late_use; /* c.next before the first instruction, before the first that is not timed */
};

static int pairs(const struct writer *w) { return (w->n + 1) / 2; }
/* Of pair p of the stage before, while a register has it. */
static int fresh(const struct writer *w, int p) { return w->c.t->slots + p; }

/* The state at variables 2 p and 2 p + 1 into a register. */
static int sum(struct writer *w, int p)
{
    struct compiler *c = &w->c;
    struct x64 *x = &c->code;
    const struct sga_row *row = w->plan->row + w->s;
    int acc = compiler_register(c, NONE, NONE), last = row->count - 1;
    size_t j = 2 * (size_t)p, stride = w->plan->stride, a = w->coefficient;
    for (int m = 0; m < last; m++) {
        int to = m ? SCRATCH : acc;
        x64_pair_out(x, X64_PAIR_LOAD, to, (size_t)row->stage[m] * stride + j);
        x64_pair_input(x, X64_PAIR_MUL, to, a + 2 * (size_t)m);
        if (m)
            x64_pair(x, X64_PAIR_ADD, acc, SCRATCH);
    }
    if (last)
        x64_pair_input(x, X64_PAIR_MUL, acc, 0);
    x64_pair_out(x, last ? X64_PAIR_ADD : X64_PAIR_LOAD, acc, w->plan->x + j);
    x64_pair_input(x, X64_PAIR_LOAD, SCRATCH, a + 2 * (size_t)last);
    if (w->h != NONE)
        x64_pair(x, X64_PAIR_MUL, SCRATCH, w->h);
    else
        x64_pair_input(x, X64_PAIR_MUL, SCRATCH, 0);
    int k = p < OWN_SLOTS - 1 ? c->where[fresh(w, p)] : NONE;
    if (k != NONE)
        x64_pair(x, X64_PAIR_MUL, SCRATCH, k);
    else
        x64_pair_out(x, X64_PAIR_MUL, SCRATCH, (size_t)row->stage[last] * stride + j);
    x64_pair(x, X64_PAIR_ADD, acc, SCRATCH);
    if (k != NONE)
        compiler_release(c, k);
    return acc;
}

static bool wanted(const struct compiler *c, int slot)
{
    return c->next[slot] != NEVER || c->root[slot] != NONE;
}

/* An input of the field stands in this register. */
static void give(struct compiler *c, int reg, int slot)
{
    compiler_deliver(c, reg, slot);
    if (c->next[slot] == NEVER)
        return;
    compiler_bind(c, reg, slot);
    c->unsaved[slot] = 1;
}

static void state(struct writer *w)
{
    struct compiler *c = &w->c;
    int time = c->t->ninputs - 1;
    for (int p = 0; p < pairs(w); p++) {
        int low = 2 * p, high = low + 1, acc = sum(w, p);
        if (w->s >= w->plan->keep)
            x64_pair_out(&c->code, X64_PAIR_STORE, acc, w->plan->y + (size_t)(w->s - w->plan->keep) * w->plan->stride + (size_t)low);
        if (high < w->n && wanted(c, high)) {
            x64_move(&c->code, SCRATCH, acc);
            give(c, acc, low);
            int reg = compiler_register(c, acc, NONE);
            x64_move(&c->code, reg, SCRATCH);
            x64_pair(&c->code, X64_PAIR_HIGH, reg, reg);
            give(c, reg, high);
        } else {
            give(c, acc, low);
        }
    }
    if (w->h != NONE)
        compiler_release(c, w->h);
    w->h = NONE;
    if (wanted(c, time)) {
        int reg = compiler_register(c, NONE, NONE);
        x64_load_input(&c->code, reg, TIMES_AT + w->s);
        give(c, reg, time);
    }
}

static void value(struct compiler *c, int reg, int slot)
{
    if (c->where[slot] == NONE)
        compiler_load(c, reg, slot);
    else
        x64_move(&c->code, reg, c->where[slot]);
}

/* The field's values in pairs to k_s; the first ones stay in registers. */
static void store_field(struct writer *w)
{
    struct compiler *c = &w->c;
    const int *root = c->t->root;
    for (int p = 0; p < pairs(w); p++) {
        int to = compiler_register(c, NONE, NONE);
        value(c, to, root[2 * p]);
        if (2 * p + 1 < w->n)
            value(c, SCRATCH, root[2 * p + 1]);
        else
            x64_bitwise(&c->code, X64_XOR, SCRATCH, SCRATCH);
        x64_pair(&c->code, X64_PAIR_LOW, to, SCRATCH);
        if (w->plan->aside)
            x64_pair_input(&c->code, X64_PAIR_MUL, to, ASIDE_AT);
        x64_pair_out(&c->code, X64_PAIR_STORE, to, (size_t)w->s * w->plan->stride + 2 * (size_t)p);
        if (p < OWN_SLOTS - 1) {
            compiler_bind(c, to, fresh(w, p));
            c->next[fresh(w, p)] = 0;
        }
    }
    for (int r = 0; r < REGISTERS; r++)
        if (c->held[r] != NONE && c->held[r] < c->t->slots)
            compiler_release(c, r);
}

static void stage(struct writer *w)
{
    struct compiler *c = &w->c;
    const struct num_tape *t = c->t;
    /* at the time of the stage before, what depends on it alone is in its slots */
    bool again = c->timed && w->s > 1 && w->plan->c[w->s] == w->plan->c[w->s - 1];
    memcpy(c->next, again ? w->late_use : w->first_use, (size_t)t->slots * sizeof *c->next);
    memset(c->unsaved, 0, (size_t)t->slots);
    memset(c->delivered, 0, (size_t)t->nroots);
    c->rest_at = (w->s - 1) * (t->nroots - t->first_roots);
    state(w);
    for (int i = again ? t->ntimed : t->nstatic; i < t->ncode; i++)
        compiler_instruction(c, i);
    compiler_deliver_rest(c);
    if (c->timed && !again)
        x64_copy_input(&c->code, TIMES_AT + w->s, t->slots);
    store_field(w);
    w->coefficient += 2 * (size_t)w->plan->row[w->s].count;
}

/* h, times, and all coefficients, each of them twice. */
static double *parameters(const struct sga_stages *plan)
{
    double *place = sga_calloc(COEFFICIENTS_AT + 24 * (size_t)plan->count, sizeof *place), *at = place + COEFFICIENTS_AT;
    place[ASIDE_AT] = 1 + DBL_EPSILON;
    place[ASIDE_AT + 1] = 1 - DBL_EPSILON;
    for (int s = 1; s < plan->count; s++)
        for (int m = 0; m < plan->row[s].count; m++, at += 2)
            at[0] = at[1] = plan->row[s].a[m];
    return place;
}

/* h comes in register 0: it goes to its place for the later stages, and stays for the first. */
static void enter(struct writer *w)
{
    struct compiler *c = &w->c;
    w->h = 0;
    x64_pair(&c->code, X64_PAIR_LOW, w->h, w->h);
    x64_pair_input(&c->code, X64_PAIR_STORE, w->h, 0);
    compiler_bind(c, w->h, fresh(w, OWN_SLOTS - 1));
    c->next[fresh(w, OWN_SLOTS - 1)] = 0;
}

static bool compile(struct num_tape *t, bool aside)
{
    struct tape_stages *q = t->stages[aside];
    struct writer w = { .plan = &q->plan, .n = t->first_roots, .coefficient = COEFFICIENTS_AT };
    compiler_begin(&w.c, t);
    w.c.stages = true;
    compiler_look(&w.c);
    size_t slots = (size_t)t->slots;
    w.first_use = sga_malloc(2 * slots * sizeof *w.first_use);
    w.late_use = w.first_use + slots;
    compiler_find_uses(&w.c, t->ntimed);
    memcpy(w.late_use, w.c.next, slots * sizeof *w.late_use);
    compiler_find_uses(&w.c, t->nstatic);
    memcpy(w.first_use, w.c.next, slots * sizeof *w.first_use);
    q->needs_time = wanted(&w.c, t->ninputs - 1);
    x64_enter(&w.c.code);
    enter(&w);
    for (w.s = 1; w.s < q->plan.count; w.s++)
        stage(&w);
    x64_leave(&w.c.code);
    const void *at = sga_exec_add(t->memory, w.c.code.byte, w.c.code.count);
    if (at) {
        q->run = (void (*)(double *, double *, double *, double *, double))(uintptr_t)at;
        q->place = parameters(&q->plan);
    }
    free(w.first_use);
    compiler_end(&w.c);
    return at != NULL;
}

static void drop(struct num_tape *t, bool aside)
{
    struct tape_stages *q = t->stages[aside];
    if (!q)
        return;
    if (q->run)
        sga_exec_drop(t->memory, (const void *)(uintptr_t)q->run);
    free(q->place);
    free(q);
    t->stages[aside] = NULL;
}

void tape_stages_drop(struct num_tape *t)
{
    drop(t, false);
    drop(t, true);
}

static bool same(const struct sga_stages *a, const struct sga_stages *b)
{
    return a->row == b->row && a->count == b->count && a->stride == b->stride && a->x == b->x && a->y == b->y && a->keep == b->keep;
}

/* About what compiling costs, in steps that it makes faster. */
static long steps_before(int instructions, const struct sga_stages *plan, int n)
{
    return 60 + (plan->count - 1) * (instructions + 9 * (n + 1)) / 2;
}

bool num_tape_stages(struct num_tape *t, int first, const struct sga_stages *plan, struct sga_stage_code *code)
{
    assert(plan->count >= 1);
    struct tape_stages *q = t->stages[plan->aside];
    if (!q || !same(&q->plan, plan)) {
        drop(t, plan->aside);
        q = t->stages[plan->aside] = sga_calloc(1, sizeof *q);
        q->plan = *plan;
        q->refused = first > VARIABLES_MOST || first != t->ninputs - 1 || (plan->count - 1) * num_tape_length(t) > INSTRUCTIONS_MOST;
    }
    if (!q->run) {
        struct num_code one;
        if (q->refused || ++q->asked < steps_before(num_tape_length(t), plan, first) || !num_tape_code(t, first, &one))
            return false;
        q->refused = !compile(t, plan->aside);
        if (q->refused)
            return false;
    }
    assert(q->run && !q->refused);
    *code = (struct sga_stage_code){ .run = q->run, .slots = t->value, .place = q->place, .time = q->place + TIMES_AT, .needs_time = q->needs_time };
    return true;
}
