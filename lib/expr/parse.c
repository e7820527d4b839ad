/* The parser: operator precedence with a stack of its own, so that no nesting of a
 * user's text can reach the C stack.
 *
 * It alternates between two states: an operand is expected, or an operator is. Pending
 * operators, signs, parentheses and calls are frames; finished operands are handles.
 * (Shunting-yard; Dijkstra, MR 35, 1961.) */
#include "parser.h"

#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "literal.h"
#include "mem.h"

enum { DEFAULT_LENGTH = 1 << 20, DEFAULT_DEPTH = 1000, DEFAULT_EXPONENT = 10000, DEFAULT_DIGITS = 5000 };

bool parser_fail_here(struct parser *p, size_t at)
{
    if (!expr_store_ok(p->st)) {
        /* what grows while it is read was too large as it was written */
        bool bits = p->st->error->code == SGA_E_LIMIT_GROWTH;
        sga_fail(p->err, bits ? SGA_E_LIMIT_BITS : p->st->error->code, "%s", p->st->error->detail);
        *p->st->error = (struct sga_error){ 0 };
    }
    if (p->err && !p->err->line)
        lex_place(p->text, at, &p->err->line, &p->err->column);
    return false;
}

void parser_advance(struct parser *p)
{
    p->tok = lex_next(p->text, p->tok.start + p->tok.length);
}

void parser_push_value(struct parser *p, expr_id e)
{
    SGA_RESERVE(p->value, p->value_cap, p->values + 1);
    SGA_RESERVE(p->truth, p->truth_cap, p->values + 1);
    p->truth[p->values] = 0;
    p->value[p->values++] = e;
}

void parser_push_truth(struct parser *p, expr_id e)
{
    parser_push_value(p, e);
    p->truth[p->values - 1] = 1;
}

bool parser_in_condition(const struct parser *p)
{
    size_t k = p->frames;
    while (k && p->frame[k - 1].kind != CALL && p->frame[k - 1].kind != DER)
        k--;
    return k && p->frame[k - 1].lowered && p->frame[k - 1].lowered->kind == LOWERED_IF && !p->frame[k - 1].args;
}

bool parser_push_frame(struct parser *p, struct frame f)
{
    if (p->frames >= (size_t)p->g.max_depth)
        return FAIL(p, f.at, SGA_E_EXPR_DEPTH, "the expression is nested deeper than the limit of %d", p->g.max_depth);
    SGA_RESERVE(p->frame, p->frame_cap, p->frames + 1);
    p->frame[p->frames++] = f;
    return true;
}

struct frame *parser_top(struct parser *p)
{
    return p->frames ? p->frame + p->frames - 1 : NULL;
}

static expr_id power(struct parser *p, expr_id a, expr_id b)
{
    bool whole = expr_is_const(p->st, b) && fmpz_is_one(fmpq_denref(expr_const_value(p->st, b))) && fmpq_sgn(expr_const_value(p->st, b)) > 0;
    expr_id base = whole ? a : parser_settled(p, a), exponent = parser_settled(p, b);
    if ((base != a || exponent != b) && !literal_power(p->st, base, exponent, p->g.max_exponent, p->err))
        return EXPR_UNDEF;
    return literal_power(p->st, a, b, p->g.max_exponent, p->err);
}

static expr_id apply(struct parser *p, enum expr_op op, expr_id a, expr_id b)
{
    switch (op) {
    case EXPR_ADD: return expr_add(p->st, a, b);
    case EXPR_SUB: return expr_sub(p->st, a, b);
    case EXPR_MUL: return expr_mul(p->st, a, b);
    case EXPR_DIV:
        if (expr_is_zero(p->st, parser_settled(p, b))) {
            sga_fail(p->err, SGA_E_EXPR_UNDEFINED, expr_is_zero(p->st, b) ? "division by a constant that is 0"
                                                                            : "division by what is 0 wherever it has a value");
            return EXPR_UNDEF;
        }
        return expr_div(p->st, a, b);
    default:       return power(p, a, b);
    }
}

/* A comparison, or what joins conditions. */
static bool finish_logic(struct parser *p, struct frame f, expr_id b, bool truth, bool other)
{
    bool joins = f.logic == LOGIC_AND || f.logic == LOGIC_OR || f.logic == LOGIC_NOT;
    if (!joins && (truth || other))
        return FAIL(p, f.at, SGA_E_EXPR_SYNTAX, "comparisons do not chain, and compare numbers; write a < b and b < c");
    if (joins && !(truth && other))
        return FAIL(p, f.at, SGA_E_EXPR_SYNTAX, "and, or, not join conditions; a condition compares, like x > 0");
    expr_id a = f.kind == BINARY ? p->value[--p->values] : b, e = lowered_logic(p->st, f.logic, a, b);
    if (!e)
        return parser_fail_here(p, f.at);
    parser_push_truth(p, e);
    return true;
}

