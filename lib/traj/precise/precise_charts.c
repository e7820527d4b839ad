/* Motions in double-double that go over to other charts (charts.h): each has programs of its own, made when it is entered first. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "charts.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "jet.h"
#include "manifold.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "switches.h"
#include "system.h"
#include "tape.h"

struct num_tape *precise_field(struct precise *p)
{
    struct field *f = p->flow->field;
    struct sga_error ignored = { 0 };
    int count = f->switches->count;
    if (!count)
        return f->plain;
    expr_id *root = sga_malloc((size_t)(p->n + count) * sizeof *root);
    memcpy(root, f->root, (size_t)p->n * sizeof *root);
    memcpy(root + p->n, f->switches->argument, (size_t)count * sizeof *root);
    int *inputs = field_inputs(p->sys);
    struct num_tape *tape = num_tape_new_switched(p->sys->store, f->switches, root, p->n + count, inputs, p->n + 1, &ignored);
    free(inputs);
    free(root);
    return tape;
}

bool precise_follow_chart(struct precise *p)
{
    int to = p->flow->charts ? p->flow->charts->at : 0;
    if (to == p->at)
        return false;
    int count = p->flow->charts->count, order = p->order;
    assert(to >= 0 && to < count && p->at < count);
    if (p->charts < count) {
        p->chart = sga_realloc(p->chart, (size_t)count * sizeof *p->chart);
        memset(p->chart + p->charts, 0, (size_t)(count - p->charts) * sizeof *p->chart);
        p->charts = count;
    }
    p->chart[p->at] = (struct precise_chart){ p->constraint, p->series, p->values, p->velocity, p->order, p->field };
    struct precise_chart *c = p->chart + to;
    if (!c->constraint)
        c->constraint = num_jet2_new(p->flow->manifold->tape, 1);
    c->field = c->field ? c->field : precise_field(p);
    if (p->event && !c->velocity)
        c->velocity = num_jet2_new(p->flow->field->plain, 0);
    if (c->order != order) {
        num_jet2_free(c->series);
        c->series = num_jet2_new(c->field, order);
    }
    p->constraint = c->constraint;
    p->series = c->series;
    p->values = c->values;
    p->velocity = c->velocity;
    p->order = order;
    p->field = c->field;
    p->at = to;
    return true;
}

void precise_charts_clear(struct precise *p)
{
    for (int k = 0; k < p->charts; k++) {
        struct precise_chart *c = p->chart + k;
        if (k == p->at)
            continue;
        num_jet2_free(c->constraint);
        num_jet2_free(c->series);
        num_jet2_free(c->values);
        num_jet2_free(c->velocity);
        if (p->flow->field->switches->count)
            num_tape_free(c->field);
    }
    free(p->chart);
    p->chart = NULL;
    p->charts = 0;
}
