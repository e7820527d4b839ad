/* Frequency responses. */
#include "transfer_response.h"

#include <acb_mat.h>
#include <math.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "mem.h"

SGA_END_BY(acb_mat_end, acb_mat_t, acb_mat_clear)

void transfer_response_init(struct transfer_response *r, int outputs, int inputs)
{
    *r = (struct transfer_response){ .outputs = outputs, .inputs = inputs, .number = sga_calloc(2 * (size_t)outputs * (size_t)inputs + 1, sizeof *r->number) };
}

void transfer_response_clear(struct transfer_response *r)
{
    free(r->number);
    *r = (struct transfer_response){ .outputs = 0 };
}

/* The doubles of a value, and what they are off by beside its size. */
static void take(struct transfer_response *r, int at, const acb_t z, bool known)
{
    SGA_ENDS(arb_end) arb_t size = { 0 }, off = { 0 }, part = { 0 };
    r->number[2 * at] = r->number[2 * at + 1] = NAN;
    if (!known || !acb_is_finite(z))
        return;
    acb_abs(size, z, LINEAR_BITS);
    for (int k = 0; k < 2; k++) {
        arb_srcptr x = k ? acb_imagref(z) : acb_realref(z);
        double v = arf_get_d(arb_midref(x), ARF_RND_NEAR) + 0.0;
        if (!isfinite(v)) {
            r->number[2 * at] = r->number[2 * at + 1] = NAN;
            return;
        }
        r->number[2 * at + k] = v;
        arb_set_d(part, v);
        arb_sub(part, x, part, LINEAR_BITS);
        arb_abs(part, part);
        arb_add(off, off, part, LINEAR_BITS);
    }
    if (arb_is_zero(off))
        return;
    arb_div(off, off, size, LINEAR_BITS);
    arb_get_ubound_arf(arb_midref(part), off, LINEAR_BITS);
    double bound = arf_get_d(arb_midref(part), ARF_RND_UP);
    r->error = isnan(bound) ? INFINITY : fmax(r->error, bound);       /* a value that is not told from 0 */
}

void transfer_response_exact(struct transfer_response *r, const struct transfer_matrix *t, double omega)
{
    acb_t z;
    acb_init(z);
    for (int i = 0; i < r->outputs; i++)
        for (int k = 0; k < r->inputs; k++) {
            bool known = transfer_entry_at(t, i, k, omega, z);
            take(r, i * r->inputs + k, z, known);
        }
    acb_clear(z);
}

void transfer_response_enclosed(struct transfer_response *r, const struct linearization *l, double omega)
{
    int n = l->states;
    SGA_ENDS(acb_mat_end) acb_mat_t M, B, C, G, D;
    acb_mat_init(M, n, n);
    acb_mat_init(B, n, r->inputs);
    acb_mat_init(C, r->outputs, n);
    acb_mat_init(D, r->outputs, r->inputs);
    acb_mat_init(G, r->outputs, r->inputs);
    acb_mat_set_arb_mat(M, l->A.b);
    acb_mat_neg(M, M);
    acb_mat_set_arb_mat(B, l->B.b);
    acb_mat_set_arb_mat(C, l->C.b);
    acb_mat_set_arb_mat(D, l->D.b);
    for (int k = 0; k < n; k++)
        arb_set_d(acb_imagref(acb_mat_entry(M, k, k)), omega);
    bool known = n == 0 || acb_mat_solve(B, M, B, LINEAR_BITS);
    if (known) {
        acb_mat_mul(G, C, B, LINEAR_BITS);
        acb_mat_add(G, G, D, LINEAR_BITS);
    }
    for (int i = 0; i < r->outputs; i++)
        for (int k = 0; k < r->inputs; k++)
            take(r, i * r->inputs + k, acb_mat_entry(G, i, k), known);
}
