/* Inside the sga folder: constraints are sets, not formulas. */
#ifndef SGA_SGA_REGULAR_H
#define SGA_SGA_REGULAR_H

#include "state.h"

enum regular_answer {
    REGULAR_KEEP,          /* as it is (or nothing better is known) */
    REGULAR_REPLACED,      /* the options together have the same real zeros on the present set */
    REGULAR_NEVER          /* it has no real zero there at all; no options */
};

/* One branch of the zero set: functions that vanish on it together. */
struct regular_option {
    expr_id *out;
    int count;
};

struct regular {
    enum regular_answer answer;
    bool seen;                                    /* a factor was left out as points showed it, not algebra */
    bool reduced;                                 /* the form is that of the function with constraints used up */
    bool outside;                                 /* ways in which it vanishes where the equations have no value were left out */
    struct regular_option *option; int options;   /* nearest to the guess first; owned */
};

/* Square-free part; factors that vanish nowhere, or nowhere on the present set, dropped; a
 * sum of even powers split into what must vanish together; a product split into its
 * branches. The oracle must hold points of the present set. */
struct regular regular_form(struct state *s, expr_id e);
void regular_clear(struct regular *r);
/* What has no zeros has no options, and an option has functions. Linear in the options. */
bool regular_sane(const struct regular *r);

/* Why e, whose form r is REGULAR_NEVER with nothing `seen`, has no real zero, with the squares that show it where they
 * are short. */
void regular_never_text(struct state *s, expr_id e, const struct regular *r, char *text, size_t size);

/* f at a place (x by variable), parameters at some general value; NaN where it has none. */
double regular_value(struct state *s, expr_id f, const double *x, double t);
/* The way in which e vanishes that is nearest to a place: the caller frees out (NULL: none). */
struct regular_option regular_nearest(struct state *s, expr_id e, const double *x, double t);

/* e and all constraints, pending ones too, are affine in the variables: then nothing can be
 * a product or irregular on the present set only, but for factors of time ((t - 1) x = y on y = 0). */
bool regular_all_affine(struct state *s, expr_id e);

/* e on the present set with variables eliminated that constraints give with a constant
 * factor, one after the other; equal to e on the set. For showing that e has no zero
 * there. Costs O(c^2) normal forms of small functions: for SGA_MOST_REDUCED_BY
 * constraints at the most. */
expr_id regular_reduced(struct state *s, expr_id e);
/* Whether e, or the one function with its zeros, can be used up in this way. */
bool regular_is_solved(struct state *s, expr_id e);

/* Where sampling found that e is irregular on its zeros near the point x (by variable):
 * if e has a definite second derivative across its zero set (Morse-Bott), its zeros there
 * are those of its gradient. Gives independent gradient components that may take its
 * place (the caller checks that e vanishes with them); returns how many, 0 if this does
 * not apply. The caller frees *out. */
int regular_by_gradient(struct state *s, expr_id e, const double *x, double t, expr_id **out);

#endif
