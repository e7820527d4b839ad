/* Inside the folder: the work on one reduced system. */
#ifndef SGA_SYM_SYM_WORK_H
#define SGA_SYM_SYM_WORK_H

#include <flint/fmpq.h>

#include "arena.h"
#include "sym.h"

struct num_modp;
struct points_modpoint;

struct sym_work {
    struct sga_arena mem;      /* of all vectors below */
    const struct sys_system *sys;
    const struct sga_solution *sol;
    struct points_oracle *oracle;
    const struct sga_budget *budget;
    struct expr_store *st;
    struct expr_cone cone;
    unsigned char *active;     /* by symbol: a variable or time */
    int *column;               /* by symbol: variable, n for time */
    int n;
    bool tensor;
    int *variable; expr_id *constraint;   /* of the oracle's space */
    expr_id *field;            /* n + 1: X0, then 1 for time */
    expr_id *gauge;            /* by gauge field, n + 1 each: the field, then 0 */
    int gauges;
    int *solved;               /* by constraint: the variable solved for at modular points; NULL: not asked yet */
    expr_id *differential;     /* constraints x n, or NULL */
    unsigned char *is_free;    /* by variable: a column of a free function */
};

/* D(f) for D with n + 1 components. */
expr_id sym_derive(struct sym_work *w, const expr_id *D, expr_id f);
/* out[a] = [D, Y]^a + Y(theta) X0^a, n of them. */
void sym_bracket(struct sym_work *w, const expr_id *D, const expr_id *Y, expr_id *out);
/* v minus its part in K (K has unit columns at the free ones), n components, in place;
 * gauge: the fields, or the same composed with a map. */
void sym_modulo_gauge(struct sym_work *w, const expr_id *gauge, expr_id *v);
/* Is e zero on Pf? */
enum sym_truth sym_zero(struct sym_work *w, expr_id e);
enum sym_truth sym_and(enum sym_truth a, enum sym_truth b);
/* All of e[0..n) zero on Pf; otherwise the first that is not (or not decided) in *defect. */
enum sym_truth sym_all_zero(struct sym_work *w, const expr_id *e, int n, expr_id *defect);
/* Adds a defect with a readable form of e unless truth is SYM_TRUE; returns truth. */
enum sym_truth sym_note(struct sym_work *w, struct sym_check *c, const char *condition, expr_id e, enum sym_truth truth);
/* The entry of A, 0 where there is none; T is square where w->tensor. */
expr_id sym_entry(struct sym_work *w, int i, int j);

/* tensor.c */
void sym_field_preserves(struct sym_work *w, const expr_id *D, struct sym_check *c);
void sym_map_preserves(struct sym_work *w, const expr_id *phi, const expr_id *subst, struct sym_check *c);
void sym_presymplectic(struct sym_work *w, struct sym_result *out);

/* space.c: rows in echelon form modulo a prime. */
struct sym_space {
    int cols, rank;
    mp_limb_t **row;           /* by pivot column: 1 there, 0 before; or NULL */
    nmod_t mod;
};
void sym_space_init(struct sym_space *s, int cols, nmod_t mod);
void sym_space_clear(struct sym_space *s);
/* Reduces v (cols of it, overwritten) by the rows; true where it was independent and was added. */
bool sym_space_insert(struct sym_space *s, mp_limb_t *v);
void sym_space_reduce(const struct sym_space *s, mp_limb_t *v);
/* Every pivot column gets 0 in the other rows. */
/* By pivot column a row with 1 there, rank of them. Linear in the columns. */
bool sym_space_sane(const struct sym_space *s);
void sym_space_finish(struct sym_space *s);
/* The vectors that all rows annihilate, as rows of `out` (initialised here, finished). s is finished. */
void sym_space_kernel(const struct sym_space *s, struct sym_space *out);

/* ansatz.c: the functions that are combined. Listed ones first, then monomials by falling degree. */
struct sym_ansatz {
    expr_id *f; int count;
    expr_id *d;                /* count x (n + 1): partial derivatives */
};
/* False where there would be more than `limit`. */
bool sym_ansatz_init(struct sym_work *w, const struct sym_search *s, int degree, int limit, struct sym_ansatz *a);
void sym_ansatz_clear(struct sym_ansatz *a);

/* solve.c: linear equations sampled at random points of Pf modulo primes, and their
 * rational solutions. */
struct sym_spaces {
    struct sym_space equation;     /* what a solution must satisfy */
    struct sym_space trivial;      /* what a solution that counts as 0 must satisfy */
    struct sym_space gauge;        /* what one in the distinguished part satisfies beside */
    int points;
};
/* The same equations as expressions, each a row of an expression for each unknown. */
struct sym_table {
    expr_id *equation, *trivial, *gauge;   /* rows x cols; owned */
    int equations, trivials, gauges;
    bool differences;              /* trivial: the values less those at the first point */
};
void sym_table_clear(struct sym_table *t);
struct sym_problem {
    int cols;
    bool split;                    /* there is a distinguished part */
    const expr_id *node; int nodes;   /* every value that `rows` asks for */
    void (*rows)(void *ctx, struct num_modp *m, struct sym_spaces *s);
    bool (*table)(void *ctx, int most, struct sym_table *t);   /* false: more than `most` expressions; NULL: not had */
    void *ctx;
};
struct sym_solutions {
    fmpq *value; int count, room, cols;   /* by rows; the distinguished ones first */
    int distinguished;
};
/* A random point of Pf modulo a prime; false where this try fails (another may not). */
bool sym_modpoint(struct sym_work *w, int prime, uint64_t *random, struct points_modpoint *at);
/* False where the budget ends. */
bool sym_solve(struct sym_work *w, const struct sym_problem *p, struct sym_solutions *out, struct sym_evidence *evidence,
               struct sga_error *err);
void sym_solutions_clear(struct sym_solutions *s);
/* real.c: the spaces of a problem from its table at real points, modulo a prime of 60 bits. *enough: they are there; otherwise they are
 * empty, evidence->irrational: as entries are not rational. False where the budget ends. */
bool sym_real_spaces(struct sym_work *w, const struct sym_problem *p, struct sym_spaces *s, struct sym_evidence *evidence,
                     bool *enough, struct sga_error *err);

/* search.c, integrals.c, commutators.c, noether.c */
bool sym_search_fields(struct sym_work *w, const struct sym_search *s, struct sym_result *out, struct sga_error *err);
bool sym_search_integrals(struct sym_work *w, const struct sym_search *s, struct sym_result *out, struct sga_error *err);
bool sym_commutators(struct sym_work *w, struct sym_result *out, struct sga_error *err);
bool sym_noether(struct sym_work *w, const struct sym_request *request, struct sym_result *out, struct sga_error *err);
/* Sum of q[k] f[k * stride]. */
expr_id sym_combination(struct sym_work *w, const fmpq *q, const expr_id *f, int count, int stride);

#endif
