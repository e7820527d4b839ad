/* Inside the poly folder only: generators, values with shared denominators, fractions.
 *
 * A value is num / (scale * product of base[i]^power[i]) with one list `base` of
 * denominator factors for the whole bridge. Sums take the least common denominator by
 * comparing powers, and cancelling is trial division, so no gcd is taken until a
 * result is asked for (poly_fraction_of). On the telescopic arm's reduced field with
 * symbolic parameters this takes 0.4 of the time of canonical fractions at each node. */
#ifndef SGA_POLY_BRIDGE_H
#define SGA_POLY_BRIDGE_H

#include <flint/fmpz_mpoly.h>

#include "arena.h"
#include "poly.h"

enum { POLY_MAX_BASE = 32, POLY_MAX_STEPS = 16 };

enum poly_sign { POLY_ANY, POLY_NONNEGATIVE, POLY_POSITIVE };

struct poly_ratio {
    fmpz_mpoly_t num;
    fmpz_t scale;                      /* > 0 */
    int power[POLY_MAX_BASE];          /* >= 0 */
};

struct poly_generator {
    expr_id node;                      /* how it is shown */
    unsigned depends;                  /* EXPR_HAS_* */
    enum poly_sign sign;
    enum expr_op op;                   /* SYM, PI, or the kernel's */
    expr_id key, key2;                 /* arguments that equal kernels have in common */
    int flip;                          /* node = flip * op(key), flip = 1 or -1 */
    expr_id base;                      /* of POW and EXP: see root and content */
    long root;                         /* POW: the node is base^(1/root); otherwise 0 */
    fmpq_t content;                    /* EXP: the node is exp(content * key) */
    int degree;                        /* relation g^degree = p/q; 0: none */
    fmpz_mpoly_t p, q;
    int partner;                       /* of sin: cos; of sinh: cosh; otherwise -1 */
    int in_base;                       /* index as a denominator factor, or -1 */
};

struct poly_base {
    fmpz_mpoly_t f;                    /* primitive, positive leading coefficient */
    bool prime;                        /* known to be irreducible */
};

/* exp(2 u) and exp(3 u) are powers of exp(u): of which content the generator for a key is to be. */
struct poly_step {
    expr_id key;
    fmpq_t content;
};

struct poly_bridge {
    struct sga_arena mem;              /* of all vectors below */
    struct expr_store *st;
    struct poly_limits limits;         /* filled in, none 0 */
    fmpz_mpoly_ctx_t ctx;
    int max_gens, gens, relations;
    struct poly_generator *gen;
    struct poly_base base[POLY_MAX_BASE];
    int bases;
    struct poly_step step[POLY_MAX_STEPS];
    int steps;
    bool finer;                        /* a step was added or made finer: what was converted before does not know */
    struct expr_cone cone;             /* of the roots above solves, as it was at the start */
    const expr_id *list; int count;    /* its list; 0: nothing of it is converted */
    unsigned char *mark;               /* by position: MARK_* below */
    unsigned char *depends;            /* by position: EXPR_HAS_* */
    struct poly_ratio *value;          /* by position, where mark has KNOWN */
};

enum { POLY_KNOWN = 1, POLY_TRIG = 2, POLY_HYPERBOLIC = 4 };

/* limits.c: products and powers that are refused (false) before they get too large. */
bool poly_fits(const struct poly_bridge *b, const fmpz_mpoly_t f);
bool poly_mul(struct poly_bridge *b, fmpz_mpoly_t out, const fmpz_mpoly_t x, const fmpz_mpoly_t y);
bool poly_pow(struct poly_bridge *b, fmpz_mpoly_t out, const fmpz_mpoly_t x, long n);
/* out = x / y if that is exact and cheap to find out; otherwise out is untouched (it may be x). */
bool poly_divides(struct poly_bridge *b, fmpz_mpoly_t out, const fmpz_mpoly_t x, const fmpz_mpoly_t y);
/* False: too expensive to ask for. */
bool poly_gcd(struct poly_bridge *b, fmpz_mpoly_t out, const fmpz_mpoly_t x, const fmpz_mpoly_t y);
/* Number of monomials in the box of f's degrees, at most `cap`; total degree. */
double poly_box(const struct poly_bridge *b, const fmpz_mpoly_t f);
long poly_degree(const struct poly_bridge *b, const fmpz_mpoly_t f);
/* Irreducible for sure, of f without a monomial or a number as a factor: linear in some generator, with a coefficient of one
 * term (a common factor of both coefficients would be a monomial). */
bool poly_surely_prime(const struct poly_bridge *b, const fmpz_mpoly_t f);
/* f = content * f', content > 0; returns it in c. */
void poly_content(fmpz_t c, const fmpz_mpoly_t f);
/* Exponents of term i, by generator (room for max_gens). */
void poly_exponents(const struct poly_bridge *b, const fmpz_mpoly_t f, slong i, ulong *exp);