/* Finish the operator or sign on top of the stack. */
static bool finish_top(struct parser *p)
{
    struct frame f = p->frame[--p->frames];
    expr_id b = p->value[--p->values], e = b;
    bool truth = p->truth[p->values], other = f.kind == BINARY ? p->truth[p->values - 1] : truth;
    if (f.logic)
        return finish_logic(p, f, b, truth, other);
    if (truth || other)
        return FAIL(p, f.at, SGA_E_EXPR_SYNTAX, "a condition is no number to calculate with; if(condition, 1, 0) is one");
    if (f.kind == BINARY)
        e = apply(p, f.op, p->value[--p->values], b);
    else if (f.op == EXPR_NEG)
        e = expr_neg(p->st, b);
    if (!e)
        return parser_fail_here(p, f.at);
    parser_push_value(p, e);
    return true;
}

/* Finish what binds at least as strongly as prec (stronger, for ^). */
static bool finish_down_to(struct parser *p, int prec)
{
    for (struct frame *f = parser_top(p); f && f->kind <= PREFIX && (f->prec > prec || (f->prec == prec && prec != PREC_POWER));
         f = parser_top(p))
        if (!finish_top(p))
            return false;
    return true;
}

/* A comparison, and, or: in conditions only. */
static bool logic(struct parser *p, enum logic logic, int prec)
{
    size_t at = p->tok.start;
    if (!parser_in_condition(p))
        return FAIL(p, at, SGA_E_EXPR_SYNTAX, "a condition stands only where if has it: if(x > 0, a, b)");
    if (!finish_down_to(p, prec))
        return false;
    parser_advance(p);
    return parser_push_frame(p, (struct frame){ .kind = BINARY, .logic = logic, .prec = prec, .at = at });
}

static bool is_token(const struct parser *p, const char *word)
{
    return p->tok.length == strlen(word) && !memcmp(p->text + p->tok.start, word, p->tok.length);
}

static bool binary(struct parser *p, enum expr_op op, int prec)
{
    size_t at = p->tok.start;
    if (!finish_down_to(p, prec))
        return false;
    parser_advance(p);
    return parser_push_frame(p, (struct frame){ .kind = BINARY, .op = op, .prec = prec, .at = at });
}

static bool close_parenthesis(struct parser *p)
{
    if (!finish_down_to(p, PREC_OR))
        return false;
    struct frame *f = parser_top(p);
    if (!f || f->kind == BINARY)
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX, "this ) closes nothing; one ( is missing or one ) too many");
    struct frame done = *f;
    p->frames--;
    parser_advance(p);
    return done.kind == GROUP || (done.kind == DER ? parser_finish_der(p, done) : parser_finish_call(p, done));
}

static bool comma(struct parser *p)
{
    if (!finish_down_to(p, PREC_OR))
        return false;
    struct frame *f = parser_top(p);
    if (f && f->kind == CALL && f->lowered && f->lowered->kind == LOWERED_IF && !f->args && !p->truth[p->values - 1])
        return FAIL(p, f->at, SGA_E_EXPR_SYNTAX, "the first argument of if is a condition, which compares: if(x > 0, a, b)");
    if (!f || (f->kind != CALL && f->kind != DER))
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX,
                    "a comma stands outside the arguments of a function; decimals are written with a point");
    if (f->kind == DER && f->args)
        return FAIL(p, p->tok.start, SGA_E_EXPR_ARITY, "der takes an expression and an order: der(x*y) or der(x*y, 2)");
    f->args++;
    parser_advance(p);
    return true;
}

static bool equality(struct parser *p)
{
    if (parser_in_condition(p))
        return is_token(p, "==") ? logic(p, LOGIC_EQUAL, PREC_COMPARISON)
                                 : FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX, "in a condition equality is written ==");
    if (!p->equation)
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX,
                    "an equation is not expected here; write left - right, which is to vanish");
    if (p->equal_seen)
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX, "an equation has one sign of equality; this is the second");
    if (!finish_down_to(p, PREC_OR))
        return false;
    if (p->frames)
        return FAIL(p, parser_top(p)->at, SGA_E_EXPR_SYNTAX, "this ( is not closed before the sign of equality");
    p->equal_seen = true;
    return binary(p, EXPR_SUB, PREC_EQUAL);
}

