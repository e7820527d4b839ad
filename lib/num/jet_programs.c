/* Machine code of series kept from one jet to the next. */
#include "jet_programs.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "exec.h"
#include "jet.h"
#include "mem.h"

/* Motions of one sweep have a few orders; the rest of the memory is for what else becomes code. */
enum { KEPT = 8, KEPT_BYTES = 1 << 20 };

struct program {
    struct jet_machine machine;          /* its series without numbers */
    int inputs, roots, rows, count, fixed;
    struct jet_code *code;               /* owned, as root and flat */
    int *root;
    unsigned char *flat;
};

struct num_jet_programs {
    struct program at[KEPT];
    int count;
    size_t bytes;
};

struct num_jet_programs *num_jet_programs_new(void) { return sga_calloc(1, sizeof(struct num_jet_programs)); }

void num_jet_programs_free(struct num_jet_programs *p)
{
    for (int i = 0; p && i < p->count; i++) {
        struct program *q = p->at + i;
        sga_exec_drop(q->machine.memory, q->machine.base);
        free(q->machine.series.act);
        free(q->code);
        free(q->root);
        free(q->flat);
    }
    free(p);
}

static bool same(const void *a, const void *b, int n, size_t size) { return !n || memcmp(a, b, (size_t)n * size) == 0; }

static bool matches(const struct program *q, const struct jet_plan *p, int order, int count)
{
    return q->machine.series.most == order && q->machine.series.count == count && q->inputs == p->inputs && q->roots == p->roots && q->rows == p->rows
           && q->count == p->count && q->fixed == p->fixed && same(q->code, p->code, p->count, sizeof *p->code)
           && same(q->root, p->root, p->roots, sizeof *p->root) && same(q->flat, p->flat, p->rows, 1);
}

bool jet_programs_find(const struct num_jet_programs *kept, struct jet_machine *m, const struct jet_plan *p, int order, int count)
{
    const struct program *q = kept->at, *end = q + kept->count;
    while (q < end && !(q->machine.memory == m->memory && matches(q, p, order, count)))
        q++;
    if (q == end)
        return false;
    assert(q->machine.run && q->machine.series.act && !q->machine.series.memory);
    m->series = q->machine.series;
    m->base = q->machine.base;
    m->run = q->machine.run;
    return true;
}

static void *copy(const void *from, int n, size_t size)
{
    void *to = sga_malloc(((size_t)n + 1) * size);
    if (n)
        memcpy(to, from, (size_t)n * size);
    return to;
}

bool jet_programs_keep(struct num_jet_programs *kept, const struct jet_machine *m, const struct jet_plan *p)
{
    _Static_assert(sizeof(struct jet_code) == 10 * sizeof(int) + sizeof(enum expr_op), "steps are compared as bytes");
    assert(m->run && m->memory && !m->shared);
    if (kept->count == KEPT || m->bytes > KEPT_BYTES - kept->bytes)
        return false;
    struct program *q = kept->at + kept->count++;
    kept->bytes += m->bytes;
    *q = (struct program){ .machine = *m, .inputs = p->inputs, .roots = p->roots, .rows = p->rows, .count = p->count, .fixed = p->fixed,
                           .code = copy(p->code, p->count, sizeof *p->code), .root = copy(p->root, p->roots, sizeof *p->root),
                           .flat = copy(p->flat, p->rows, 1) };
    q->machine.series.memory = q->machine.series.slot = NULL;
    return true;
}
