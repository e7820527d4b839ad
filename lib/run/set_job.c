/* A set of a sweep as a request of its own. See set_job.h. */
#include "set_job.h"

#include <assert.h>

#include "stage_list.h"

bool set_job_run(struct set_job *s, struct job *of, const struct request_sets *texts, int k, unsigned want)
{
    assert(k >= 0 && k < of->request->sweeps);
    struct request *r = &s->request;
    *s = (struct set_job){ .job = { .request = r, .host = { .most_result = of->host.most_result }, .stages = of->stages, .stage = of->stage, .budget = of->budget, .clock = of->clock,
                                    .one_of_many = true } };
    s->job.warnings = &s->warnings;
    s->job.err = &s->err;
    request_sets_text(texts, k, &s->text);
    if (!request_read(r, s->text.data, s->text.len, &s->err))
        return false;
    s->job.request_text = s->text.data;
    s->job.request_length = s->text.len;
    r->want &= want;
    r->strata = false;
    r->store.max_nodes = of->request->store.max_nodes;
    r->store.deadline = of->request->store.deadline;
    r->store.seconds = of->request->store.seconds;
    return job_prepare(&s->job) && job_run(&s->job, false) && job_run(&s->job, true);
}

void set_job_end(struct set_job *s)
{
    job_clear(&s->job);
    request_clear(&s->request);
    sga_buf_free(&s->text);
}
