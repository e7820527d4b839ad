/* Where the equations as given have values. What vanishes only where something is divided by
 * zero vanishes nowhere: x^2 + e^2 on the zeros of y (1 + x^2/e^2). */
#ifndef SGA_SGA_DOMAIN_H
#define SGA_SGA_DOMAIN_H

#include "expr.h"
#include "warnings.h"

struct expr_facts;
struct sga_budget;
struct sys_system;

enum { DOMAIN_MOST = SGA_MOST_DOMAIN_DIVISORS, DOMAIN_GIVEN = SGA_MOST_DOMAIN_GIVEN };

/* What must not vanish for a system to have a value, found when it is first asked for. All but
 * the list is borrowed. */
struct domain {
    const struct sys_system *system;
    struct expr_facts *facts;
    struct expr_cone *cone;               /* spent by every question */
    const struct sga_budget *budget;
    expr_id divisor[DOMAIN_MOST]; int divisors;
    bool known;
    bool cut;                             /* there are more divisors than were kept */
};

/* What must not vanish for this node to have a value; EXPR_UNDEF: nothing. */
expr_id domain_divisor(const struct expr_store *st, expr_id e);
/* Whether it is shown that f[0 .. count) vanish together only where e or the system has no
 * value: of the first `own` of them, the others are constraints that hold too. Asked of algebra
 * alone: of DOMAIN_MOST divisors, and nothing is shown of more than DOMAIN_GIVEN functions. */
bool domain_leaves_out(struct domain *d, expr_id e, const expr_id *f, int own, int count);

#endif
