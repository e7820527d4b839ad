/* Canonical rational functions behind expressions: readable normal forms, factors,
 * and a proof of zero where algebra alone gives one.
 *
 * Generators are the symbols, pi, and the kernels: maximal subexpressions that are not
 * rational operations (sin u, exp u, sqrt u, abs u, u^v, SOLVE components, ...), their
 * arguments normalised first, so that sin(x + y) and sin(y + x) are one generator.
 * Relations that are used: sin^2 + cos^2 = 1 (where both occur), cosh^2 - sinh^2 = 1,
 * tan = sin/cos and tanh = sinh/cosh (where their partners occur), sqrt(u)^2 = u,
 * cbrt(u)^3 = u, abs(u)^2 = u^2, u^(k/n) = (u^(1/n))^k, exp(k u) = exp(u)^k, and the
 * signs of odd and even functions.
 *
 * Caveat: beyond these relations kernels are taken as independent. A numerator that is
 * zero is therefore proved zero; one that is not may still vanish (sin(2x) - 2 sin x cos x).
 *
 * Every function fails softly: false or UNKNOWN means "over budget" or "undefined"; the
 * store is left usable (its sticky error is not touched by a refusal here). FLINT aborts
 * when memory ends, so sizes are estimated before every power, product, gcd and
 * factorisation. Backed by FLINT's fmpz_mpoly. */
#ifndef SGA_POLY_POLY_H
#define SGA_POLY_POLY_H

#include "expr.h"

struct poly_limits {
    long max_terms;            /* of one polynomial; 0: 1000 */
    long max_bits;             /* of one integer coefficient; 0: 20000 */
    long max_degree;           /* total degree of one polynomial; 0: 400 */
    int max_generators;        /* 0: 48 */
    const struct sga_budget *budget;   /* deadline and cancelling; may be NULL */
};

/* How much a question is worth. What is past its size is refused, and points, or another proof, decide.
 *    size      terms   bits  degree  generators */
#define POLY_SIZE_TABLE(X) \
    X(GLANCE,      60,  2000,     24,  24, "asked of every function of a list, or at each start of a motion: a tenth of a millisecond") \
    X(SHOWN,       80,  4000,     60,  32, "forms to read: nobody reads longer ones") \
    X(SMALL,      100,  2000,     30,  24, "asked for every pair, or with others used up, which multiplies the terms") \
    X(READ,       200,  4000,     60,  48, "texts of an answer, in which parameters stand by name") \
    X(MODEST,     200,  4000,     40,  24, "a question of its own: milliseconds") \
    X(AMPLE,      400, 20000,     60,  24, "what an answer rests on: factors of constraints, zeros that points leave open")
enum poly_size {
#define X(name, terms, bits, degree, generators, why) POLY_##name,
    POLY_SIZE_TABLE(X)
#undef X
};
struct poly_limits poly_limits_of(enum poly_size size, const struct sga_budget *budget);

/* A set of roots prepared together: one list of generators, each shared node converted
 * once. limits may be NULL (all defaults) and need not outlive the call. NULL where the
 * generators alone are over the limit. The caller frees it, before the store. The store
 * may grow meanwhile. */
struct poly_bridge;
struct poly_bridge *poly_bridge_new(struct expr_store *st, const expr_id *roots, int nroots,
                                    const struct poly_limits *limits);
void poly_bridge_free(struct poly_bridge *b);
/* The same, for SGA_ENDS. */
void poly_bridge_end(struct poly_bridge **b);

/* The normal form of a node under the bridge's roots, as an expression equal to it
 * wherever it has a value: a fraction in lowest terms, with common factors shown where
 * that is shorter. False: over budget, *out untouched. */
bool poly_bridge_normal(struct poly_bridge *b, expr_id e, expr_id *out);

/* An expression equal to e wherever the functions `by` (roots of the bridge too) all vanish, where one was found that is
 * shorter. False: none, or over budget. `most`, here and below: how many signs, names counted as two, the best text known takes. */
