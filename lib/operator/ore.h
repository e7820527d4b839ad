/* Linear differential operators a_0 + a_1 D + ... + a_n D^n over k = Q(t), D a = a D + a'.
 *
 * Source: O. Ore, Theory of non-commutative polynomials, Ann. of Math. 34 (1933) 480; the ring
 * k[D] is a left and right Euclidean domain. Coefficients stand on the left and are kept in
 * lowest terms. Nothing here estimates or samples: all of it is exact. FLINT aborts the
 * process when memory ends, so callers that iterate watch ore_size. */
#ifndef SGA_OPERATOR_ORE_H
#define SGA_OPERATOR_ORE_H

#include <stdbool.h>
#include <stddef.h>

#include <flint/fmpz_poly_q.h>

struct ore {
    fmpz_poly_q_struct *a;     /* cap of them are initialised, those from len on are 0 */
    int len, cap;              /* len = order + 1; a[len - 1] is not 0; the zero operator has len 0 */
};

void ore_init(struct ore *x);
void ore_clear(struct ore *x);
/* The leading coefficient is not 0. */
bool ore_sane(const struct ore *x);
void ore_set(struct ore *x, const struct ore *y);
void ore_swap(struct ore *x, struct ore *y);
void ore_zero(struct ore *x);
void ore_one(struct ore *x);
/* x += a D^k */
void ore_add_term(struct ore *x, const fmpz_poly_q_t a, int k);
/* -1 for 0 */
static inline int ore_order(const struct ore *x) { return x->len - 1; }
static inline bool ore_is_zero(const struct ore *x) { return x->len == 0; }
static inline const fmpz_poly_q_struct *ore_leading(const struct ore *x) { return x->a + x->len - 1; }
bool ore_equal(const struct ore *x, const struct ore *y);

/* x may be the same as y or z in all of these. */
void ore_add(struct ore *x, const struct ore *y, const struct ore *z);
void ore_sub(struct ore *x, const struct ore *y, const struct ore *z);
void ore_mul(struct ore *x, const struct ore *y, const struct ore *z);   /* order y + 1 derivatives of z */
void ore_scale(struct ore *x, const fmpz_poly_q_t a);                    /* x = a x */
void ore_derive(struct ore *x);                                          /* x = D x */
/* x += y z, x -= y z */
void ore_addmul(struct ore *x, const struct ore *y, const struct ore *z);
void ore_submul(struct ore *x, const struct ore *y, const struct ore *z);

/* The formal adjoint, sum (-D)^i a_i: an involution that turns products round. */
void ore_adjoint(struct ore *x, const struct ore *y);

/* a = q b + r with order r < order b (b not 0): b divides on the right. */
void ore_divide_right(struct ore *q, struct ore *r, const struct ore *a, const struct ore *b);
/* a = b q + r: b divides on the left. */
void ore_divide_left(struct ore *q, struct ore *r, const struct ore *a, const struct ore *b);
/* Greatest common right divisor g = u a + v b, monic (0 if both are 0), and the least common
 * left multiple m = s a = -w b, monic (0 if one is 0). u, v, m may be NULL. */
void ore_gcrd(struct ore *g, struct ore *u, struct ore *v, struct ore *m, const struct ore *a, const struct ore *b);

/* Bytes of the coefficients, roughly. */
size_t ore_size(const struct ore *x);

#endif
