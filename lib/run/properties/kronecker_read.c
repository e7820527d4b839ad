/* Is the reduced system A x' = B x + c(t)? Coefficients of B are the gradient of the right side: one
 * that is constant belongs to a linear function, as long as the function is rational in the
 * variables (atan(x) + atan(1/x) and sign(x) have gradient 0 and are no constants). */
#include "kronecker.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "derive.h"
#include "error.h"
#include "facts.h"
#include "pencil.h"
#include "run_job.h"
#include "mem.h"
#include "poly.h"
#include "print.h"
#include "request.h"
#include "system.h"

struct linear_reader {
    struct job *j;
    struct kronecker_system *k;
    struct expr_facts facts;
    struct expr_cone cone;
    unsigned char *active;     /* by symbol: a variable */
    int *place;                /* by symbol: index of the variable */
    struct expr_term *term;
    size_t term_cap;
};

static bool refuse(struct kronecker_system *k, const char *source, const char *why)
{
    if (!k->reason[0])
        snprintf(k->reason, sizeof k->reason, "%s: %s", source, why);
    return false;
}

static bool refuse_text(struct linear_reader *r, const char *source, expr_id e, const char *why)
{
    struct sga_buf text = { 0 };
    char message[400];
    if (expr_print(&r->j->request->store, e, 200, &text))
        snprintf(message, sizeof message, "the coefficient %.200s %s", text.data, why);
    else
        snprintf(message, sizeof message, "a coefficient %s", why);
    sga_buf_free(&text);
    return refuse(r->k, source, message);
}

static expr_id simplified(struct linear_reader *r, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, r->j->budget);
    expr_id out;
    return poly_normal(&r->j->request->store, e, &limits, &out) ? out : e;
}

static bool add(struct linear_reader *r, int row, int col, bool b, expr_id value, const char *source)
{
    struct kronecker_system *k = r->k;
    const struct expr_store *st = &r->j->request->store;
    if (value && !expr_is_const(st, value))
        value = simplified(r, value);
    unsigned f = value ? expr_facts_of(&r->facts, st, value) : 0;
    if (!value)
        return refuse(k, source, "a coefficient is undefined");
    if (f & EXPR_HAS_VARIABLE)
        return refuse_text(r, source, value, "depends on the variables: the system is not linear");
    if (f & EXPR_HAS_TIME)
        return refuse_text(r, source, value, "depends on time: the system is linear, but not with constant coefficients");
    assert(row < k->rows && col >= 0 && col < k->cols);
    SGA_RESERVE(k->c, k->cap, (size_t)k->count + 1);
    k->c[k->count++] = (struct kronecker_coefficient){ row, col, b, value };
    return true;
}

/* Only + - * / and integer powers between the function and its variables. */
static bool rational(struct linear_reader *r, expr_id e)
{
    const struct expr_store *st = &r->j->request->store;
    bool ok = true;
    expr_cone_of(st, &r->cone, &e, 1);
    for (int i = 0; i < r->cone.count && ok; i++) {
        expr_id x = r->cone.list[i];
        enum expr_op op = expr_op_of(st, x);
        bool plain = op == EXPR_SYM || op == EXPR_ADD || op == EXPR_SUB || op == EXPR_MUL || op == EXPR_DIV
                  || op == EXPR_NEG || op == EXPR_POWI;
        ok = plain || !(expr_facts_of(&r->facts, st, x) & EXPR_HAS_VARIABLE);
    }
    return ok;
}

/* Its gradient, as a row of B. */
static bool right_side(struct linear_reader *r, int row, expr_id e, const char *source)
{
    struct expr_store *st = &r->j->request->store;
    if (!rational(r, e))
        e = simplified(r, e);
    if (!rational(r, e))
        return refuse(r->k, source, "not found to be linear in the variables");
    int n = expr_gradient(st, &r->cone, e, r->active, &r->term, &r->term_cap);
    for (int i = 0; i < n; i++)
        if (!add(r, row, r->place[r->term[i].symbol], true, r->term[i].value, source))
            return false;
    return true;
}

