/* Inside the sga folder: one condition solved for a parameter. */
#ifndef SGA_RUN_CASES_SOLVE_H
#define SGA_RUN_CASES_SOLVE_H

#include "poly.h"

struct cases_put;

struct cases_space {
    struct expr_store *st;
    struct poly_limits limits;
    const struct sys_system *system;
};

enum cases_truth { CASES_ZERO, CASES_NEVER, CASES_OPEN };

struct cases_space cases_space_of(const struct sys_system *system, const struct sga_budget *budget);

/* cases_at in normal form. */
expr_id cases_replace(const struct cases_space *s, expr_id e, const struct cases_put *put, int puts);
/* Of a normal form. ZERO: proved. NEVER: a number that is not zero. */
enum cases_truth cases_zero(const struct cases_space *s, expr_id e);

/* The real zeros of an irreducible f, as values of the parameter in which it is plainest. Where its leading coefficient may
 * vanish the values hold only where it does not. */
enum { CASES_ROOTS = 4 };
struct cases_roots {
    expr_id function;                /* f, as all its multiples are written */
    int symbol;
    expr_id value[CASES_ROOTS]; int count;
    expr_id leading;                 /* or EXPR_UNDEF */
    expr_id instead;                 /* no values: what vanishes where f does; or EXPR_UNDEF */
};
/* False: there is no closed form, only the function is given. */
bool cases_solve(const struct cases_space *s, expr_id f, struct cases_roots *roots);

#endif