/* ratio.c: all return false where a limit is met (then r is a valid ratio of no meaning). */
void poly_ratio_init(const struct poly_bridge *b, struct poly_ratio *r);
void poly_ratio_clear(const struct poly_bridge *b, struct poly_ratio *r);
/* The scale is positive, and powers of denominators are not negative. Linear in the denominators. */
bool poly_ratio_sane(const struct poly_bridge *b, const struct poly_ratio *r);
void poly_ratio_set(const struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x);
void poly_ratio_fmpq(const struct poly_bridge *b, struct poly_ratio *r, const fmpq_t q);
void poly_ratio_gen(const struct poly_bridge *b, struct poly_ratio *r, int gen);
bool poly_ratio_add(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x,
                    const struct poly_ratio *y, bool subtract);
bool poly_ratio_mul(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x, const struct poly_ratio *y);
bool poly_ratio_inv(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x);
bool poly_ratio_pow(struct poly_bridge *b, struct poly_ratio *r, const struct poly_ratio *x, long n);

/* relation.c */
/* Replaces powers of generator g by its relation g^degree = p/q: f = out / q^k, k returned
 * (-1: over budget). */
long poly_reduce_by(struct poly_bridge *b, fmpz_mpoly_t f, int g, int degree, const fmpz_mpoly_t p, const fmpz_mpoly_t q);
bool poly_reduce_ratio(struct poly_bridge *b, struct poly_ratio *r);
/* The sign that f has wherever it is defined, as far as its terms show it; *negative tells
 * that it is -f that has it. */
enum poly_sign poly_sign_of(const struct poly_bridge *b, const fmpz_mpoly_t f, bool *negative);
/* Proved to have no real zero, generators taken as independent real numbers: a quadratic
 * polynomial by completing squares, a univariate one by Sturm's count. */
bool poly_keeps_sign(struct poly_bridge *b, const fmpz_mpoly_t f);

/* squares.c: f >= 0 everywhere (generators taken as independent), because it is a sum of
 * squares after multiplication by what is positive. f vanishes just where the functions of
 * *out (owned by the caller) all do; *never: nowhere. False: not found to be so. */
bool poly_squares(struct poly_bridge *b, const fmpz_mpoly_t f, expr_id **out, int *count, bool *never);

/* coefficients.c: the generator that is this node, which stands in no other generator; -1: none. */
int poly_generator_of(const struct poly_bridge *b, expr_id node);

/* vanish.c: the numerator of e; false: over budget. */
bool poly_numerator(struct poly_bridge *b, expr_id e, fmpz_mpoly_t out);
/* What one of given[0 .. n) is solved for with a number as its factor is put into the others and into target (or NULL),
 * and that one becomes 0; the others are left with the same common zeros. False: over budget. */
bool poly_use_up(struct poly_bridge *b, fmpz_mpoly_struct *target, fmpz_mpoly_struct *given, int n);
/* target is zero wherever given[0 .. n) are, as poly_vanishes_with of numerators. */
bool poly_vanish(struct poly_bridge *b, const fmpz_mpoly_t target, const fmpz_mpoly_struct *const *given, int n);

/* kernel.c: the value of a node that is not a rational operation. */
bool poly_kernel(struct poly_bridge *b, expr_id e, unsigned depends, struct poly_ratio *r);
int poly_generator_add(struct poly_bridge *b, struct poly_generator g);

/* fraction.c: lowest terms. */
struct poly_fraction {
    fmpz_mpoly_t num;                  /* with its integer content */
    fmpz_t scale;                      /* > 0, prime to that content */
    struct poly_power { fmpz_mpoly_t f; long n; } *den; int dens; size_t den_cap;
};
bool poly_fraction_of(struct poly_bridge *b, const struct poly_ratio *r, struct poly_fraction *f);
/* The scale is positive, denominators have positive powers and leading terms. Linear in the denominators. */
bool poly_fraction_sane(const struct poly_fraction *f);
void poly_fraction_clear(const struct poly_bridge *b, struct poly_fraction *f);

/* show.c: as expressions of the store. */
bool poly_show(struct poly_bridge *b, const struct poly_fraction *f, expr_id *out);
expr_id poly_show_poly(struct poly_bridge *b, const fmpz_mpoly_t f);
/* gen^n as an expression */
expr_id poly_show_power(struct poly_bridge *b, int gen, long n);

/* The value of a node of the bridge, or NULL. */
static inline const struct poly_ratio *poly_value(const struct poly_bridge *b, expr_id e)
{
    int at = expr_cone_place(&b->cone, e);
    return at >= 0 && (b->mark[at] & POLY_KNOWN) ? b->value + at : NULL;
}

#endif
