/* What a system's equations say of the sizes of its variables. */
#include "natural.h"

#include <assert.h>
#include <math.h>

#include "arena.h"
#include "scaling.h"
#include "system.h"

enum { NO_TIME = 10, FAR_TIME = 20, MOST_LOG = 900 };     /* log2 */

static void add_terms(struct scaling *w, const struct sys_system *sys)
{
    for (int i = 0; i < sys->rows; i++) {
        scaling_sum(w);
        scaling_add(w, sys->row[i].alpha, -1);
        for (int k = 0; k < sys->row[i].entries; k++)
            scaling_add(w, sys->row[i].entry[k].value, sys->row[i].entry[k].col);
    }
    for (int i = 0; i < sys->restrictions; i++) {
        scaling_sum(w);
        scaling_add(w, sys->restriction[i], -1);
    }
}

struct scaling *natural_scaling(const struct sys_system *sys, bool timed, bool even)
{
    SGA_ARENA(mem);
    int *variable = sga_take(&mem, ((size_t)sys->variables + 1) * sizeof *variable);
    for (int j = 0; j < sys->variables; j++)
        variable[j] = sys->variable[j].symbol;
    struct scaling *w = scaling_new(sys->store, variable, sys->variables);
    assert(!w == (sys->variables > SCALING_MOST));
    if (!w)
        return NULL;
    if (timed)
        scaling_time(w, sys->time);
    if (even)
        scaling_even(w);
    add_terms(w, sys);
    return w;
}

int *natural_sizes(const struct sys_system *sys, double *unit)
{
    *unit = 0;
    if (sys->variables > SCALING_MOST)
        return NULL;
    SGA_ARENA(mem);
    double *log = sga_take(&mem, ((size_t)sys->variables + 2) * sizeof *log);
    struct scaling *timed = natural_scaling(sys, true, true), *plain = natural_scaling(sys, false, true);
    scaling_logs(timed, log);
    double e = log[sys->variables];
    bool far = fabs(e) >= FAR_TIME;
    if (fabs(e) >= NO_TIME && scaling_has_time(timed))
        *unit = ldexp(1, (int)lrint(fmax(-MOST_LOG, fmin(MOST_LOG, e))));
    int *scale = far ? scaling_rounded(log, sys->variables) : scaling_solve(plain);
    scaling_free(timed);
    scaling_free(plain);
    return scale;
}
