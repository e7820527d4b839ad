/* Lagrange's equations, with and without the second-order condition.
 *
 * With p = dL/dv, P = dp/dq and W = dp/dv, the equation i_X omega_L = dE_L reads
 *   along dq:  W v' + (P - P^T) q' = dL/dq - P^T v - dp/dt,   along dv:  W q' = W v,
 * and with q' = v its first part becomes  W v' = dL/dq - P v - dp/dt. */
#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "buf.h"
#include "derive.h"
#include "form.h"
#include "mem.h"
#include "signal.h"

struct motion {
    const struct form_lagrangian *in;
    struct sys_system *s;
    struct expr_store *st;
    struct expr_cone cone;
    unsigned char *active;     /* symbol -> coordinate or velocity */
    int *column;               /* symbol -> variable of the system */
    struct expr_term *term; size_t cap;
    expr_id *alpha;            /* of the row of q_i */
    int first, second;         /* row of the equation of q_0, and of v_0 (or q' = v) */
};

static void add_named_row(struct motion *m, const char *what, int symbol)
{
    SGA_ENDS(sga_buf_free) struct sga_buf source = { 0 };
    sga_buf_printf(&source, "%s %s", what, m->st->symbol[symbol].name);
    sys_add_row(m->s, expr_int(m->st, 0), source.data);
}

static void begin(struct motion *m)
{
    const struct form_lagrangian *in = m->in;
    m->active = sga_calloc((size_t)m->st->symbols + 1, 1);
    m->column = sga_calloc((size_t)m->st->symbols + 1, sizeof *m->column);
    m->alpha = sga_calloc((size_t)in->coordinates + 1, sizeof *m->alpha);
    for (int i = 0; i < in->coordinates; i++)
        sys_add_variable(m->s, in->coordinate[i], "variable");
    for (int i = 0; i < in->coordinates; i++)
        sys_add_variable(m->s, in->velocity[i], "velocity");
    for (int j = 0; j < m->s->variables; j++) {
        m->active[m->s->variable[j].symbol] = 1;
        m->column[m->s->variable[j].symbol] = j;
    }
    for (int i = 0; i < in->constraints; i++)
        sys_add_variable(m->s, in->multiplier[i], "multiplier");
    m->first = m->s->rows;
    for (int i = 0; i < in->coordinates; i++)
        add_named_row(m, "equation of", in->coordinate[i]);
    m->second = m->s->rows;
    for (int i = 0; i < in->coordinates; i++)
        add_named_row(m, in->second_order ? "definition of" : "equation of", in->velocity[i]);
}

/* momentum[i] = dL/dv_i; alpha[i] = dL/dq_i. */
static void differentiate_lagrangian(struct motion *m, expr_id *momentum)
{
    int n = m->in->coordinates;
    for (int i = 0; i < n; i++)
        momentum[i] = m->alpha[i] = expr_int(m->st, 0);
    int terms = expr_gradient(m->st, &m->cone, m->in->lagrangian, m->active, &m->term, &m->cap);
    for (int k = 0; k < terms; k++) {
        int j = m->column[m->term[k].symbol];
        *(j < n ? m->alpha + j : momentum + (j - n)) = m->term[k].value;
    }
}

/* alpha[i] -= value * v_j */
static void subtract_times_velocity(struct motion *m, expr_id *alpha, expr_id value, int j)
{
    *alpha = expr_sub(m->st, *alpha, expr_mul(m->st, value, m->st->symbol[m->in->velocity[j]].node));
}

/* What p_i puts into the rows: row i of W and P, column i of P^T. */
static void add_momentum(struct motion *m, int i, expr_id p)
{
    int n = m->in->coordinates;
    struct expr_store *st = m->st;
    int terms = expr_gradient(st, &m->cone, p, m->active, &m->term, &m->cap);
    for (int k = 0; k < terms; k++) {
        int col = m->column[m->term[k].symbol];
        expr_id value = m->term[k].value;
        if (col >= n) {
            sys_add_entry(m->s, m->first + i, col, value);
            if (!m->in->second_order) {
                sys_add_entry(m->s, m->second + i, col - n, value);
                expr_id *alpha = &m->s->row[m->second + i].alpha;
                *alpha = expr_add(st, *alpha, expr_mul(st, value, st->symbol[m->in->velocity[col - n]].node));
            }
        } else if (m->in->second_order) {
            subtract_times_velocity(m, m->alpha + i, value, col);
        } else {
            sys_add_entry(m->s, m->first + i, col, value);
            sys_add_entry(m->s, m->first + col, i, expr_neg(st, value));
            subtract_times_velocity(m, m->alpha + col, value, i);
        }
    }
    m->alpha[i] = expr_sub(st, m->alpha[i], expr_time_partial(st, p, m->s->time));
}

/* (dg/dq)^T lambda on the right, and the rows 0 = g. */
static void add_constraint(struct motion *m, int a)
{
    struct expr_store *st = m->st;
    SGA_ENDS(sga_buf_free) struct sga_buf source = { 0 };
    expr_id lambda = st->symbol[m->in->multiplier[a]].node;
    int terms = expr_gradient(st, &m->cone, m->in->constraint[a], m->active, &m->term, &m->cap);
    for (int k = 0; k < terms; k++) {
        expr_id *alpha = m->alpha + m->column[m->term[k].symbol];
        *alpha = expr_add(st, *alpha, expr_mul(st, m->term[k].value, lambda));
    }
    sga_buf_printf(&source, "holonomic[%d]", a);
    sys_add_row(m->s, m->in->constraint[a], source.data);
}

void form_lagrangian(struct sys_system *s, const struct form_lagrangian *in)
{
    assert(in->coordinates > 0 && in->constraints >= 0);
    struct motion m = { .in = in, .s = s, .st = s->store };
    SGA_FREED expr_id *momentum = sga_calloc((size_t)in->coordinates + 1, sizeof *momentum);
    expr_cone_init(&m.cone);
    begin(&m);
    differentiate_lagrangian(&m, momentum);
    for (int i = 0; i < in->coordinates; i++) {
        add_momentum(&m, i, momentum[i]);
        if (in->force)
            m.alpha[i] = expr_add(m.st, m.alpha[i], in->force[i]);
        if (in->second_order) {
            sys_add_entry(s, m.second + i, i, expr_int(m.st, 1));
            s->row[m.second + i].alpha = m.st->symbol[in->velocity[i]].node;
        }
    }
    for (int a = 0; a < in->constraints; a++)
        add_constraint(&m, a);
    for (int i = 0; i < in->coordinates; i++)
        s->row[m.first + i].alpha = m.alpha[i];
    s->square = true;
    expr_cone_clear(&m.cone);
    free(m.active);
    free(m.column);
    free(m.alpha);
    free(m.term);
}
