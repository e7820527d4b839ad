/* What a derivation is written on: a store of its own with the request's symbols, the velocities as symbols named `der(x)`, and the functions
 * that an answer leaves free. Its expressions print in the grammar and in LaTeX. */
#ifndef SGA_RUN_SHEET_H
#define SGA_RUN_SHEET_H

#include "model.h"

struct job;
struct sga_buf;

struct derivation_sheet {
    struct job *j;
    struct export_model m;         /* its store, and by symbol the LaTeX */
    struct export_source source;   /* empty, for m */
    int first;                     /* the velocity of variable i is the symbol first + i */
    int free;                      /* the free function k is the symbol free + k */
    expr_id *none;                 /* by symbol of the request's store: 0 */
    expr_id *alias;                /* by symbol: what a name of an answer's part stands for */
    int aliases;
};

/* Cost: the request's symbols. */
void derivation_sheet_open(struct derivation_sheet *s, struct job *j);
void derivation_sheet_close(struct derivation_sheet *s);
/* A copy of an expression of the request's store; EXPR_UNDEF stays. */
expr_id derivation_sheet_copy(struct derivation_sheet *s, expr_id e);
/* A text of the answer; EXPR_UNDEF: it cannot be read, or uses parts that cannot. */
expr_id derivation_sheet_read(struct derivation_sheet *s, const char *text);
expr_id derivation_sheet_velocity(const struct derivation_sheet *s, int variable);
/* d e / dt with the velocities as symbols: sum of d e / d x_i der(x_i) and d e / d t, signals' derivatives among it. */
expr_id derivation_sheet_rate(struct derivation_sheet *s, expr_id e);
/* Marks, by variable, the velocities that e depends on. */
void derivation_sheet_velocities(struct derivation_sheet *s, expr_id e, unsigned char *marked);
/* Appends the text; false, with nothing appended: it is too long, or there is none. */
bool derivation_sheet_text(struct derivation_sheet *s, expr_id e, struct sga_buf *out);
bool derivation_sheet_latex(struct derivation_sheet *s, expr_id e, struct sga_buf *out);

#endif
