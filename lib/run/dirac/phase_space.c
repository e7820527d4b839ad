/* The request of the same system in phase space. */
#include "dirac.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "error.h"
#include "form.h"
#include "legendre.h"
#include "oracle.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "seeds.h"
#include "system.h"
#include "table.h"

/* Longer functions would not be read back within the limits of a request. */
enum { TEXT_BYTES = 200000 };

/* Names of the phase space, and the functions there, in a store. */
struct phase {
    struct job *j;
    const struct expr_store *st;
    const int *symbol; int n;      /* 2n */
    expr_id hamiltonian;
    const expr_id *primary; int primaries;
    bool says_form;                /* names that look like momenta of others: the form is written out */
};

static bool put_text(const struct phase *p, expr_id e, struct sga_json *w)
{
    if (expr_json(p->st, e, TEXT_BYTES, w))
        return true;
    return sga_fail_at(p->j->err, SGA_E_LIMIT_RESULT, "/want", "the Hamiltonian or a primary constraint is too long to be written");
}

/* omega(d/dq_i, d/dp_i) = 1. */
static void write_canonical(struct sga_json *w, int n)
{
    sga_json_key(w, "omega");
    sga_json_array(w);
    for (int i = 0; i < 2 * n; i++) {
        sga_json_array(w);
        for (int k = 0; k < 2 * n; k++)
            sga_json_int(w, (k == i + n) - (i == k + n));
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

static void write_numbers(struct sga_json *w, const char *key, const struct expr_table *u, bool values)
{
    sga_json_key(w, key);
    sga_json_array(w);
    for (int k = 0; k < u->knots; k++)
        sga_json_double(w, values ? u->piece[k][0] : u->time[k]);
    sga_json_end_array(w);
}

/* Those that the system names. To the algebra they are any functions of time; the samples only say where a start lies. */
static void write_tables(struct sga_json *w, const struct request *r)
{
    sga_json_key(w, "tables");
    sga_json_object(w);
    for (int k = 0; k < r->tables; k++) {
        if (!r->table[k].in_system)
            continue;
        sga_json_key(w, r->table[k].name);
        sga_json_object(w);
        write_numbers(w, "times", r->table[k].values, false);
        write_numbers(w, "values", r->table[k].values, true);
        sga_json_member_string(w, "interpolation", r->table[k].values->kind == EXPR_LINEAR ? "linear" : "cubic");
        sga_json_end_object(w);
    }
    sga_json_end_object(w);
}

/* Parameters that are symbols; those of the system hold the tables too. */
static void write_parameters(struct sga_json *w, const struct sys_system *sys)
{
    const struct expr_store *st = sys->store;
    sga_json_key(w, "parameters");
    sga_json_object(w);
    for (int k = 0; k < sys->parameters; k++) {
        if (st->symbol[sys->parameter[k]].kind == EXPR_SIGNAL)
            continue;
        sga_json_key(w, st->symbol[sys->parameter[k]].name);
        sga_json_null(w);
    }
    sga_json_end_object(w);
}

static bool write_request(const struct phase *p, struct sga_buf *out)
{
    const struct sys_system *sys = &p->j->request->system;
    const struct expr_store *from = &p->j->request->store;
    struct sga_json w;
    bool ok = true;
    sga_json_begin(&w, out);
    sga_json_object(&w);
    sga_json_key(&w, "system");
    sga_json_object(&w);
    sga_json_member_string(&w, "form", "hamiltonian");
    sga_json_member_string(&w, "time", from->symbol[sys->time].name);
    write_parameters(&w, sys);
    if (p->j->request->tables)
        write_tables(&w, p->j->request);
    sga_json_key(&w, "variables");
    sga_json_array(&w);
    for (int k = 0; k < 2 * p->n; k++)
        sga_json_string(&w, p->st->symbol[p->symbol[k]].name);
    sga_json_end_array(&w);
    if (p->says_form)
        write_canonical(&w, p->n);
    sga_json_key(&w, "hamiltonian");
    ok = put_text(p, p->hamiltonian, &w);
    if (p->primaries) {
        sga_json_key(&w, "restrict");
        sga_json_array(&w);
        for (int k = 0; k < p->primaries && ok; k++)
            ok = put_text(p, p->primary[k], &w);
        sga_json_end_array(&w);
    }
    sga_json_end_object(&w);
    sga_json_key(&w, "want");
    sga_json_array(&w);
    sga_json_string(&w, "index");
    sga_json_end_array(&w);
    sga_json_end_object(&w);
    return ok;
}

static bool of_hamiltonian(struct job *j, struct sga_buf *request)
{
    const struct form_hamiltonian *h = j->request->hamiltonian;
    struct phase p = { j, &j->request->store, h->variable, h->variables / 2, h->hamiltonian, h->restriction, h->restrictions, false };
    return write_request(&p, request);
}

/* The Lagrangian's symbols in a store of its own: coordinates with multipliers, velocities, momenta, and one that nothing uses. */
struct tangent {
    struct expr_store st;
    struct sga_arena mem;
    int *q, *v, *symbol;           /* symbol: q, p */
    expr_id *p, lagrangian;
    int n, root;
    bool renamed;                  /* a coordinate has the name of a momentum */
};

static int add_symbol(struct expr_store *st, const char *before, const char *name, const char *after)
{
    SGA_ENDS(sga_buf_free) struct sga_buf b = { 0 };
    sga_buf_printf(&b, "%s%s%s", before, name, after);
    while (expr_symbol_find(st, b.data, b.len) >= 0)
        sga_buf_puts(&b, "_");
    expr_symbol_add(st, b.data, EXPR_VARIABLE);
    return st->symbols - 1;
}

/* L + sum of lambda g, from the rows of the holonomic constraints. */
static void open_tangent(struct tangent *t, struct job *j)
{
    const struct sys_system *sys = &j->request->system;
    const struct expr_store *from = &j->request->store;
    int n = j->request->coordinates, multipliers = sys->variables - 2 * n, k = 0;
    *t = (struct tangent){ .n = n + multipliers };
    expr_store_init(&t->st);
    expr_copy_symbols(&t->st, from);
    t->st.max_nodes = from->max_nodes;
    t->st.max_bits = from->max_bits;
    t->st.deadline = from->deadline;
    t->st.seconds = from->seconds;
    t->q = sga_zeros(&t->mem, (size_t)t->n + 1, sizeof *t->q);
    t->v = sga_zeros(&t->mem, (size_t)t->n + 1, sizeof *t->v);
    t->p = sga_zeros(&t->mem, (size_t)t->n + 1, sizeof *t->p);
    t->symbol = sga_zeros(&t->mem, 2 * (size_t)t->n + 1, sizeof *t->symbol);
    expr_id *none = sga_zeros(&t->mem, (size_t)from->symbols + 1, sizeof *none);
    t->lagrangian = j->request->lagrangian;
    expr_copy(&t->st, from, &t->lagrangian, 1, none);
    for (int i = 0; i < t->n; i++) {
        t->q[i] = sys->variable[i < n ? i : n + i].symbol;
        t->v[i] = i < n ? sys->variable[n + i].symbol : add_symbol(&t->st, "", from->symbol[t->q[i]].name, "_rate");
        t->symbol[i] = t->q[i];
    }
    for (int i = 0; i < sys->rows; i++)
        if (strncmp(sys->row[i].source, "holonomic", 9) == 0 && k < multipliers) {
            expr_id g = sys->row[i].alpha;
            expr_copy(&t->st, from, &g, 1, none);
            t->lagrangian = expr_add(&t->st, t->lagrangian, expr_mul(&t->st, t->st.symbol[t->q[n + k++]].node, g));
        }
    assert(k == multipliers);       /* a constraint for each */
    for (int i = 0; i < t->n; i++) {
        t->symbol[t->n + i] = add_symbol(&t->st, "p_", from->symbol[t->q[i]].name, "");
        t->p[i] = t->st.symbol[t->symbol[t->n + i]].node;
        t->renamed |= t->st.symbol[t->symbol[t->n + i]].name[strlen(t->st.symbol[t->symbol[t->n + i]].name) - 1] == '_';
    }
    t->root = add_symbol(&t->st, "", "root", "_");
}

/* Points of the space of q, v and p: a system of these variables without an equation. */
static bool points_of_space(struct tangent *t, struct job *j, struct points_oracle *oracle, struct sga_solution *solution)
{
    struct reduction_options options = { .seed = SGA_SEED_REDUCTION, .budget = j->budget };
    struct sys_system space;
    sys_init(&space, &t->st);
    for (int i = 0; i < t->n; i++) {
        sys_add_variable(&space, t->q[i], "variable");
        sys_add_variable(&space, t->v[i], "variable");
        sys_add_variable(&space, t->symbol[t->n + i], "variable");
    }
    space.time = j->request->system.time;
    for (int k = 0; k < j->request->system.parameters; k++)
        sys_add_parameter(&space, j->request->system.parameter[k]);
    points_oracle_init(oracle, 20250101);
    bool ok = sga_reduce(&space, &options, oracle, solution, j->err);
    sys_clear(&space);
    return ok;
}

static void write_legendre(const struct tangent *t, const struct legendre *l, struct sga_buf *out)
{
    struct sga_json w;
    sga_json_begin(&w, out);
    sga_json_object(&w);
    sga_json_key(&w, "momenta");
    sga_json_object(&w);
    for (int i = 0; i < t->n; i++) {
        sga_json_key(&w, t->st.symbol[t->symbol[t->n + i]].name);
        expr_json(&t->st, l->momentum[i], 4000, &w);
    }
    sga_json_end_object(&w);
    sga_json_member_int(&w, "rank", l->rank);
    sga_json_member_bool(&w, "regular", l->rank == t->n);
    sga_json_key(&w, "hamiltonian");
    expr_json(&t->st, l->hamiltonian, 4000, &w);
    sga_json_end_object(&w);
}

static bool of_lagrangian(struct job *j, struct sga_buf *request, struct sga_buf *legendre)
{
    struct points_oracle oracle;
    struct sga_solution solution = { 0 };
    struct tangent t;
    struct legendre l;
    open_tangent(&t, j);
    bool ok = points_of_space(&t, j, &oracle, &solution);
    if (ok) {
        struct weak weak = { &t.st, &oracle, j->budget, j->err, NULL };
        struct legendre_request rq = { .lagrangian = t.lagrangian, .q = t.q, .v = t.v, .p = t.p, .root = t.root, .n = t.n, .weak = &weak, .mem = &t.mem };
        ok = legendre_map(&l, &rq);
    }
    if (ok) {
        struct phase p = { j, &t.st, t.symbol, t.n, l.hamiltonian, l.primary, l.primaries, t.renamed };
        write_legendre(&t, &l, legendre);
        ok = write_request(&p, request);
    }
    points_oracle_clear(&oracle);
    sga_solution_clear(&solution);
    expr_store_clear(&t.st);
    sga_arena_end(&t.mem);
    return ok;
}

bool dirac_phase_space(struct job *j, struct sga_buf *request, struct sga_buf *legendre)
{
    const struct request *r = j->request;
    if (r->hamiltonian)
        return of_hamiltonian(j, request);
    if (j->redundants) {
        char pointer[64];
        snprintf(pointer, sizeof pointer, "/system/holonomic/%d", j->redundant[0]);
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, pointer, "the constraint follows from the others, and its multiplier would be a gauge freedom of its own; leave it out");
    }
    assert(r->lagrangian);                         /* request/read.c refuses others */
    return of_lagrangian(j, request, legendre);
}