static bool expected_operator(struct parser *p)
{
    char shown[LEX_SHOWN];
    lex_show(p->text, p->tok, shown);
    if (p->tok.kind == LEX_BAD)
        return parser_expected_operand(p);
    if (p->tok.kind == LEX_QUOTES)
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX, "a quote directly follows the name of a variable");
    return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX,
                "found %s where an operator is expected; a factor must be joined with *", shown);
}

/* Reads what may follow an operand; *operand turns true where another must come. */
static bool take_operator(struct parser *p, bool *operand)
{
    *operand = p->tok.kind != LEX_CLOSE;
    switch (p->tok.kind) {
    case LEX_PLUS:  return binary(p, EXPR_ADD, PREC_SUM);
    case LEX_MINUS: return binary(p, EXPR_SUB, PREC_SUM);
    case LEX_TIMES: return binary(p, EXPR_MUL, PREC_PRODUCT);
    case LEX_OVER:  return binary(p, EXPR_DIV, PREC_PRODUCT);
    case LEX_POWER: return binary(p, EXPR_POW, PREC_POWER);
    case LEX_CLOSE: return close_parenthesis(p);
    case LEX_COMMA: return comma(p);
    case LEX_EQUAL: return equality(p);
    case LEX_LESS:          return logic(p, LOGIC_LESS, PREC_COMPARISON);
    case LEX_LESS_EQUAL:    return logic(p, LOGIC_LESS_EQUAL, PREC_COMPARISON);
    case LEX_GREATER:       return logic(p, LOGIC_GREATER, PREC_COMPARISON);
    case LEX_GREATER_EQUAL: return logic(p, LOGIC_GREATER_EQUAL, PREC_COMPARISON);
    case LEX_NOT_EQUAL:     return logic(p, LOGIC_NOT_EQUAL, PREC_COMPARISON);
    case LEX_NAME:
        if (parser_in_condition(p) && (is_token(p, "and") || is_token(p, "or")))
            return is_token(p, "and") ? logic(p, LOGIC_AND, PREC_AND) : logic(p, LOGIC_OR, PREC_OR);
        return expected_operator(p);
    default:        return expected_operator(p);
    }
}

static bool run(struct parser *p)
{
    bool operand = true;
    while (operand || p->tok.kind != LEX_END)
        if (!(operand ? parser_take_operand(p, &operand) : take_operator(p, &operand)))
            return false;
    if (!finish_down_to(p, PREC_OR))
        return false;
    struct frame *f = parser_top(p);
    if (f && f->kind != BINARY)
        return FAIL(p, f->at, SGA_E_EXPR_SYNTAX, "this %s is not closed", f->kind == CALL ? "function's (" : "(");
    if (p->equation && !p->equal_seen)
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX, "an equation needs a sign of equality: left = right");
    return finish_down_to(p, PREC_EQUAL);
}

expr_id parser_read(struct expr_store *st, const char *text, const struct expr_grammar *g, bool equation, bool as_it_stands, struct sga_error *err)
{
    struct sga_error own = { 0 };
    struct parser p = { .st = st, .text = text, .err = err ? err : &own, .equation = equation, .as_it_stands = as_it_stands };
    if (!expr_store_ok(st) || p.err->code != SGA_E_OK) {
        sga_fail(p.err, st->error->code, "%s", st->error->detail);
        return EXPR_UNDEF;
    }
    if (g)
        p.g = *g;
    p.g.max_length = p.g.max_length ? p.g.max_length : DEFAULT_LENGTH;
    p.g.max_depth = p.g.max_depth ? p.g.max_depth : DEFAULT_DEPTH;
    p.g.max_exponent = p.g.max_exponent ? p.g.max_exponent : DEFAULT_EXPONENT;
    p.g.max_digits = p.g.max_digits ? p.g.max_digits : DEFAULT_DIGITS;
    size_t length = strlen(text);
    if (length > (size_t)p.g.max_length) {
        FAIL(&p, 0, SGA_E_EXPR_SIZE, "the expression has %zu bytes; the limit is %d", length, p.g.max_length);
        return EXPR_UNDEF;
    }
    p.tok = lex_next(text, 0);
    expr_id e = run(&p) ? p.value[0] : EXPR_UNDEF;
    free(p.frame);
    free(p.value);
    free(p.truth);
    return e;
}

bool expr_reserved(const char *name)
{
    return strcmp(name, "pi") == 0 || strcmp(name, "der") == 0 || expr_function(name, strlen(name)) != EXPR_UNDEF_OP;
}

expr_id expr_parse(struct expr_store *st, const char *text, const struct expr_grammar *g, struct sga_error *err)
{
    return parser_read(st, text, g, false, false, err);
}

expr_id expr_parse_equation(struct expr_store *st, const char *text, const struct expr_grammar *g,
                            struct sga_error *err)
{
    return parser_read(st, text, g, true, false, err);
}
