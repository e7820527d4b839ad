/* The stage `linearization`: an object for each place. */
#include "ask.h"

#include "ask_work.h"
#include "error.h"
#include "linear_least.h"
#include "linear_symbolic.h"
#include "request.h"
#include "run_job.h"
#include "stage_clock.h"

/* anywhere: the answer must not depend on the point. */
static bool take(struct ask_work *s, const struct linearization *l, bool anywhere)
{
    struct job *j = s->j;
    struct linear_modes m = { .exact = false };
    if (anywhere && !l->everywhere)
        return sga_fail_at(j->err, SGA_E_MISSING_MEMBER, "/linearization", "the system, or an output, is not linear with constant coefficients: say where it is to be "
                           "linearized, by \"trajectory\" with \"initial\", or by linearization.at");
    bool ok = linear_modes_find(&m, l, j->budget, j->err);
    if (ok)
        linear_write(j, &s->ports, l, &m, !anywhere, &s->json);
    linear_modes_clear(&m);
    return ok;
}

static bool everywhere(struct ask_work *s)
{
    const struct request_linearization *l = &s->j->request->linearization;
    bool ok = true;
    if (l->symbolic)
        return linear_symbolic(s);
    if (l->at == REQUEST_AT_SAMPLES)
        return ask_at_samples(s);
    if (l->at == REQUEST_AT_START)
        return ask_at_start(s);
    for (int k = 0; k < l->places && ok; k++)
        ok = ask_at_values(s, l->place[k].time, l->place[k].initial, l->place[k].initials, false);
    return ok;
}

bool answer_linearization(struct job *j)
{
    struct ask_work s;
    stage_begin(j->clock, STAGE_LINEARIZATION);
    j->ask = j->ask ? j->ask : sga_zeros(&j->mem, 1, sizeof *j->ask);
    if (!ask_possible(j))
        return false;
    ask_begin(&s, j, &j->request->linearization.ports, &j->ask->linearization);
    s.take = take;
    if (!j->request->linearization.ports.says_inputs)
        ask_drop_determined(&s);
    sga_json_array(&s.json);
    bool ok = (!j->request->linearization.least_norm || linear_least_norm(&s)) && everywhere(&s);
    sga_json_end_array(&s.json);
    sga_arena_end(&s.mem);
    return ok;
}

void answer_ask_clear(struct job *j)
{
    if (j->ask) {
        sga_buf_free(&j->ask->linearization);
        sga_buf_free(&j->ask->transfer);
        sga_buf_free(&j->ask->equilibria);
        sga_buf_free(&j->ask->derivation);
        sga_buf_free(&j->ask->dirac);
    }
    j->ask = NULL;
}
