/* Inside the pencil folder: roots of squarefree integer polynomials in balls, and their decimals. */
#ifndef SGA_PENCIL_ROOTS_H
#define SGA_PENCIL_ROOTS_H

#include <acb.h>
#include <flint/fmpz_poly.h>

struct root {
    acb_struct value;          /* contains one root; exactly real or imaginary where the root is */
    int factor;
};

struct root_list {
    struct root *root;
    int count;
    size_t cap;
};

/* Adds the roots of f. Cost: polynomial in degree and bits (Arb's isolation). */
void root_list_of(struct root_list *l, const fmpz_poly_t f, int factor, slong precision);
void root_list_clear(struct root_list *l);

/* Correctly rounded to so many digits (0: the shortest decimal of the nearest double), the caller
 * frees it; NULL where the ball does not say. */
char *root_text(const arb_t x, slong digits, slong precision);

#endif
