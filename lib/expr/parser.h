/* Inside this folder: the parser between its files. parse.c goes through the text and joins operands;
 * parse_operand.c reads them. */
#ifndef SGA_EXPR_PARSER_H
#define SGA_EXPR_PARSER_H

#include "lex.h"
#include "lowered.h"
#include "parse.h"

enum { PREC_EQUAL, PREC_OR, PREC_AND, PREC_NOT, PREC_COMPARISON, PREC_SUM, PREC_PRODUCT, PREC_SIGN, PREC_POWER };
enum { PARSER_MAX_ORDER = 64 };      /* of a derivative */

struct frame {
    enum { BINARY, PREFIX, GROUP, CALL, DER } kind;
    enum expr_op op;      /* of the operator, sign or function */
    enum logic logic;     /* BINARY, PREFIX: of comparisons and what joins them, in the place of op; 0 */
    const struct lowered *lowered;   /* CALL: a function that is written by others, in the place of op; or NULL */
    int prec;
    int args;             /* CALL, DER: commas so far */
    size_t at;            /* byte of the text, for errors */
};

struct parser {
    struct expr_store *st;
    const char *text;
    struct expr_grammar g;
    struct sga_error *err;
    struct lex_token tok;
    bool equation;        /* a sign of equality is asked for */
    bool equal_seen;
    bool as_it_stands;    /* what is read is what was printed of another text: no parser_settled inside */
    struct frame *frame; size_t frames, frame_cap;
    expr_id *value;      size_t values, value_cap;
    unsigned char *truth; size_t truth_cap;   /* by value: it is a condition */
};

/* Gives an error that err has, or just got from the store, its place. Always false. */
bool parser_fail_here(struct parser *p, size_t at);

#define FAIL(p, at, code, ...) (sga_fail((p)->err, (code), __VA_ARGS__), parser_fail_here((p), (at)))

/* parse_settled.c. The rational number that e is once its sums and products are sorted, as its print is: x*(x/x^2) is 1; else e. What has no
 * value at it is refused here, at its place, or nobody could read it back. */
expr_id parser_settled(const struct parser *p, expr_id e);
/* parse.c. Reads a text that is no equation, with or without parser_settled. */
expr_id parser_read(struct expr_store *st, const char *text, const struct expr_grammar *g, bool equation, bool as_it_stands, struct sga_error *err);

void parser_advance(struct parser *p);
void parser_push_value(struct parser *p, expr_id e);       /* a number */
void parser_push_truth(struct parser *p, expr_id e);       /* a condition: 1 or 0 */
/* Whether what is read belongs to the condition of if. */
bool parser_in_condition(const struct parser *p);
bool parser_push_frame(struct parser *p, struct frame f);
struct frame *parser_top(struct parser *p);             /* NULL: nothing is pending */

/* parse_operand.c. Reads what may begin an operand; *operand turns false once one is complete. */
bool parser_take_operand(struct parser *p, bool *operand);
/* Says that no operand stands where one must. */
bool parser_expected_operand(struct parser *p);
/* All arguments of a call, or of der, are on the value stack: replace them by the node. */
bool parser_finish_call(struct parser *p, struct frame f);
bool parser_finish_der(struct parser *p, struct frame f);

#endif
