/* Hamilton's equations of a 2-form, pulled back to the zero set of the restrictions. */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

#include "arena.h"
#include "derive.h"
#include "form.h"
#include "mem.h"

/* Row i of Omega^T x' = grad H, before any restriction. */
struct equation {
    struct form_entry *entry;      /* row i of Omega^T; sorted by row */
    size_t *first;                 /* row -> its first entry; one more at the end */
    expr_id *gradient;             /* of H, by variable */
};

/* Omega^T by rows: entry (i, j) of omega goes to row j, column i. */
static void transpose(struct equation *q, const struct form_entry *entry, size_t entries, int n)
{
    q->entry = sga_malloc((entries + 1) * sizeof *q->entry);
    q->first = sga_calloc((size_t)n + 2, sizeof *q->first);
    for (size_t k = 0; k < entries; k++)
        q->first[entry[k].col + 2]++;
    for (int i = 2; i <= n; i++)
        q->first[i] += q->first[i - 1];
    for (size_t k = 0; k < entries; k++)
        q->entry[q->first[entry[k].col + 1]++] = (struct form_entry){ entry[k].col, entry[k].row, entry[k].value };
}

static void canonical(struct equation *q, struct expr_store *st, int n)
{
    SGA_FREED struct form_entry *omega = sga_malloc(((size_t)n + 1) * sizeof *omega);
    for (int i = 0; i < n / 2; i++) {
        omega[2 * i] = (struct form_entry){ i, n / 2 + i, expr_int(st, 1) };
        omega[2 * i + 1] = (struct form_entry){ n / 2 + i, i, expr_int(st, -1) };
    }
    transpose(q, omega, (size_t)n, n);
}

/* The gradient of e by variable, dense. */
static void gradient(struct sys_system *s, struct expr_cone *cone, expr_id e, expr_id *out)
{
    struct expr_store *st = s->store;
    SGA_ARENA(mem);
    unsigned char *active = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    int *column = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *column);
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    for (int j = 0; j < s->variables; j++) {
        active[s->variable[j].symbol] = 1;
        column[s->variable[j].symbol] = j;
        out[j] = expr_int(st, 0);
    }
    int n = expr_gradient(st, cone, e, active, &term, &cap);
    for (int k = 0; k < n; k++)
        out[column[term[k].symbol]] = term[k].value;
}

static void add_row(struct sys_system *s, const struct equation *q, const expr_id *weight, int n, int number)
{
    struct expr_store *st = s->store;
    char source[32];
    expr_id alpha = expr_int(st, 0);
    for (int i = 0; i < n; i++)
        alpha = expr_add(st, alpha, expr_mul(st, weight[i], q->gradient[i]));
    snprintf(source, sizeof source, "pull-back %d", number);
    int row = sys_add_row(s, alpha, source);
    for (int i = 0; i < n; i++)
        for (size_t k = q->first[i]; k < q->first[i + 1] && !expr_is_zero(st, weight[i]); k++)
            sys_add_entry(s, row, q->entry[k].col, expr_mul(st, weight[i], q->entry[k].value));
}

static void add_all_rows(struct sys_system *s, const struct equation *q, int n)
{
    for (int i = 0; i < n; i++) {
        char source[32];
        snprintf(source, sizeof source, "row %d", i);
        int row = sys_add_row(s, q->gradient[i], source);
        for (size_t k = q->first[i]; k < q->first[i + 1]; k++)
            sys_add_entry(s, row, q->entry[k].col, q->entry[k].value);
    }
}

/* Rows e^T (Omega^T x' - grad H). */
static void add_pulled_back(struct sys_system *s, struct expr_cone *cone, const struct equation *q,
                            const struct form_hamiltonian *in, struct form_tangent *out)
{
    int n = in->variables;
    SGA_FREED expr_id *jacobian = sga_calloc((size_t)in->restrictions * (size_t)n + 1, sizeof *jacobian);
    for (int i = 0; i < in->restrictions; i++)
        gradient(s, cone, in->restriction[i], jacobian + (size_t)i * (size_t)n);
    out->vector = form_kernel(s->store, jacobian, in->restrictions, n, in->zero, &out->count);
    for (int i = 0; i < out->count; i++)
        add_row(s, q, out->vector + (size_t)i * (size_t)n, n, i);
}

void form_hamiltonian_space(struct sys_system *s, const struct form_hamiltonian *in)
{
    for (int j = 0; j < in->variables; j++)
        sys_add_variable(s, in->variable[j], "variable");
    for (int i = 0; i < in->restrictions; i++)
        sys_add_restriction(s, in->restriction[i]);
    s->square = !in->restrictions;
}

void form_hamiltonian_rows(struct sys_system *s, const struct form_hamiltonian *in, struct form_tangent *out)
{
    int n = in->variables;
    struct equation q = { 0 };
    struct form_tangent tangent = { 0 };
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    if (in->omega) {
        assert(in->omega->rows == n && in->omega->cols == n);
        transpose(&q, in->omega->entry, in->omega->entries, n);
    } else {
        assert(n % 2 == 0);
        canonical(&q, s->store, n);
    }
    q.gradient = sga_calloc((size_t)n + 1, sizeof *q.gradient);
    gradient(s, &cone, in->hamiltonian, q.gradient);
    if (in->restrictions)
        add_pulled_back(s, &cone, &q, in, &tangent);
    else
        add_all_rows(s, &q, n);
    if (out)
        *out = tangent;
    else
        free(tangent.vector);
    free(q.entry);
    free(q.first);
    free(q.gradient);
}
