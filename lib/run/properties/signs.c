/* For which values of the symbolic parameters the final set has real points. The reduction
 * holds wherever it has any; y^2 + a = 0 has none where a is positive. Points are looked for at
 * values of both signs: what is found is evidence and said as such, not a proof. */
#include "run_job.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "derive.h"
#include "facts.h"
#include "points_random.h"
#include "properties.h"
#include "reduction.h"
#include "request.h"
#include "seeds.h"
#include "set_points.h"
#include "stage_clock.h"
#include "system.h"
#include "warnings.h"

enum { DRAWS = 16, MOST_PARAMETERS = SGA_MOST_SIGN_PARAMETERS, MOST_VARIABLES = SGA_MOST_SIGN_VARIABLES };

struct draws {
    double value[DRAWS][MOST_PARAMETERS];
    bool found[DRAWS];
    int count, missed;
};

/* Whether each constraint can be solved for a variable that no earlier one contains, with a slope that is never 0: then
 * the set has points whatever the parameters are. */
static bool has_points_always(const struct job *j)
{
    const struct sys_system *sys = &j->request->system;
    struct expr_store *st = sys->store;
    SGA_ARENA(mem);
    unsigned char *fresh = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    struct expr_term *term = NULL;
    size_t cap = 0;
    struct expr_facts facts;
    struct expr_cone cone;
    bool always = true;
    expr_facts_init(&facts);
    expr_cone_init(&cone);
    for (int i = 0; i < sys->variables; i++)
        fresh[sys->variable[i].symbol] = 1;
    for (int i = 0; i < j->solution->constraints && always; i++) {
        expr_id e = j->solution->constraint[i].expr;
        int n = expr_gradient(st, &cone, e, fresh, &term, &cap);
        always = false;
        for (int k = 0; k < n && !always; k++)
            always = expr_facts_of(&facts, st, term[k].value) & EXPR_NONZERO && !expr_depends(st, &cone, term[k].value, term[k].symbol);
        expr_cone_of(st, &cone, &e, 1);
        for (int k = 0; k < cone.count; k++)
            if (expr_op_of(st, cone.list[k]) == EXPR_SYM)
                fresh[st->node[cone.list[k]].a] = 0;
    }
    free(term);
    expr_facts_clear(&facts);
    expr_cone_clear(&cone);
    return always;
}

static bool has_parameter(const struct job *j)
{
    const struct sys_system *sys = &j->request->system;
    struct expr_cone cone;
    bool has = false;
    expr_cone_init(&cone);
    for (int i = 0; i < j->solution->constraints && !has; i++) {
        expr_cone_of(sys->store, &cone, &j->solution->constraint[i].expr, 1);
        for (int k = 0; k < cone.count && !has; k++)
            for (int q = 0; q < sys->parameters && !has; q++)
                has = cone.list[k] == sys->store->symbol[sys->parameter[q]].node;
    }
    expr_cone_clear(&cone);
    return has;
}

/* Whether the final set has a point at values of the parameters. False in *asked where there
 * was no time to find out. */
static bool point_at(struct job *j, const double *value, uint64_t *random, bool *asked)
{
    struct set_points on;
    struct points_point p;
    set_points_init(&on, &j->request->system, j->solution, j->solution->constraints, 0, 0);
    on.space.parameter_value = value;
    on.space.near = j->start.x;
    on.space.near_time = j->start.time;
    on.space.budget = j->budget;
    enum points_status status = points_find_staged(&on.space, on.end, on.stages, 1, random, 64, &p);
    points_point_clear(&p);
    set_points_clear(&on);
    *asked = status != POINTS_STOPPED;
    return status == POINTS_OK || status == POINTS_IRREGULAR;
}

/* The first draw is positive throughout; signs are random then, sizes from 1/3 to 3. */
static bool draw(struct job *j, struct draws *d)
{
    uint64_t random = SGA_SEED_SIGNS;
    bool asked = true;
    int n = j->request->system.parameters;
    for (int k = 0; k < DRAWS && asked; k++) {
        for (int i = 0; i < n; i++) {
            double v = ldexp(round(exp(1.1 * (2 * points_uniform(&random) - 1)) * 0x1p20), -20);
            d->value[k][i] = k > 0 && points_uniform(&random) < 0.5 ? -v : v;
        }
        d->found[k] = point_at(j, d->value[k], &random, &asked);
        d->missed += !d->found[k];
        d->count++;
    }
    return asked;
}

/* The sign of parameter i that divides what was found from what was not; 0: none does. */
static int dividing_sign(const struct draws *d, int i)
{
    int s = 0;
    for (int k = 0; k < d->count; k++) {
        int here = (d->value[k][i] > 0 ? 1 : -1) * (d->found[k] ? 1 : -1);
        if (s && s != here)
            return 0;
        s = here;
    }
    return s;
}

static void write_values(struct job *j, struct sga_json *w, const char *key, const double *value)
{
    const struct sys_system *sys = &j->request->system;
    sga_json_key(w, key);
    sga_json_object(w);
    for (int i = 0; i < sys->parameters; i++)
        sga_json_member_double(w, sys->store->symbol[sys->parameter[i]].name, value[i]);
    sga_json_end_object(w);
}

static void write_draws(struct job *j, const struct draws *d)
{
    assert(d->missed > 0 && d->count > 0);
    const struct sys_system *sys = &j->request->system;
    struct sga_buf out = { 0 };
    struct sga_json json, *w = &json;
    int who = 0, sign = 0, yes = -1, no = -1;
    for (int i = 0; i < sys->parameters && !sign; i++) {
        sign = dividing_sign(d, i);
        who = sign ? i : who;
    }
    for (int k = 0; k < d->count; k++) {
        int *to = d->found[k] ? &yes : &no;
        *to = *to < 0 ? k : *to;
    }
    assert(no >= 0 && d->missed <= d->count);
    sga_json_begin(w, &out);
    sga_json_object(w);
    sga_json_member_string(w, "expression", sys->store->symbol[sys->parameter[who]].name);
    sga_json_member_string(w, "kind", sign > 0 ? "positive" : sign < 0 ? "negative" : "some_values");
    if (yes >= 0)
        write_values(j, w, "found_at", d->value[yes]);
    write_values(j, w, "not_found_at", d->value[no]);
    sga_json_end_object(w);
    j->signs = sga_buf_take(&out);
}

static void find_signs(struct job *j)
{
    const struct sys_system *sys = &j->request->system;
    struct draws d = { .count = 0 };
    if (sys->parameters && j->solution->verdict != SGA_INCONSISTENT && has_parameter(j)) {
        if (sys->parameters > MOST_PARAMETERS)
            sga_limit_met(j->budget, SGA_LIMIT_SIGN_PARAMETERS);
        if (sys->variables > MOST_VARIABLES)
            sga_limit_met(j->budget, SGA_LIMIT_SIGN_VARIABLES);
    }
    if (!sys->parameters || sys->parameters > MOST_PARAMETERS || sys->variables > MOST_VARIABLES
        || j->solution->verdict == SGA_INCONSISTENT || !has_parameter(j) || has_points_always(j))
        return;
    stage_begin(j->clock, STAGE_SIGNS);
    if (draw(j, &d) && d.missed)
        write_draws(j, &d);
}

bool answer_signs(struct job *j)
{
    find_signs(j);
    return job_goes_on(j);
}

void answer_signs_clear(struct job *j)
{
    free(j->signs);
}
