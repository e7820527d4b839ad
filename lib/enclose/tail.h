/* Inside the enclose folder: where a Taylor series converges, and what its first coefficients leave out.
 *
 * Of a power series f(s) = sum f_k s^k let |f| = sum |f_k| R^k: then |f g| <= |f| |g|, and |f| bounds f on the disc |s| <= R. Let f,
 * for each slot of a program, be its formal Taylor series along the solution from one start, of which coefficients 0 .. N are
 * enclosed (series.h), [f] = sum_{k <= N} |f_k| R^k, and P(f, g) = sum_{i, l <= N < i + l} |f_i| |g_l| R^(i + l).
 *
 * Theorem. Let tau(f) >= 0 be such that Phi_f(tau) <= tau(f) for all slots, where Phi is
 *   variable x, x' = X:  R / (N + 1) (|X_N| R^N + tau(X))
 *   a + b, a - b:        tau(a) + tau(b);       -a, and a branch that was chosen: tau(a)
 *   a b:                 P(a, b) + tau(a) [b] + [a] tau(b) + tau(a) tau(b)
 *   v = a / b:           i (tau(a) + P(b, v) + tau(b) [v]),   i >= |1 / b|, b with its tail (inverse.h)
 *   v = sqrt(a):         i / 2 (tau(a) + P(v, v) + tau(v)^2),  i >= |1 / v|, v without its tail
 *   u' = g x':           tau(x) ([g] + tau(g)) + (sum_{1 <= i <= N} i |x_i| R^i (sum_{N - i < l <= N} |g_l| R^l + tau(g))) / (N + 1)
 *   y, S y = r:          (|Q| e + E tau(y)),  e_i = tau(r_i) + sum_j (P(S_ij, y_j) + tau(S_ij) [y_j]),  Q and E of inverse.h.
 * Then sum_{k > N} |f_k| R^k <= tau(f) for all slots: all series converge for |s| <= R, and the first n are the solution.
 * Proof. Let T_m(f) = sum_{N < k <= m} |f_k| R^k, so that T_N = 0 <= tau. Coefficient m of a slot depends on coefficients below m, and on the
 * m-th of slots before it; Phi is monotone, and sorting the recurrence for it (u: m u_m = sum i x_i g_{m - i}, where 1/m <= 1/(N + 1) for
 * i <= N and i / m <= 1 beyond; sqrt: 2 v0 w + w^2 = a - v0^2 for v = v0 + w) gives T_m(f) <= Phi_f(T) with what T is by then: <= tau
 * by induction. A convergent formal solution is a solution, where the field has a value all the way: denominators and matrices have inverses,
 * |tau(v) / v| < 1 for roots, and functions that are given by differential equations are what they are at the start while no
 * branch point is met (branches_hold.h).
 *
 * The same for derivatives with respect to the start: they are slots with linear rules. Norms of this kind: Hungria,
 * Lessard, Mireles James, Rigorous numerics for analytic solutions of differential equations: the radii polynomial approach, Math.
 * Comp. 85, 2016. Here all unknowns are of degree > N, so that integration divides them by N + 1: R comes near the radius
 * of convergence, which boxes around the start (Picard) do not.
 *
 * All numbers are upper bounds in mag_t, rounded outward. Where the series are of a ball of starts, so is what is proved. */
#ifndef SGA_ENCLOSE_TAIL_H
#define SGA_ENCLOSE_TAIL_H

#include "inverse.h"

struct enc_tail {
    const struct enc_series *s;
    int order, room;         /* N; allocated */
    double R;
    bool *loop;              /* by slot: later slots' tau is needed before this one's is there (variables, functions with derivatives of themselves) */
    mag_ptr power;           /* R^k, k <= N */
    mag_ptr size, rest;      /* by slot, room + 2 each: |f_k| R^k; sums of those from k to N, k <= N + 1 */
    mag_ptr fixed;           /* by slot: the part of Phi that does not depend on tau */
    mag_ptr moment;          /* by slot, where code.scaled: sum i |f_i| R^i */
    mag_ptr tau;             /* by slot */
    struct enc_inverses inverse;
    mag_ptr dsize, drest, dfixed, dtau;     /* the same of the derivatives along one direction; NULL until asked for */
};

void enc_tail_init(struct enc_tail *t, const struct enc_program *p);
void enc_tail_clear(struct enc_tail *t);
/* The series has been run anew. */
void enc_tail_begin(struct enc_tail *t, const struct enc_series *s);
/* Find tau for this R. False where the theorem does not give one. */
bool enc_tail_find(struct enc_tail *t, double R);
/* The same for the derivatives that the series holds now (enc_series_along): tails of the variables in dtau. After enc_tail_find. */
bool enc_tail_along(struct enc_tail *t);

/* (|s| / R)^(N + 1), at most 1: by this much a tail of degree > N is smaller at s, |s| <= R. */
void enc_tail_shrink(mag_t r, const struct enc_tail *t, const arb_t s);

static inline mag_ptr enc_tail_size(const struct enc_tail *t, int slot) { return t->size + (size_t)slot * (size_t)(t->room + 2); }
static inline mag_ptr enc_tail_rest(const struct enc_tail *t, int slot) { return t->rest + (size_t)slot * (size_t)(t->room + 2); }
static inline mag_ptr enc_tail_dsize(const struct enc_tail *t, int slot) { return t->dsize + (size_t)slot * (size_t)(t->room + 2); }
static inline mag_ptr enc_tail_drest(const struct enc_tail *t, int slot) { return t->drest + (size_t)slot * (size_t)(t->room + 2); }

/* Of one slot: the part of Phi that does not depend on tau, and inverses (false: there is none); Phi itself. */
bool enc_tail_prepare(struct enc_tail *t, int slot);
void enc_tail_phi(mag_t r, const struct enc_tail *t, int slot);

/* r u, infinite where u is, also for r = 0: what has no bounded inverse has no tail. */
static inline void enc_tail_times(mag_t r, const mag_t u)
{
    if (mag_is_inf(u))
        mag_inf(r);
    else
        mag_mul(r, r, u);
}

/* Shared by values and derivatives: P(f, g) of sizes and sums, f up to degree `last`; sizes and sums of a series; and one sweep's
 * decision: whether tau grows to what Phi says, and half as much again (more). */
void enc_tail_overlap(mag_t r, mag_srcptr size, mag_srcptr rest, int last);
void enc_tail_sizes(mag_ptr size, mag_ptr rest, arb_srcptr f, mag_srcptr power, int order);
bool enc_tail_grow(mag_t tau, const mag_t phi, bool more);

/* Slots between looks at the watch (watch.h): past a limit nothing is found. */
enum { ENC_LOOK = 1024 };

/* So many sweeps; the first ones take what Phi says, later ones more, in loops. */
enum { ENC_SWEEPS = 30, ENC_PLAIN = 3 };

#endif
