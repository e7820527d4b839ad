/* What is asked at each set of a sweep beside its trajectory. See sets.h. */
#include "sets.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "ask.h"
#include "budget.h"
#include "buf.h"
#include "error.h"
#include "request.h"
#include "run_job.h"
#include "set_job.h"
#include "sweep.h"
#include "sweep_team.h"
#include "write.h"

static const unsigned ASKED = REQUEST_OF_SETS & ~(unsigned)REQUEST_TRAJECTORY;

/* Sensitivities are those of a motion of the set's own. */
static unsigned asked(const struct job *j)
{
    unsigned motion = j->request->want & REQUEST_TRAJECTORY && j->request->trajectory.sensitivities.has ? REQUEST_TRAJECTORY : 0;
    return (j->request->want & ASKED) | motion;
}

bool answer_sets_are_asked(const struct job *j)
{
    return j->request->sweeps && asked(j) && !j->place.depth;
}

static void write_raw(struct sga_json *w, const char *name, const char *text, size_t length)
{
    if (!length)
        return;
    sga_json_key(w, name);
    sga_json_raw(w, text, length);
}

static void write_asked(const struct job *own, struct sga_json *w)
{
    if (own->fit)
        write_raw(w, "fit", own->fit, strlen(own->fit));
    if (own->sensitivities)
        write_raw(w, "sensitivities", own->sensitivities, strlen(own->sensitivities));
    if (!own->ask)
        return;
    write_raw(w, "linearization", own->ask->linearization.data, own->ask->linearization.len);
    write_raw(w, "transfer", own->ask->transfer.data, own->ask->transfer.len);
    write_raw(w, "equilibria", own->ask->equilibria.data, own->ask->equilibria.len);
}

/* Sensitivities are left out of an answer that has a motion, where there is no time for them: here they are what is asked. */
static bool is_whole(struct set_job *s, unsigned want)
{
    return !(want & REQUEST_TRAJECTORY) || s->job.sensitivities
           || sga_fail(&s->err, SGA_E_LIMIT_SECONDS, "the limit of %g seconds ended before this set had its sensitivities; raise limits.seconds, or send fewer sets", s->job.budget->seconds);
}

struct sets { struct job *j; struct request_sets *text; };

static char *make_set(void *of, int set, struct sweep_left *left)
{
    const struct sets *all = of;
    struct job *j = all->j;
    const struct request_sweep *m = j->request->sweep + set;
    struct sga_buf out = { 0 };
    struct sga_json w;
    struct set_job s;
    bool ok = set_job_run(&s, j, all->text, set, asked(j)) && is_whole(&s, asked(j));
    sga_json_begin(&w, &out);
    if (ok) {
        sga_json_object(&w);
        sweep_write_set(j, m, NULL, &w);
        write_asked(&s.job, &w);
        sga_json_end_object(&w);
        left->found++;
    } else {
        left->late |= s.err.code == SGA_E_LIMIT_SECONDS;
        sweep_write_error(j, m, &w, &s.err);
    }
    bool goes_on = (s.err.code == SGA_E_LIMIT_SECONDS && left->found) || job_goes_on(j);      /* where the time ended, the sets that are left say so */
    set_job_end(&s);
    if (goes_on)
        return sga_buf_take(&out);
    sga_buf_free(&out);
    return NULL;
}

bool answer_sets(struct job *j)
{
    struct sweep_left left = { 0 };
    double deadline = job_shorten(j);
    bool alone = j->request->want & REQUEST_TRAJECTORY;        /* others help with that */
    struct sets all = { j, request_sets_new(j->request_text, j->request_length, j->err) };
    j->sets = all.text ? sweep_all(j, j->request->sweeps, alone, (struct sweep_maker){ &all, make_set }, &left) : NULL;
    request_sets_free(all.text);
    bool ok = j->sets && (left.found || !left.late || sweep_too_short(j));
    j->budget->deadline = deadline;
    if (ok || !j->sweep || !job_leaves_out(j, deadline, "/want", "what is asked at the sets"))
        return ok;
    free(j->sets);             /* trajectories are there */
    j->sets = NULL;
    return true;
}

void answer_sets_clear(struct job *j)
{
    free(j->sets);
}
