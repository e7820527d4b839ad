/* Which equations determine what: each block of velocities traced back to the equations of the
 * request, with how often they were differentiated, and each determined initial value to the free ones. */
#include "structure_work.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "derive.h"
#include "mem.h"
#include "reduction.h"
#include "structure.h"
#include "system.h"
#include "warnings.h"

/* Tables of constraints by equations, and lists of free variables, up to this many members. */
static const size_t LARGEST = SGA_MOST_ORIGINS, LONGEST = SGA_MOST_FOLLOWED;

/* order[i * width + e]: how often equation e (restriction e - rows) is differentiated in constraint i; -1: not in it. */
struct orders {
    int rows, width;
    int *order;
    unsigned char *unknown;
};

/* The larger of what is there and what comes along, `more` times differentiated. */
static void raise_by(int *to, const int *from, int width, int more)
{
    for (int e = 0; e < width; e++)
        if (from[e] >= 0 && from[e] + more > to[e])
            to[e] = from[e] + more;
}

static void add_source(struct orders *o, int *to, unsigned char *unknown, int source)
{
    if (source < o->rows) {
        to[source] = to[source] < 0 ? 0 : to[source];
        return;
    }
    raise_by(to, o->order + (size_t)(source - o->rows) * (size_t)o->width, o->width, 1);
    *unknown |= o->unknown[source - o->rows];
}

static void trace(struct structure_work *w, struct orders *o)
{
    for (int i = 0; i < w->sol->constraints; i++) {
        const struct sga_constraint *c = w->sol->constraint + i;
        int *own = o->order + (size_t)i * (size_t)o->width;
        if (c->restriction >= 0)
            own[o->rows + c->restriction] = 0;
        if (c->source >= 0)
            add_source(o, own, o->unknown + i, c->source);
        for (int k = 0; k < c->parts; k++)
            add_source(o, own, o->unknown + i, c->part[k].row >= 0 ? c->part[k].row : o->rows + c->part[k].tangency);
        o->unknown[i] |= c->origin == SGA_FROM_ROWS && !c->parts;
    }
}

void structure_origins(struct structure_work *w, struct structure *out)
{
    int rows = w->sys->rows, c = w->sol->constraints, n = w->sys->variables, count = 0;
    struct orders o = { .rows = rows, .width = rows + w->sys->restrictions };
    size_t cap = 0;
    if ((size_t)(c + 1) * (size_t)(o.width + 1) > LARGEST || (size_t)(out->blocks + 1) * (size_t)(o.width + 1) > LARGEST) {
        sga_limit_met(w->budget, SGA_LIMIT_ORIGINS);
        return;
    }
    SGA_ARENA(mem);
    o.order = sga_take(&mem, (size_t)(c + 1) * (size_t)(o.width + 1) * sizeof *o.order);
    memset(o.order, 0xff, (size_t)(c + 1) * (size_t)(o.width + 1) * sizeof *o.order);      /* all -1 */
    o.unknown = sga_zeros(&mem, (size_t)c + 1, 1);
    trace(w, &o);
    assert(o.width >= rows);
    int *own = sga_take(&mem, ((size_t)out->blocks + 1) * ((size_t)o.width + 1) * sizeof *own);
    memset(own, 0xff, ((size_t)out->blocks + 1) * ((size_t)o.width + 1) * sizeof *own);
    out->origin_unknown = sga_zeros(&out->mem, (size_t)out->blocks + 1, 1);
    out->origin_first = sga_zeros(&out->mem, (size_t)out->blocks + 2, sizeof *out->origin_first);
    for (int j = 0; j < n; j++)
        if (out->block[j] >= 0)
            add_source(&o, own + (size_t)out->block[j] * (size_t)o.width, out->origin_unknown + out->block[j], out->matched[j]);
    SGA_RESERVE_IN(&out->mem, out->origin, cap, 1);
    for (int b = 0; b < out->blocks; b++) {
        const int *at = own + (size_t)b * (size_t)o.width;
        for (int e = 0; e < o.width; e++) {
            if (at[e] < 0)
                continue;
            SGA_RESERVE_IN(&out->mem, out->origin, cap, count + 1);
            out->origin[count++] = (struct structure_origin){ e < rows ? e : -1, e < rows ? -1 : e - rows, at[e] };
        }
        out->origin_first[b + 1] = count;
    }
    assert(out->origin_first[out->blocks] == count);
}

/* Through the constraints that the other variables in a constraint are solved for with. */
void structure_follow(struct structure_work *w, struct structure *out)
{
    int n = w->sys->variables, c = w->sol->constraints, count = 0, edges = 0, done = 0;
    size_t cap = 0, edge_cap = 0;
    if (!out->has_initial)
        return;
    SGA_ARENA(mem);
    int *by = sga_take(&mem, ((size_t)n + 1) * sizeof *by), *seen = sga_zeros(&mem, (size_t)n + 1, sizeof *seen);
    int *stack = sga_take(&mem, ((size_t)n + 1) * sizeof *stack), *first = sga_zeros(&mem, (size_t)c + 2, sizeof *first);
    SGA_FREED int *edge = NULL;
    SGA_FREED struct expr_term *term = NULL;
    size_t term_cap = 0;
    for (int j = 0; j < n; j++)
        by[j] = -1;
    for (int i = 0; i < c; i++) {
        by[out->solved_for[i]] = i;
        int terms = expr_gradient(w->sys->store, &w->cone, w->sol->constraint[i].expr, w->active, &term, &term_cap);
        for (int k = 0; k < terms; k++) {
            SGA_RESERVE(edge, edge_cap, edges + 1);
            edge[edges++] = w->column[term[k].symbol];
        }
        first[i + 1] = edges;
    }
    out->follow_first = sga_zeros(&out->mem, (size_t)c + 2, sizeof *out->follow_first);
    SGA_RESERVE_IN(&out->mem, out->follow, cap, 1);
    for (int i = 0; i < c && (size_t)count < LONGEST && sga_budget_ok(w->budget, NULL); i++) {
        int top = 0;
        stack[top++] = out->solved_for[i];
        seen[out->solved_for[i]] = i + 1;
        while (top) {
            int v = stack[--top], k = by[v];
            if (k < 0) {
                SGA_RESERVE_IN(&out->mem, out->follow, cap, count + 1);
                out->follow[count++] = v;
            }
            for (int q = k < 0 ? 0 : first[k]; q < (k < 0 ? 0 : first[k + 1]); q++)
                if (seen[edge[q]] != i + 1) {
                    seen[edge[q]] = i + 1;
                    stack[top++] = edge[q];
                }
        }
        out->follow_first[i + 1] = count;
        done = i + 1;
    }
    assert(done <= c && out->follow_first[done] == count);
    if (done < c) {              /* broken off */
        sga_limit_met(w->budget, SGA_LIMIT_FOLLOWED);
        out->follow = NULL;
    }
}
