/* The one shape that every form is brought to: A(x, t) x' = alpha(x, t), sparse,
 * any number of rows, with functions that vanish on the manifold to start from. */
#ifndef SGA_SYS_SYSTEM_H
#define SGA_SYS_SYSTEM_H

#include "expr.h"

struct sys_entry {
    int col;              /* variable index */
    expr_id value;
};

struct sys_row {
    struct sys_entry *entry;   /* increasing col, none is the constant 0 */
    int entries;
    expr_id alpha;
    const char *source;        /* what the row came from, for evidence ("row 3", "equations[0]"); owned */
};

struct sys_variable {
    int symbol;                /* index into store->symbol */
    const char *role;          /* "variable", "derivative", "input", "multiplier", ...; static text */
};

struct sys_system {
    struct expr_store *store;  /* not owned */
    struct sys_variable *variable; int variables;
    struct sys_row *row;       int rows;
    expr_id *restriction;      int restrictions;
    int *parameter;            int parameters;   /* symbols left symbolic */
    int time;                  /* symbol index of the independent variable */
    /* Given functions of time (expr/signal.h): their symbols. They and as many of their derivatives
     * as may be needed are listed as parameters too, since they can have any values. */
    int *signal;               int signals;
    bool square;               /* as many equations as unknowns in the user's own form, no restrict */
};

void sys_init(struct sys_system *s, struct expr_store *st);
void sys_clear(struct sys_system *s);
void sys_add_variable(struct sys_system *s, int symbol, const char *role);
/* Drops the rows, for others. */
void sys_clear_rows(struct sys_system *s);
/* Adds an empty row; source is copied. Returns its index. */
int sys_add_row(struct sys_system *s, expr_id alpha, const char *source);
/* Adds an entry to the last row or an earlier one; entries that are the constant 0 are dropped,
 * and one at the same column is added to. */
void sys_add_entry(struct sys_system *s, int row, int col, expr_id value);
void sys_add_restriction(struct sys_system *s, expr_id e);
void sys_add_parameter(struct sys_system *s, int symbol);
void sys_add_signal(struct sys_system *s, int symbol);
/* Some of the variables and rows of a system, by index. */
struct sys_part {
    const int *variable; int variables;
    const int *row;      int rows;
};

/* A system of its own with everything that `from` has, over the same store. */
void sys_copy(struct sys_system *to, const struct sys_system *from);
/* The same with some of its variables and rows only (part; NULL: all; the rows must hold no others of the variables), and with map[symbol] put
 * in wherever it is not 0 (NULL: nothing is); parameters that are replaced are left out. */
void sys_copy_part(struct sys_system *to, const struct sys_system *from, const struct sys_part *part, const expr_id *map);
/* Whether variables are symbols that differ, and rows hold entries at rising columns within them, none of them the constant 0. Asserted where a
 * stage of a job ends. */
bool sys_sane(const struct sys_system *s);
/* The entries of each row and its right side, row by row, into *list (malloced). Returns how many. */
int sys_expressions(const struct sys_system *s, expr_id **list);

#endif
