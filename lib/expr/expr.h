/* The expression store: a flat, append-only graph of shared nodes.
 *
 * Nodes are integer handles; children have smaller handles than their parents
 * and equal nodes are one node, so values, derivatives and checks are `for`
 * loops over handles. Constants are exact rationals. Nothing is ever expanded:
 * constructors simplify locally only (constants, 0 and 1, signs, x - x, x / x).
 *
 * Errors are sticky: once a limit is passed (`expr_store_ok` is false) every
 * constructor returns EXPR_UNDEF, and callers ask at the end of a stage. */
#ifndef SGA_EXPR_EXPR_H
#define SGA_EXPR_EXPR_H

#include <stdbool.h>
#include <stdint.h>
#include <flint/fmpq.h>

struct sga_error;

typedef int32_t expr_id;
#define EXPR_UNDEF ((expr_id)0)     /* node 0 of every store: has no value */
#define EXPR_NONE ((expr_id)-1)     /* no node at all */

/* What an operator is like, whatever its arguments are. */
enum expr_trait {
    EXPR_IS_TOTAL     = 1,       /* has a value for all real arguments */
    EXPR_IS_ODD       = 2,       /* f(-x) = -f(x) */
    EXPR_IS_EVEN      = 4,
    EXPR_IS_RISING    = 8,       /* f(x) has the sign of x, and is 0 at 0 only */
    EXPR_IS_ABOVE     = 16,      /* f >= 0 */
    EXPR_IS_NOT_ZERO  = 32,
    EXPR_HAS_BRANCHES = 64,      /* is one analytic function on each side of a surface */
    EXPR_HAS_END      = 128,     /* has no value beyond an end of its argument */
    EXPR_IS_STEEP     = 256,     /* has no derivative at an end, or at 0 */
    EXPR_FOLDS        = 512,     /* is one of the roots of an equation that has others */
    EXPR_GROWS        = 2048,    /* f(x) < f(y) where x < y and both have a value */
    EXPR_IS_1_AT_0    = 4096,
    EXPR_BENDS_AT_0   = 1024     /* what is said of branches and steepness is so where the argument is 0, and nowhere else */
};

/* The one table of operators:
 *    symbol, text in the grammar, arguments, traits, symbol of a function that undoes it everywhere;
 *    of functions of one argument (op.h): where they have values, which values, and the derivative. */
