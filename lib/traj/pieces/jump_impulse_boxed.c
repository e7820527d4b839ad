/* Velocities after an impulse, in balls: M (v+ - v) = J^T mu where they are free, the constraints on velocities at v+ (jump_impulse.h), by interval Newton. */
#include <math.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "error.h"
#include "field.h"
#include "jump_boxed_between.h"
#include "jump_impulse.h"
#include "jump_impulse_parts.h"
#include "mem.h"
#include "system.h"
#include "tables_ahead.h"

/* Of its length: what a gradient has beside those before it. */
static const double BESIDE = 1e-9;

struct striking {
    struct impulse p;
    const struct jump *j;
    const struct traj_mass *m;
    const struct jump_to *landed;
    const struct enc_tables *tables;
    bool *use;                    /* by condition: it does not follow from those before it */
    int *symbol; int all;         /* variables; velocities before; multipliers */
    expr_id *function; int functions;
    arb_ptr found;                /* velocities before, multipliers */
    struct sga_arena mem;
};

/* Conditions whose gradients, at free velocities, are independent as far as doubles tell. */
static void choose(struct striking *s)
{
    int n = s->p.coordinates, c = s->p.conditions;
    double *row = sga_zeros(&s->mem, (size_t)c * (size_t)n + 1, sizeof *row);
    for (int i = 0; i < c; i++) {
        double *r = row + (size_t)i * (size_t)n, size = 0, left = 0;
        for (int k = 0; k < n; k++) {
            r[k] = s->landed->changed[s->m->velocity[k]] ? 0 : s->p.J[(size_t)i * (size_t)n + (size_t)k];
            size = hypot(size, r[k]);
        }
        for (int b = 0; b < i; b++) {
            double along = 0;
            for (int k = 0; k < n && s->use[b]; k++)
                along += r[k] * row[(size_t)b * (size_t)n + (size_t)k];
            for (int k = 0; k < n && s->use[b]; k++)
                r[k] -= along * row[(size_t)b * (size_t)n + (size_t)k];
        }
        for (int k = 0; k < n; k++)
            left = hypot(left, r[k]);
        s->use[i] = left > BESIDE * size;
        for (int k = 0; k < n && s->use[i]; k++)
            r[k] /= left;
    }
}

/* Masses, conditions and gradients as doubles, where double has landed. */
static bool look(struct striking *s, double t)
{
    memcpy(s->p.in, s->landed->x, (size_t)s->p.n * sizeof *s->p.in);
    s->p.in[s->p.n] = t;
    if (!jump_impulse_look(&s->p))
        return false;
    jump_impulse_matrices(&s->p, s->m);
    return true;
}

static void name(struct striking *s)
{
    struct expr_store *st = s->j->sys->store;
    SGA_FREED int *variable = field_inputs(s->j->sys);
    int n = s->j->n;
    s->all = n + s->p.coordinates + s->p.conditions;
    s->symbol = sga_take(&s->mem, ((size_t)s->all + 1) * sizeof *s->symbol);
    memcpy(s->symbol, variable, (size_t)n * sizeof *s->symbol);
    for (int i = 0; i < s->p.coordinates; i++)
        s->symbol[n + i] = enclosed_symbol(st, "velocity before", i);
    for (int i = 0; i < s->p.conditions; i++)
        s->symbol[n + s->p.coordinates + i] = enclosed_symbol(st, "impulse of condition", i);
}

static expr_id node(const struct striking *s, int place)
{
    return s->j->sys->store->symbol[s->symbol[place]].node;
}

static void write(struct striking *s)
{
    struct expr_store *st = s->j->sys->store;
    const struct traj_mass *m = s->m;
    int n = s->j->n;
    s->function = sga_take(&s->mem, ((size_t)s->all + 1) * sizeof *s->function);
    for (int i = 0; i < s->p.coordinates; i++) {
        expr_id sum = expr_int(st, 0);
        if (s->landed->changed[m->velocity[i]])
            continue;
        for (int k = 0; k < m->entries; k++)
            if (m->row[k] == i)
                sum = expr_add(st, sum, expr_mul(st, m->value[k], expr_sub(st, node(s, m->velocity[m->col[k]]), node(s, n + m->col[k]))));
        for (int k = 0; k < s->p.terms; k++)
            if (s->p.col[k] == i && s->use[s->p.row[k]])
                sum = expr_sub(st, sum, expr_mul(st, s->p.root[m->entries + s->p.conditions + k], node(s, n + s->p.coordinates + s->p.row[k])));
        s->function[s->functions++] = sum;
    }
    for (int i = 0; i < s->p.conditions; i++)
        if (s->use[i])
            s->function[s->functions++] = s->p.root[m->entries + i];
}

static bool strike(struct striking *s, const arb_t t, slong prec, arb_ptr x)
{
    int n = s->j->n, unknowns = 0;
    struct sga_error ignored = { 0 };
    unsigned char *solved = sga_zeros(&s->mem, (size_t)s->all + 1, 1);
    arb_ptr u = arbs_take(&s->mem, s->all);
    _arb_vec_set(u, x, n);
    for (int i = 0; i < s->p.coordinates; i++) {
        int v = s->m->velocity[i];
        arb_set(u + n + i, x + v);
        solved[v] = !s->landed->changed[v];
        if (solved[v])
            arb_set_d(u + v, s->landed->x[v]);
    }
    for (int i = 0; i < s->p.conditions; i++)
        solved[n + s->p.coordinates + i] = s->use[i];
    s->found = u + n;
    for (int i = 0; i < s->all; i++)
        unknowns += solved[i];
    struct enclose_problem q = { .st = s->j->sys->store, .variable = s->symbol, .n = s->all, .time = s->j->sys->time, .tables = s->tables, .budget = s->j->rq->budget };
    bool ok = unknowns == s->functions && expr_store_ok(q.st) && (!unknowns || enclose_zero(&q, s->function, s->functions, t, solved, prec, u, &ignored));
    if (ok)
        _arb_vec_set(x, u, n);
    return ok;
}

/* What derivatives need of it, in the event's memory. */
static void keep(const struct striking *s, struct between *w)
{
    int n = s->p.coordinates, c = s->p.conditions;
    w->struck = (struct boxed_struck){ arbs_take(w->mem, n), arbs_take(w->mem, c), sga_zeros(w->mem, (size_t)c + 1, sizeof(bool)) };
    _arb_vec_set(w->struck.v0, s->found, n);
    _arb_vec_set(w->struck.mu, s->found + n, c);
    memcpy(w->struck.use, s->use, (size_t)c * sizeof(bool));
}

bool jump_impulse_boxed(struct between *w, arb_ptr x)
{
    struct striking s = { .j = w->to, .m = w->to->rq->mass, .landed = w->landed, .tables = &w->ahead->balls };
    struct sga_error ignored = { 0 };
    bool ok = w->tables && jump_impulse_init(&s.p, w->to, &ignored);
    if (ok && s.p.conditions) {
        s.use = sga_zeros(&s.mem, (size_t)s.p.conditions + 1, sizeof *s.use);
        ok = look(&s, arf_get_d(arb_midref(&w->b->t), ARF_RND_NEAR));
        if (ok) {
            choose(&s);
            name(&s);
            write(&s);
            ok = strike(&s, &w->b->t, w->b->piece.prec, x);
        }
        if (ok)
            keep(&s, w);
    }
    jump_impulse_clear(&s.p);
    sga_arena_end(&s.mem);
    return ok;
}