static bool read_rows(struct linear_reader *r)
{
    const struct sys_system *sys = &r->j->request->system;
    char source[64];
    for (int i = 0; i < sys->rows; i++) {
        const struct sys_row *row = sys->row + i;
        const char *name = row->source ? row->source : "a row";
        if (!job_has_left(r->j))
            return refuse(r->k, name, "the time limit was reached");
        for (int k = 0; k < row->entries; k++)
            if (!add(r, i, row->entry[k].col, false, row->entry[k].value, name))
                return false;
        if (!right_side(r, i, row->alpha, name))
            return false;
    }
    for (int i = 0; i < sys->restrictions; i++) {
        snprintf(source, sizeof source, "restrict[%d]", i);
        if (!right_side(r, sys->rows + i, sys->restriction[i], source))
            return false;
    }
    return true;
}

void kronecker_read(struct job *j, struct kronecker_system *k)
{
    struct expr_store *st = &j->request->store;
    const struct sys_system *sys = &j->request->system;
    struct linear_reader r = { .j = j, .k = k };
    struct sga_error before = *st->error;
    *k = (struct kronecker_system){ .rows = sys->rows + sys->restrictions, .cols = sys->variables };
    expr_facts_init(&r.facts);
    expr_cone_init(&r.cone);
    r.active = sga_calloc((size_t)st->symbols + 1, 1);
    r.place = sga_calloc((size_t)st->symbols + 1, sizeof *r.place);
    for (int i = 0; i < sys->variables; i++) {
        r.active[sys->variable[i].symbol] = 1;
        r.place[sys->variable[i].symbol] = i;
    }
    if (read_rows(&r) && !expr_store_ok(st))
        refuse(k, "the system", "the expressions grew too large");
    *st->error = before;
    free(r.term);
    free(r.place);
    free(r.active);
    expr_cone_clear(&r.cone);
    expr_facts_clear(&r.facts);
}

void kronecker_system_clear(struct kronecker_system *k)
{
    free(k->c);
    *k = (struct kronecker_system){ .count = 0 };
}

/* The coefficients' values, parameters replaced; constants are folded by the constructors. */
static void replaced(struct job *j, const struct kronecker_system *k, const fmpz *value, expr_id *root)
{
    struct expr_store *st = &j->request->store;
    const struct sys_system *sys = &j->request->system;
    for (int i = 0; i < k->count; i++)
        root[i] = k->c[i].value;
    if (!sys->parameters)
        return;
    SGA_ARENA(mem);
    expr_id *map = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *map);
    fmpq_t q;
    fmpq_init(q);
    for (int i = 0; i < sys->parameters; i++) {
        fmpz_set(fmpq_numref(q), value + i);
        map[sys->parameter[i]] = expr_fmpq(st, q);
    }
    expr_substitute(st, root, k->count, map);
    fmpq_clear(q);
}

bool kronecker_pencil(struct job *j, struct kronecker_system *k, const fmpz *value, struct pencil *p)
{
    struct expr_store *st = &j->request->store;
    struct sga_error before = *st->error;
    SGA_ARENA(mem);
    expr_id *root = sga_zeros(&mem, (size_t)k->count + 1, sizeof *root);
    bool ok = true;
    replaced(j, k, value, root);
    ok = expr_store_ok(st);
    if (!ok)
        refuse(k, "the system", "a coefficient is undefined where the parameters were tried");
    *st->error = before;
    pencil_init(p, k->rows, k->cols);
    for (int i = 0; i < k->count && ok; i++) {
        const struct kronecker_coefficient *c = k->c + i;
        ok = root[i] && expr_is_const(st, root[i]);
        if (ok) {
            pencil_add(c->b ? &p->B : &p->A, c->row, c->col, expr_const_value(st, root[i]));
            continue;
        }
        struct sga_buf text = { 0 };
        char message[400];
        expr_print(st, c->value, 200, &text);
        snprintf(message, sizeof message, "the coefficient %.200s is not a rational %s; the structure is computed by "
                 "exact rational arithmetic only", text.data ? text.data : "", j->request->system.parameters
                 ? "function of the parameters with rational coefficients" : "number");
        sga_buf_free(&text);
        const struct sys_system *sys = &j->request->system;
        refuse(k, c->row < sys->rows && sys->row[c->row].source ? sys->row[c->row].source : "restrict", message);
    }
    if (!ok) {
        pencil_clear(p);
        pencil_init(p, k->rows, k->cols);
    }
    return ok;
}