#define EXPR_OP_TABLE(X) \
    X(UNDEF_OP, "undefined", 0, 0, UNDEF_OP, ALL, ALL, NO_SLOPE) /* no value */ \
    X(CONST, "", 0, EXPR_IS_TOTAL, UNDEF_OP, ALL, ALL, NO_SLOPE) /* exact rational, a = index of the constant */ \
    X(PI,    "pi", 0, EXPR_IS_TOTAL, UNDEF_OP, ALL, ALL, NO_SLOPE) \
    X(SYM,   "", 0, EXPR_IS_TOTAL, UNDEF_OP, ALL, ALL, NO_SLOPE) /* a = symbol index */ \
    X(ADD,   "+", 2, EXPR_IS_TOTAL, UNDEF_OP, ALL, ALL, NO_SLOPE) \
    X(SUB,   "-", 2, EXPR_IS_TOTAL, UNDEF_OP, ALL, ALL, NO_SLOPE) \
    X(MUL,   "*", 2, EXPR_IS_TOTAL, UNDEF_OP, ALL, ALL, NO_SLOPE) \
    X(DIV,   "/", 2, 0, UNDEF_OP, ALL, ALL, NO_SLOPE) \
    X(NEG,   "-", 1, EXPR_IS_TOTAL | EXPR_IS_ODD, UNDEF_OP, ALL, ALL, NO_SLOPE) \
    X(POWI,  "^", 1, 0, UNDEF_OP, ALL, ALL, NO_SLOPE)            /* a ^ b, b an integer stored in the node, |b| >= 2 */ \
    X(POW,   "^", 2, EXPR_IS_ABOVE | EXPR_HAS_END | EXPR_IS_STEEP | EXPR_BENDS_AT_0, UNDEF_OP, ALL, FROM_0, NO_SLOPE) \
             /* real power of a base > 0: exp(b log a) */ \
    X(SIN,   "sin", 1, EXPR_IS_TOTAL | EXPR_IS_ODD, UNDEF_OP, ALL, UNIT, SLOPE_IS(1, COS)) \
    X(COS,   "cos", 1, EXPR_IS_TOTAL | EXPR_IS_EVEN | EXPR_IS_1_AT_0, UNDEF_OP, ALL, UNIT, SLOPE_IS(-1, SIN)) \
    X(TAN,   "tan", 1, EXPR_IS_ODD, UNDEF_OP, ALL, ALL, SLOPE(1, VALUE, 1, 1, 2, 2)) \
    X(ASIN,  "asin", 1, EXPR_IS_ODD | EXPR_HAS_END | EXPR_IS_STEEP | EXPR_FOLDS | EXPR_GROWS, SIN, UNIT, QUADRANTS, SLOPE(1, ARGUMENT, 1, -1, 2, -1)) \
    X(ACOS,  "acos", 1, EXPR_IS_ABOVE | EXPR_HAS_END | EXPR_IS_STEEP | EXPR_FOLDS, COS, UNIT, HALF_TURN, SLOPE(-1, ARGUMENT, 1, -1, 2, -1)) \
    X(ATAN,  "atan", 1, EXPR_IS_TOTAL | EXPR_IS_ODD | EXPR_IS_RISING | EXPR_GROWS, TAN, ALL, INSIDE_QUADRANTS, SLOPE(1, ARGUMENT, 1, 1, 2, -2)) \
    X(ATAN2, "atan2", 2, 0, UNDEF_OP, ALL, ALL, NO_SLOPE) \
    X(SINH,  "sinh", 1, EXPR_IS_TOTAL | EXPR_IS_ODD | EXPR_IS_RISING | EXPR_GROWS, ASINH, ALL, ALL, SLOPE_IS(1, COSH)) \
    X(COSH,  "cosh", 1, EXPR_IS_TOTAL | EXPR_IS_EVEN | EXPR_IS_ABOVE | EXPR_IS_NOT_ZERO | EXPR_IS_1_AT_0, UNDEF_OP, ALL, FROM_1, SLOPE_IS(1, SINH)) \
    X(TANH,  "tanh", 1, EXPR_IS_TOTAL | EXPR_IS_ODD | EXPR_IS_RISING | EXPR_GROWS, UNDEF_OP, ALL, INSIDE_UNIT, SLOPE(1, VALUE, 1, -1, 2, 2)) \
    X(ASINH, "asinh", 1, EXPR_IS_TOTAL | EXPR_IS_ODD | EXPR_IS_RISING | EXPR_GROWS, SINH, ALL, ALL, SLOPE(1, ARGUMENT, 1, 1, 2, -1)) \
    X(ACOSH, "acosh", 1, EXPR_IS_ABOVE | EXPR_HAS_END | EXPR_IS_STEEP | EXPR_FOLDS | EXPR_GROWS, COSH, FROM_1, FROM_0, SLOPE(1, ARGUMENT, -1, 1, 2, -1)) \
    X(ATANH, "atanh", 1, EXPR_IS_ODD | EXPR_HAS_END | EXPR_GROWS, TANH, INSIDE_UNIT, ALL, SLOPE(1, ARGUMENT, 1, -1, 2, -2)) \
    X(EXP,   "exp", 1, EXPR_IS_TOTAL | EXPR_IS_ABOVE | EXPR_IS_NOT_ZERO | EXPR_IS_1_AT_0 | EXPR_GROWS, UNDEF_OP, ALL, ABOVE_0, SLOPE(1, VALUE, 0, 1, 1, 2)) \
    X(LOG,   "log", 1, EXPR_HAS_END | EXPR_GROWS, EXP, ABOVE_0, ALL, SLOPE(1, ARGUMENT, 0, 1, 1, -2)) \
    X(SQRT,  "sqrt", 1, EXPR_IS_ABOVE | EXPR_HAS_END | EXPR_IS_STEEP | EXPR_FOLDS | EXPR_BENDS_AT_0 | EXPR_GROWS, UNDEF_OP, FROM_0, FROM_0, \
             SLOPE(1, VALUE, 0, 2, 1, -2)) \
    X(CBRT,  "cbrt", 1, EXPR_IS_ODD | EXPR_IS_RISING | EXPR_IS_STEEP | EXPR_BENDS_AT_0 | EXPR_GROWS, UNDEF_OP, ALL, ALL, SLOPE(1, VALUE, 0, 3, 2, -2)) \
    X(ABS,   "abs", 1, EXPR_IS_TOTAL | EXPR_IS_EVEN | EXPR_IS_ABOVE | EXPR_HAS_BRANCHES | EXPR_BENDS_AT_0, UNDEF_OP, ALL, FROM_0, SLOPE_IS(1, SIGN)) \
    X(SIGN,  "sign", 1, EXPR_IS_ODD | EXPR_IS_RISING | EXPR_HAS_BRANCHES | EXPR_BENDS_AT_0, UNDEF_OP, ALL, UNIT, NO_SLOPE) \
    X(MIN,   "min", 2, EXPR_IS_TOTAL | EXPR_HAS_BRANCHES, UNDEF_OP, ALL, ALL, NO_SLOPE) \
    X(MAX,   "max", 2, EXPR_IS_TOTAL | EXPR_HAS_BRANCHES, UNDEF_OP, ALL, ALL, NO_SLOPE) \
    X(SOLVE, "", 0, 0, UNDEF_OP, ALL, ALL, NO_SLOPE)             /* component b of the solution of linear solve a */