bool poly_bridge_on_set(struct poly_bridge *b, expr_id e, const expr_id *by, int count, long most, expr_id *out);
/* e as its zeros: *out is a polynomial with whole coefficients without a common factor, its sign chosen by the terms and
 * not by the order of names, and e = *scale * *out wherever the functions `by` vanish (*reduced: only there). *scale divides by
 * e's denominators; the polynomial may vanish where these do. False: over budget, or e is 0 there. */
bool poly_bridge_zeros(struct poly_bridge *b, expr_id e, const expr_id *by, int count, long most, expr_id *out, expr_id *scale, bool *reduced);
/* The normal form, unless it is far longer than `most`. */
bool poly_bridge_normal_within(struct poly_bridge *b, expr_id e, long most, expr_id *out);

/* The normal form of one expression. */
bool poly_normal(struct expr_store *st, expr_id e, const struct poly_limits *limits, expr_id *out);
/* For many, with one bridge where the generators allow it: out[i] is the normal form, or
 * e[i] itself where that is over budget. Returns how many were found. */
int poly_normal_all(struct expr_store *st, const expr_id *e, int n, const struct poly_limits *limits, expr_id *out);

/* One factor of a numerator or denominator. */
struct poly_factor {
    expr_id expr;
    long multiplicity;
    unsigned depends;          /* EXPR_HAS_VARIABLE | EXPR_HAS_TIME | EXPR_HAS_PARAMETER (facts.h) */
    bool irreducible;          /* over the integers, in the generators; otherwise only square-free */
    bool never_zero;           /* proved: no real zero where it is defined */
    /* A sum of squares, by its terms (x^2 + y^4: x, y) or after completing them
     * ((x - y)^2 + (x z - 1)^2 multiplied out): zero just where every one of these is. */
    bool sum_of_even_powers;
    expr_id *radical; int radicals;
};

struct poly_factors {
    struct poly_factor *factor; int factors;
    int sign;                  /* of the numeric content that was dropped: -1, 0 (e is zero), 1 */
    long longest;              /* terms of what was factored */
};

/* Factors of the numerator (denominator) of e's normal form, numeric content dropped.
 * False: over budget. The caller clears *out (only after true). */
bool poly_numerator_factors(struct expr_store *st, expr_id e, const struct poly_limits *limits,
                            struct poly_factors *out);
bool poly_denominator_factors(struct expr_store *st, expr_id e, const struct poly_limits *limits,
                              struct poly_factors *out);
bool poly_bridge_numerator_factors(struct poly_bridge *b, expr_id e, struct poly_factors *out);
bool poly_bridge_denominator_factors(struct poly_bridge *b, expr_id e, struct poly_factors *out);
void poly_factors_clear(struct poly_factors *f);
/* e is a polynomial with rational coefficients in its symbols, of degree 2 or of the first degree in one of them, and shown not to factor. False: not shown (some
 * of those that do not factor are not seen). *at_origin (or NULL; only after true): it seems to be 0 where all symbols are. Cost: a small part
 * of factoring; no limits are asked. */
bool poly_shown_irreducible(const struct expr_store *st, expr_id e, bool *at_origin);

/* A proof that e has no real zero: sign * e, or where `factor` is given sign * that factor of e's numerator, times
 * `multiplier` where that is given (1 plus squares), is `sum`,
 * a positive number and squares with positive factors (weights that kernels keep positive, 1 - sin(u)^2, among them). */
struct poly_certificate { expr_id sum, factor, multiplier; int sign; };
/* False: none was found (it may have no zero all the same). */
bool poly_certificate(struct expr_store *st, expr_id e, const struct poly_limits *limits, struct poly_certificate *out);

/* NO is given only where no kernel and no relation is involved. */
enum poly_truth { POLY_NO, POLY_YES, POLY_UNKNOWN };
enum poly_truth poly_is_zero(struct expr_store *st, expr_id e, const struct poly_limits *limits);
enum poly_truth poly_bridge_is_zero(struct poly_bridge *b, expr_id e);

/* Whether target is shown to be zero wherever given[0 .. n) all are (and it has a value): what one
 * of these can be solved for is used up, and powers of target are divided. False: not shown.
 * At most GIVEN_TOGETHER (limits.def) given. Costs that many substitutions into small polynomials. */
