/* The real zero set of functions of parameters, in parts that can be put into a system. */
#ifndef SGA_RUN_CASES_H
#define SGA_RUN_CASES_H

#include "expr.h"

struct sga_budget;
struct sga_buf;
struct sys_system;

struct cases_put { int symbol; expr_id value; };    /* value is free of all symbols that are replaced */

/* One part: where the functions `where` vanish and those of `excluded` do not, each parameter of `put` has that value in the
 * others. Closed: nothing more is asked of those. Open: the last function of `where` has no zero in closed form, and is not put in. */
struct cases_part {
    expr_id *where; int wheres;
    struct cases_put *put; int puts;
    expr_id *excluded; int excludeds;
    expr_id root;              /* the one condition that it is a part of; EXPR_UNDEF: several */
    bool open;
};

struct cases {
    struct cases_part *part; int parts;
    bool cut;                  /* there may be more of them: over SGA_MOST_PARAMETER_CASES on the way */
};

/* The real common zeros of functions of the system's parameters where none of `excluded` vanishes. A condition is
 * factored over the rationals; a factor is solved for a parameter that it is affine in, with what it is divided by excluded, and
 * the rest as a part of its own; otherwise by roots: of degree two, in a power of a parameter too. Parts that lie in others
 * are dropped. The caller clears *out. */
void cases_of(const struct sys_system *system, const expr_id *function, int functions, const expr_id *excluded, int excludeds,
              const struct sga_budget *budget, struct cases *out);
void cases_clear(struct cases *c);
/* Whether a part lies in another. */
bool cases_within(const struct sys_system *system, const struct cases_part *part, const struct cases_part *other);
/* Whether f vanishes all over a part. */
bool cases_zero_on(const struct sys_system *system, const struct cases_part *part, expr_id f);
/* e with values put in; EXPR_UNDEF where it has no value there. */
expr_id cases_at(struct expr_store *st, expr_id e, const struct cases_put *put, int puts);
/* A copy of its own. */
struct cases_part cases_copy(const struct cases_part *part);
void cases_part_clear(struct cases_part *part);

/* Values of the parameters at a point of the part where none of `other` vanishes, as JSON: an exact rational as text, or two
 * of which one is below and one above. False: none was found among small rationals. */
bool cases_sample(const struct sys_system *system, const struct cases_part *part, const expr_id *other, int others, struct sga_buf *json);

#endif
