/* See events_of.h. */
#include "events_of.h"

#include "arena.h"
#include "form.h"
#include "mechanical_answer.h"
#include "request.h"
#include "run_job.h"
#include "system.h"
#include "trajectory.h"

const struct traj_event *events_of(const struct request *r, struct sga_arena *mem)
{
    const struct request_trajectory *t = &r->trajectory;
    struct traj_event *event = sga_zeros(mem, (size_t)t->events + 1, sizeof *event);
    for (int e = 0; e < t->events; e++) {
        const struct request_event *from = t->event + e;
        struct traj_set *set = sga_zeros(mem, (size_t)from->sets + 1, sizeof *set);
        for (int k = 0; k < from->sets; k++)
            set[k] = (struct traj_set){ from->set[k].variable, from->set[k].value };
        event[e] = (struct traj_event){ .expression = from->expression, .direction = from->direction, .stop = from->stop, .set = set, .sets = from->sets, .most = from->most };
    }
    return event;
}

bool events_set_any(const struct request *r)
{
    bool any = false;
    for (int e = 0; e < r->trajectory.events; e++)
        any |= r->trajectory.event[e].sets > 0;
    return any;
}

static int variable_of(const struct sys_system *s, int symbol)
{
    for (int k = 0; k < s->variables; k++)
        if (s->variable[k].symbol == symbol)
            return k;
    return -1;
}

const struct traj_mass *masses_of(const struct job *j, struct sga_arena *mem)
{
    const struct form_mechanical *in = j->request->mechanical;
    if (!in || !j->mechanical)
        return NULL;
    size_t n = (size_t)in->coordinates;
    int *variable = sga_zeros(mem, 2 * n + 2 * in->masses + 1, sizeof *variable), *row = variable + 2 * n, *col = row + in->masses;
    expr_id *value = sga_zeros(mem, in->masses + 1, sizeof *value);
    for (int k = 0; k < in->coordinates; k++) {
        variable[k] = variable_of(&j->request->system, in->coordinate[k]);
        variable[(int)n + k] = variable_of(&j->request->system, in->velocity[k]);
        if (variable[k] < 0 || variable[(int)n + k] < 0)
            return NULL;
    }
    for (size_t k = 0; k < in->masses; k++) {
        row[k] = in->mass[k].row;
        col[k] = in->mass[k].col;
        value[k] = in->mass[k].value;
    }
    struct traj_mass *m = sga_zeros(mem, 1, sizeof *m);
    *m = (struct traj_mass){ .position = variable, .velocity = variable + n, .coordinates = in->coordinates, .row = row, .col = col, .value = value, .entries = (int)in->masses,
                             .impulses = j->mechanical->determined && !j->request->system.restrictions };
    return m;
}