bool poly_vanishes_with(struct expr_store *st, expr_id target, const expr_id *given, int n, const struct poly_limits *limits);
/* The sign of r, where a = r b is shown wherever given[0 .. n) are zero, r the simplest fraction next to `ratio`; 0: not shown. Cost as above. */
int poly_is_multiple(struct expr_store *st, expr_id a, expr_id b, double ratio, const expr_id *given, int n, const struct poly_limits *limits);
bool poly_bridge_vanishes_with(struct poly_bridge *b, expr_id target, const expr_id *given, int n);
/* Whether one of several targets is: what is given is converted once. */
bool poly_any_vanishes_with(struct expr_store *st, const expr_id *target, int targets, const expr_id *given, int n,
                            const struct poly_limits *limits);

/* Whether e[0 .. n) are shown to have no common real zero: -1 is a sum of squares plus multiples of them, found and
 * proved as in poly_certificate after what can be solved for is used up. False: not shown. A small semidefinite
 * program: up to a second where there are many variables. */
bool poly_never_together(struct expr_store *st, const expr_id *e, int n, const struct poly_limits *limits);

/* e as a polynomial in one symbol (the rest may be anything): its degree, -1 for zero.
 * False: over budget, or the symbol occurs in the denominator or inside a kernel. */
bool poly_degree_in(struct expr_store *st, expr_id e, int symbol, const struct poly_limits *limits, long *degree);
/* e = slope * symbol + rest, both free of the symbol. False also where it is not linear. */
bool poly_linear_in(struct expr_store *st, expr_id e, int symbol, const struct poly_limits *limits,
                    expr_id line[2]);   /* slope, rest */

/* The numerator of e's normal form, to be asked about. NULL: over budget. The caller frees it, before the store. */
struct poly_numerator;
struct poly_numerator *poly_numerator_new(struct expr_store *st, expr_id e, const struct poly_limits *limits);
void poly_numerator_free(struct poly_numerator *n);
/* Itself, without numeric content and with its first term positive: one text for all multiples. */
expr_id poly_numerator_shown(struct poly_numerator *n);
/* As a polynomial in what depends on variables or time: its coefficients, in parameters alone, and for each what its term
 * depends on (EXPR_HAS_VARIABLE | EXPR_HAS_TIME; 0: the constant term). No coefficients: it is zero. False: over budget. The
 * caller clears *out (only after true). */
struct poly_coefficients { expr_id *coefficient; unsigned *of; int count; };
bool poly_coefficients_of(struct poly_numerator *n, struct poly_coefficients *out);
void poly_coefficients_clear(struct poly_coefficients *c);
/* By powers of a symbol or kernel, by its node: coefficient[0 .. degree], malloced. False (nothing to free): over budget, or it is
 * inside a kernel, or nowhere. */
bool poly_powers_of(struct poly_numerator *n, expr_id node, expr_id **coefficient, int *degree);
/* The resultant of the numerators of x and y in a symbol: it vanishes where they have a common zero in it, or both lose their
 * leading terms. False: over budget, or the symbol is inside a kernel, or in neither. */
bool poly_resultant(struct expr_store *st, expr_id x, expr_id y, int symbol, const struct poly_limits *limits, expr_id *out);

/* Sets of polynomials, in the numerators of e[0 .. n), whose common zeros together hold every part of the zeros of e that is cut out by
 * n of them or fewer: each of 0 .. n irreducible polynomials that can be solved one after the other, as a rule. They may hold more: a
 * polynomial that is not linear in what it is solved for has roots that the others do not have. By factors, by leading
 * coefficients that vanish or not, and by resultants (Wu 1986; Wang, Elimination methods, 2001, chapter 2). Kernels are taken as independent of
 * each other, and parameters as general. False: over budget. A help for searches, no proof: cases that grow too large, or are too many, are left out without a word. The caller clears *out. */
struct poly_chain { expr_id *poly; int count; };
struct poly_chains { struct poly_chain *chain; int chains; size_t cap; };
bool poly_chains_of(struct expr_store *st, const expr_id *e, int n, const struct poly_limits *limits, struct poly_chains *out);
void poly_chains_clear(struct poly_chains *c);

#endif
