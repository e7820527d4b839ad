/* Readable texts: each function in the lightest form that is cheap to find, with names for what is shared beyond a budget. */
#include "texts.h"

#include "display.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "form.h"
#include "run_job.h"
#include "job_texts.h"
#include "mechanical_answer.h"
#include "mem.h"
#include "poly.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "stage_clock.h"

/* Beyond so many nodes an answer is for programs: it is written as it arose. */
enum { INLINE_NODES = 400, MOST_NODES = 400000 };
/* Names may be heavier than the numbers that they stand for, by so much. */
static const double NAMES_SLACK = 1.25;

/* The roots: constraints, field, gauge fields, then (*values is where they begin) functions of mechanics, which
 * hold on a larger set. */
static expr_id *put_roots(struct job *j, int *count, int *values)
{
    const struct sga_solution *sol = j->solution;
    unsigned want = j->request->want;
    int n = j->request->system.variables, c = sol->constraints;
    bool field = sol->field && want & (REQUEST_VECTOR_FIELD | REQUEST_GAUGE | REQUEST_DERIVATION), gauge = field && sol->gauge && want & (REQUEST_GAUGE | REQUEST_DERIVATION);
    int roots = c + (field ? n : 0) + (gauge ? n * sol->free_columns : 0);
    struct mechanical_answer *mech = j->mechanical && j->mechanical->has_motion ? j->mechanical : NULL;
    int parts = mech ? j->request->mechanical->coordinates : 0;
    expr_id *root = sga_malloc((size_t)(roots + 4 * parts + 1) * sizeof *root);
    for (int i = 0; i < c; i++)
        root[i] = sol->constraint[i].expr;
    if (field)
        memcpy(root + c, sol->field, (size_t)n * sizeof *root);
    if (gauge)
        memcpy(root + c + n, sol->gauge, (size_t)n * (size_t)sol->free_columns * sizeof *root);
    *values = roots;
    if (mech) {
        const expr_id *part[4] = { mech->motion.total, mech->motion.tangent, mech->motion.orthogonal, mech->motion.reaction };
        mech->first_root = roots;
        for (int k = 0; k < 4; k++, roots += parts)
            memcpy(root + roots, part[k], (size_t)parts * sizeof *root);
    }
    assert(c <= *values && *values <= roots);
    j->texts->first_field = c;
    j->texts->first_gauge = c + n;
    *count = roots;
    return root;
}

/* What each constraint was divided by for its text, in the request's store: c = scale * text on older generations. */
static void keep_scales(struct display *d, const struct sheet *own, const struct sheet *s)
{
    struct job *j = d->j;
    struct expr_store *st = &j->request->store;
    int c = s->constraints;
    SGA_ARENA(mem);
    expr_id *back = sga_zeros(&mem, (size_t)d->st.symbols + 1, sizeof *back);
    assert(d->st.symbols <= st->symbols);     /* the display has the same ones under the same indices */
    for (int i = 0; i < d->st.symbols; i++)
        back[i] = st->symbol[i].node;
    j->texts->scale = sga_zeros(&j->mem, (size_t)c + 1, sizeof *j->texts->scale);
    j->texts->reduced = sga_zeros(&j->mem, (size_t)c + 1, sizeof *j->texts->reduced);
    for (int i = 0; i < c; i++) {
        struct sga_error before = *d->st.error, kept = *st->error;
        struct poly_limits limits = poly_limits_of(POLY_READ, j->budget);
        expr_id e = s->scale[i] ? s->scale[i] : expr_int(&d->st, 1), root = s->root[i];
        j->texts->reduced[i] = s->reduced[i];
        display_values(d, &e, 1);
        display_values(d, &root, 1);
        if (s != own && e && root) {          /* the same function up to a number */
            expr_id q = expr_div(&d->st, own->root[i], root);
            if (q && poly_normal(&d->st, q, &limits, &q))
                e = expr_mul(&d->st, e, q);
        }
        if (e && !expr_is_one(&d->st, e)) {
            expr_copy(st, &d->st, &e, 1, back);
            j->texts->scale[i] = e;
        }
        *d->st.error = before;
        *st->error = kept;
    }
}

/* False: the texts are too large, or have no value. */
static bool print(struct job *j, struct expr_store *st, const expr_id *root, int roots)
{
    struct expr_naming naming = { .prefix = "s", .inline_nodes = INLINE_NODES };
    return expr_print_named(st, root, roots, &naming, &j->texts->names);
}

static bool beautiful(struct job *j, const expr_id *root, int roots, int values)
{
    struct display d;
    struct sheet own, named;
    display_open(&d, j);
    SGA_ARENA(mem);
    expr_id *none = sga_zeros(&mem, (size_t)j->request->store.symbols + 1, sizeof *none);
    bool ok = display_sheet(&d, &own, &j->request->store, none, root, roots, j->solution->constraint, j->solution->constraints);
    own.on_set = values;
    if (ok) {
        display_choose(&d, &own);
        const struct sheet *best = &own;
        if (values == roots && display_by_name(&d, &own, &named)) {
            display_choose(&d, &named);
            best = (double)named.weight <= NAMES_SLACK * (double)own.weight ? &named : &own;
        }
        ok = expr_store_ok(&d.st) && print(j, &d.st, best->shown, roots);
        if (ok)
            keep_scales(&d, &own, best);
        if (values == roots)
            display_sheet_clear(&named);
    }
    display_sheet_clear(&own);
    display_close(&d);
    return ok;
}

bool answer_texts(struct job *j)
{
    if (!(j->request->want & (REQUEST_CONSTRAINTS | REQUEST_VECTOR_FIELD | REQUEST_GAUGE | REQUEST_DERIVATION)))
        return true;
    stage_begin(j->clock, STAGE_TEXTS);
    int roots, values;
    answer_texts_clear(j);
    j->texts = sga_zeros(&j->mem, 1, sizeof *j->texts);
    expr_id *root = put_roots(j, &roots, &values);
    j->texts->has = j->request->store.nodes <= MOST_NODES && beautiful(j, root, roots, values);
    if (!j->texts->has && job_has_left(j))
        j->texts->has = print(j, &j->request->store, root, roots);
    free(root);
    if (!j->texts->has)
        return sga_fail(j->err, SGA_E_LIMIT_RESULT, "the answer is too large to print (more than 16 MiB); "
                        "ask for less in want, for example [\"index\", \"trajectory\"]");
    if (!expr_store_ok(&j->request->store)) {
        *j->err = *j->request->store.error;
        return false;
    }
    return job_goes_on(j);
}

void answer_texts_clear(struct job *j)
{
    if (!j->texts)
        return;
    if (j->texts->has)
        expr_names_clear(&j->texts->names);
    j->texts = NULL;
}

bool texts_written(const struct job *j)
{
    return j->texts && j->texts->has;
}