/* The functions of one argument that libm, MPFR and Arb all have, under the same name: symbol, name. */
#define EXPR_ELEMENTARY_TABLE(X) \
    X(SIN, sin) X(COS, cos) X(TAN, tan) X(ASIN, asin) X(ACOS, acos) X(ATAN, atan) X(SINH, sinh) X(COSH, cosh) \
    X(TANH, tanh) X(ASINH, asinh) X(ACOSH, acosh) X(ATANH, atanh) X(EXP, exp) X(LOG, log)

enum expr_op {
#define X(sym, text, args, traits, undo, domain, values, slope) EXPR_##sym,
    EXPR_OP_TABLE(X)
#undef X
    EXPR_OP_COUNT
};

enum expr_symbol_kind {
    EXPR_VARIABLE,      /* a state variable: has a derivative along the flow */
    EXPR_PARAMETER,     /* constant in time, left symbolic */
    EXPR_TIME,
    EXPR_VELOCITY,      /* derivative of a variable, where a form allows it */
    EXPR_FREE,          /* free function of a vector field (f1, f2, ...) */
    EXPR_SIGNAL         /* a given function of time, or a derivative of one (signal.h) */
};

struct expr_node {
    uint8_t op;
    int32_t a, b;       /* children, or what the table says */
};

struct expr_symbol {
    char *name;
    enum expr_symbol_kind kind;
    expr_id node;       /* the SYM node of this symbol */
    struct expr_table *table;   /* SIGNAL: its values, borrowed, or NULL where there are none */
    int order;          /* SIGNAL: which derivative of the table */
    bool mentioned;     /* by some expression that was read */
};

/* A matrix without its zeros (expr_rows.h): row i has the columns column[k], ascending, and entries entry[k] for
 * start[i] <= k < start[i + 1]. Owned. */
struct expr_rows {
    int *start, *column;
    expr_id *entry;
};

/* S y = r: S is m x m, without its zeros, rhs has m; SOLVE nodes refer to it. Kept as a node where elimination by symbols would blow up. */
struct expr_solve {
    int m;
    struct expr_rows matrix;
    expr_id *rhs;
    expr_id *child; int children; /* of large ones: what is in them, each once; NULL: the entries of the matrix, then rhs */
};

