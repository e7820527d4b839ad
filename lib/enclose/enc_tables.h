/* Inside this folder and by who asks it for a motion: tables (expr/table.h) in balls. Between knots a table is a polynomial in time. */
#ifndef SGA_ENCLOSE_ENC_TABLES_H
#define SGA_ENCLOSE_ENC_TABLES_H

#include "table_balls.h"

struct enc_tables {
    int count;
    struct expr_table **table;       /* borrowed; the exact times are there */
    struct num_table_balls *balls;   /* by table, once there is a precision */
    arb_ptr piece;                   /* count x NUM_TABLE_PIECE: of the intervals table->at */
};

/* Of these tables, a list that is copied; num_table_exact has been called. */
void enc_tables_init(struct enc_tables *t, struct expr_table *const *table, int count);
void enc_tables_clear(struct enc_tables *t);
/* Coefficients with prec bits from now on; enc_tables_enter is due. */
void enc_tables_round(struct enc_tables *t, slong prec);
/* Each table's `at` was set: its polynomial is that one's from now on, for programs that were made with t too. */
void enc_tables_enter(struct enc_tables *t);
/* The place of a table; -1. t may be NULL. */
int enc_tables_find(const struct enc_tables *t, const struct expr_table *u);

#endif
