/* Inside the points folder: refinement and proof of a point. */
#ifndef SGA_POINTS_REFINE_H
#define SGA_POINTS_REFINE_H

#include <stdbool.h>

#include <flint/flint.h>

struct points_point;
struct points_search;

/* From an approximate point (ball symbols, good to about 12 digits): choose the variables
 * to solve for, freeze the others, refine to prec bits with the double factorization as
 * preconditioner, and prove by Krawczyk's test. Sets point->certified, ->solved, and the
 * symbols' balls. False where the differentials are dependent or it does not converge. */
bool points_refine_with(struct points_search *w, struct points_point *p, slong prec);

#endif