struct expr_marks;
struct expr_residue;
/* Of a hash table: what is there (0: nothing), and its hash, so that others are told apart without a look at them. */
struct expr_slot { int32_t is; uint32_t hash; };

struct expr_store {
    struct expr_node *node;   int nodes;   size_t node_cap;
    fmpq *constant;           int constants; size_t constant_cap;
    struct expr_symbol *symbol; int symbols; size_t symbol_cap;
    struct expr_solve *solve; int solves;  size_t solve_cap;
    struct expr_slot *hash;   uint32_t hash_mask;   /* of nodes */
    struct expr_slot *names;  uint32_t names_mask;  /* of symbols by name: index + 1 */
    int max_nodes;            /* 0: no limit */
    bool signs;               /* a node is a sign */
    long max_bits;            /* of one exact constant */
    double work_bits, max_work_bits;   /* of all constants made so far; 0: no limit */
    double deadline, seconds; /* sga_now() value past which the error is set (0: none), and what was granted */
    long work;                /* since the clock was looked at */
    struct expr_marks *marks; /* for cones */
    struct expr_residue *residue; size_t residue_cap;   /* residue.h */
    bool signals_fixed;       /* no derivative of a signal may be added any more */
    struct sga_error *error;  /* owned; sticky */
};

void expr_store_init(struct expr_store *st);
void expr_store_clear(struct expr_store *st);
/* No error so far. */
bool expr_store_ok(const struct expr_store *st);

/* Whether the nodes from `from` on keep the store's rules: children below parents, operators and symbols of the tables. Asserted where
 * a stage of a job ends. */
bool expr_store_sane(const struct expr_store *st, int from);

/* So many nodes are about to be made or walked over: looks at the clock from time to time. */
bool expr_store_work(struct expr_store *st, long nodes);

/* Operator facts from the table. */
const char *expr_op_text(enum expr_op op);
int expr_op_args(enum expr_op op);
unsigned expr_op_traits(enum expr_op op);            /* EXPR_IS_*, EXPR_HAS_*, ... */
/* g with x = g(f(x)) wherever f has a value; EXPR_UNDEF_OP: none that is asked for without a look at f's value (exp, tanh, sqrt). */
enum expr_op expr_op_undone(enum expr_op op);
/* What e divides by; EXPR_UNDEF where it is no quotient or negative power. */
expr_id expr_divisor(const struct expr_store *st, expr_id e);
/* The function with this name (sin, atan2, ...); EXPR_UNDEF_OP if there is none. */
enum expr_op expr_function(const char *name, size_t len);

/* Symbols. Adding a name twice returns the first node if the kinds agree,
 * otherwise EXPR_UNDEF. Names are copied. */
expr_id expr_symbol_add(struct expr_store *st, const char *name, enum expr_symbol_kind kind);
/* Index into st->symbol, or -1. */
int expr_symbol_find(const struct expr_store *st, const char *name, size_t len);

/* Constructors. */
expr_id expr_int(struct expr_store *st, long v);
expr_id expr_rational(struct expr_store *st, long p, long q);
expr_id expr_fmpq(struct expr_store *st, const fmpq_t q);
expr_id expr_double(struct expr_store *st, double v);              /* exactly; v is finite */
expr_id expr_pi(struct expr_store *st);
expr_id expr_add(struct expr_store *st, expr_id a, expr_id b);
expr_id expr_sub(struct expr_store *st, expr_id a, expr_id b);
expr_id expr_mul(struct expr_store *st, expr_id a, expr_id b);
expr_id expr_div(struct expr_store *st, expr_id a, expr_id b);
expr_id expr_neg(struct expr_store *st, expr_id a);
expr_id expr_powi(struct expr_store *st, expr_id a, long n);
/* Any power: integer constants become POWI, 1/2 sqrt, others POW. */
expr_id expr_pow(struct expr_store *st, expr_id a, expr_id b);
expr_id expr_fun(struct expr_store *st, enum expr_op op, expr_id a);
expr_id expr_fun2(struct expr_store *st, enum expr_op op, expr_id a, expr_id b);
/* A new linear solve (copies the handles; matrix: m x m by rows); returns its index for expr_solution. */
int expr_solve_add(struct expr_store *st, int m, const expr_id *matrix, const expr_id *rhs);
int expr_solve_add_rows(struct expr_store *st, int m, const struct expr_rows *matrix, const expr_id *rhs);
expr_id expr_solution(struct expr_store *st, int solve, int component);

