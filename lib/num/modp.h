/* Values of the whole store at one point modulo a prime or a power of one: the fast oracle, and the
 * better evidence for algebraic zeros. A nonzero rational function is zero at a random
 * point with probability about degree / p.
 *
 * The primes are safe primes just above 2^60 (p = 2 q + 1, q prime). The squares then
 * form a group of prime order, on which every rational power exists, is unique, and
 * respects (ab)^r = a^r b^r and (a^r)^s = a^(rs): they play the positive numbers.
 * Cube roots exist everywhere. A root of a non-square is `bad`, so about half of the
 * points are lost for each independent radicand; sqrt(x^2) is x or -x, each at half of
 * the points (num_modp_branch says that a root lies below).
 *
 * Transcendental functions are random generators, a keyed hash of (function, residue
 * of the argument), so that arguments that agree modulo p give equal values at once:
 *   sin, cos: 2t/(1+t^2), (1-t^2)/(1+t^2) with t of the argument up to sign; tan = sin/cos
 *   exp: exp(-u) = 1/exp(u); sinh, cosh, tanh by exp; log(1/u) = -log(u)
 *   asin, atan, asinh, atanh, sign: odd; acos = pi/2 - asin; abs(u) = u sign(u)
 *   min symmetric; max(a,b) = a + b - min(a,b)
 *   f(0) = 0 or 1 where the real function has that value; log 1 = acosh 1 = 0
 * Modulo a power of a small prime (num_modp_init_power) the same holds with units in the place of
 * residues that are not 0: what is divided by the prime is `bad` where it would be divided by, or have a root taken.
 * Functions of residues without kernels are then truncated p-adic functions, continuous, so that points can be lifted.
 * Other relations between kernels (addition theorems, exp log u = u) do not hold: a
 * nonzero value under a kernel proves nothing (num_modp_kernel), a zero does. */
#ifndef SGA_NUM_MODP_H
#define SGA_NUM_MODP_H

#include <stdbool.h>
#include <stdint.h>
#include <flint/flint.h>
#include <flint/nmod_vec.h>

#include "expr.h"

#define NUM_MODP_PRIMES 48

enum {
    NUM_MODP_BAD = 1,      /* no value here: a division by zero or a missing root, here or below */
    NUM_MODP_KERNEL = 2,   /* a transcendental or piecewise function, or pi, lies here or below */
    NUM_MODP_BRANCH = 4    /* a square root or rational power lies here or below */
};

struct num_modp {
    const struct expr_store *st;
    nmod_t mod;                                          /* p^power */
    mp_limb_t p; int power;
    ulong squares;                                       /* the order of the group of squares of units: odd */
    uint64_t seed;
    mp_limb_t *symbol; int symbols; size_t symbol_cap;   /* residues of the symbols */
    mp_limb_t *value;  int nodes;   size_t value_cap;    /* of nodes 0 .. nodes-1 */
    uint8_t *flags;                 size_t flags_cap;    /* NUM_MODP_... of each node */
    struct num_modp_solution *solution; int solutions; size_t solution_cap;
};

/* prime: 0 .. NUM_MODP_PRIMES-1. The same seed and prime give the same values, always.
 * Symbols start at 0. The store must outlive it. */
void num_modp_init(struct num_modp *m, const struct expr_store *st, uint64_t seed, int prime);
/* Modulo the greatest power below 2^63 of a small safe prime that is 11 modulo 12: 11, 23, 47, 59, 83, 107, 167, ... */
void num_modp_init_power(struct num_modp *m, const struct expr_store *st, uint64_t seed, mp_limb_t p);
void num_modp_clear(struct num_modp *m);
/* A random residue that depends on the seed and the key only. */
mp_limb_t num_modp_random(const struct num_modp *m, uint64_t key);
/* The residue of a rational; false if p divides the denominator. */
bool num_modp_fmpq(const struct num_modp *m, const fmpq *q, mp_limb_t *residue);

/* Set a symbol's residue (reduced). Known nodes keep their values until they are
 * recomputed by num_modp_list or forgotten by num_modp_forget. */
void num_modp_set(struct num_modp *m, int symbol, mp_limb_t residue);
void num_modp_forget(struct num_modp *m);
/* Values for every node that the store has now. About 10 ns a node; 0.2 to 1 us for
 * divisions and kernels, m^3 for a solve. */
void num_modp_extend(struct num_modp *m);
/* Values of the nodes of one list only, in order (children first). Every other node
 * under them must be known. */
void num_modp_list(struct num_modp *m, const expr_id *list, int count);

/* Whether the residue has an inverse. */
static inline bool num_modp_unit(const struct num_modp *m, mp_limb_t x) { return m->power == 1 ? x != 0 : x % m->p != 0; }
/* a y = r for n unknowns, a by rows; both are overwritten, r by y. False where no pivot is a unit (singular modulo p). */
bool num_modp_solve(const struct num_modp *m, mp_limb_t *a, mp_limb_t *r, int n);
static inline mp_limb_t num_modp_value(const struct num_modp *m, expr_id e) { return m->value[e]; }
static inline bool num_modp_bad(const struct num_modp *m, expr_id e) { return m->flags[e] & NUM_MODP_BAD; }
static inline bool num_modp_kernel(const struct num_modp *m, expr_id e) { return m->flags[e] & NUM_MODP_KERNEL; }
static inline bool num_modp_branch(const struct num_modp *m, expr_id e) { return m->flags[e] & NUM_MODP_BRANCH; }

#endif