/* Questions. */
static inline enum expr_op expr_op_of(const struct expr_store *st, expr_id e) { return (enum expr_op)st->node[e].op; }
static inline bool expr_is_const(const struct expr_store *st, expr_id e) { return st->node[e].op == EXPR_CONST; }
bool expr_is_zero(const struct expr_store *st, expr_id e);         /* the constant 0 */
bool expr_is_one(const struct expr_store *st, expr_id e);
bool expr_is_int(const struct expr_store *st, expr_id e, long v);  /* the constant v */
const fmpq *expr_const_value(const struct expr_store *st, expr_id e);

/* Children: how many, and the k-th. SOLVE has the entries of its matrix that are not 0, and m more; a large one has each that is different once. */
int expr_children(const struct expr_store *st, expr_id e);
expr_id expr_child(const struct expr_store *st, expr_id e, int k);

/* A reusable mark for walks over part of the graph. */
struct expr_cone {
    struct expr_marks *from;              /* where stamps and places are lent from; NULL: not yet */
    uint32_t *stamp; size_t stamp_cap; uint32_t now;
    expr_id *list;   size_t list_cap;  int count;
    int *place;      size_t place_cap;    /* by node, only after expr_cone_index */
};
void expr_cone_init(struct expr_cone *c);
void expr_cone_clear(struct expr_cone *c);
/* All nodes under the given roots, in increasing order (children first), into
 * c->list[0..count). Cost: the size of the cone, times log for the sort, whatever the size of the store. */
void expr_cone_of(const struct expr_store *st, struct expr_cone *c, const expr_id *roots, int nroots);
/* The same, but for what lies below solutions of linear systems (EXPR_SOLVE). False, and the list is not to be used: there are more symbols
 * than `most`; then it costs what was walked until so many were met. */
bool expr_cone_above_solves(const struct expr_store *st, struct expr_cone *c, const expr_id *roots, int nroots, int most);
/* The place of e in the list, after expr_cone_index; -1: it is not in the cone. */
static inline int expr_cone_place(const struct expr_cone *c, expr_id e)
{
    return (size_t)e < c->stamp_cap && c->stamp[e] == c->now ? c->place[e] : -1;
}

/* Whether e depends on the symbol; the cone is used for the walk. */
bool expr_depends(const struct expr_store *st, struct expr_cone *c, expr_id e, int symbol);

/* c->place[e] = position of e in c->list, for the nodes of the list (others: undefined). */
void expr_cone_index(struct expr_cone *c);
/* Whether functions with branches (EXPR_HAS_BRANCHES) are among what these are made of. Cost: their cone. */
bool expr_has_branches(const struct expr_store *st, const expr_id *e, int count);

/* Replace symbols: for each node of the roots' cones, symbols i with map[i] != 0
 * become map[i] (map has st->symbols entries). Roots are replaced in place. Cost: their cones. */
void expr_substitute(struct expr_store *st, expr_id *roots, int nroots, const expr_id *map);

/* The root with nodes e of its cone that have by[e] != 0 replaced by that (by has an entry for each node of the
 * store), in which nodes are replaced too where it is in the cone itself. */
expr_id expr_replace(struct expr_store *st, expr_id root, const expr_id *by);

/* The symbols of another store, under the same indices, into one without any. */
void expr_copy_symbols(struct expr_store *to, const struct expr_store *from);
/* Copies of roots into that store, in place, with symbols i that have map[i] != 0 (nodes of
 * `to`) replaced; a root that has no value then is EXPR_UNDEF. */
void expr_copy(struct expr_store *to, const struct expr_store *from, expr_id *roots, int nroots, const expr_id *map);

#endif
