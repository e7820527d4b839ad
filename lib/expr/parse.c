/* The parser: operator precedence with a stack of its own, so that no nesting of a
 * user's text can reach the C stack.
 *
 * It alternates between two states: an operand is expected, or an operator is. Pending
 * operators, signs, parentheses and calls are frames; finished operands are handles.
 * (Shunting-yard; Dijkstra, MR 35, 1961.) */
#include "parse.h"

#include <stdlib.h>
#include <string.h>

#include "lex.h"
#include "literal.h"
#include "mem.h"
#include "parse_names.h"
#include "signal.h"

enum { PREC_EQUAL, PREC_SUM, PREC_PRODUCT, PREC_SIGN, PREC_POWER };
enum { DEFAULT_LENGTH = 1 << 20, DEFAULT_DEPTH = 1000, DEFAULT_EXPONENT = 10000, DEFAULT_DIGITS = 5000,
       MAX_ORDER = 64 };

struct frame {
    enum { BINARY, PREFIX, GROUP, CALL, DER } kind;
    enum expr_op op;      /* of the operator, sign or function */
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
    struct frame *frame; size_t frames, frame_cap;
    expr_id *value;      size_t values, value_cap;
};

/* Gives an error that err has, or just got from the store, its place. */
static bool fail_here(struct parser *p, size_t at)
{
    if (!expr_store_ok(p->st)) {
        /* what grows while it is read was too large as it was written */
        bool bits = p->st->error.code == SGA_E_LIMIT_GROWTH;
        sga_fail(p->err, bits ? SGA_E_LIMIT_BITS : p->st->error.code, "%s", p->st->error.detail);
        p->st->error = (struct sga_error){ 0 };
    }
    if (p->err && !p->err->line)
        lex_place(p->text, at, &p->err->line, &p->err->column);
    return false;
}

#define FAIL(p, at, code, ...) (sga_fail((p)->err, (code), __VA_ARGS__), fail_here((p), (at)))

static void advance(struct parser *p)
{
    p->tok = lex_next(p->text, p->tok.start + p->tok.length);
}

static void push_value(struct parser *p, expr_id e)
{
    SGA_RESERVE(p->value, p->value_cap, p->values + 1);
    p->value[p->values++] = e;
}

static bool push_frame(struct parser *p, struct frame f)
{
    if (p->frames >= (size_t)p->g.max_depth)
        return FAIL(p, f.at, SGA_E_EXPR_DEPTH, "the expression is nested deeper than the limit of %d", p->g.max_depth);
    SGA_RESERVE(p->frame, p->frame_cap, p->frames + 1);
    p->frame[p->frames++] = f;
    return true;
}

static struct frame *top(struct parser *p)
{
    return p->frames ? p->frame + p->frames - 1 : NULL;
}

static expr_id apply(struct parser *p, enum expr_op op, expr_id a, expr_id b)
{
    switch (op) {
    case EXPR_ADD: return expr_add(p->st, a, b);
    case EXPR_SUB: return expr_sub(p->st, a, b);
    case EXPR_MUL: return expr_mul(p->st, a, b);
    case EXPR_DIV:
        if (expr_is_zero(p->st, b))
            sga_fail(p->err, SGA_E_EXPR_UNDEFINED, "division by a constant that is 0");
        return expr_div(p->st, a, b);
    default:       return literal_power(p->st, a, b, p->g.max_exponent, p->err);
    }
}

/* Finish the operator or sign on top of the stack. */
static bool finish_top(struct parser *p)
{
    struct frame f = p->frame[--p->frames];
    expr_id b = p->value[--p->values], e = b;
    if (f.kind == BINARY)
        e = apply(p, f.op, p->value[--p->values], b);
    else if (f.op == EXPR_NEG)
        e = expr_neg(p->st, b);
    if (!e)
        return fail_here(p, f.at);
    push_value(p, e);
    return true;
}

/* Finish what binds at least as strongly as prec (stronger, for ^). */
static bool finish_down_to(struct parser *p, int prec)
{
    for (struct frame *f = top(p); f && f->kind <= PREFIX && (f->prec > prec || (f->prec == prec && prec != PREC_POWER));
         f = top(p))
        if (!finish_top(p))
            return false;
    return true;
}

static bool binary(struct parser *p, enum expr_op op, int prec)
{
    size_t at = p->tok.start;
    if (!finish_down_to(p, prec))
        return false;
    advance(p);
    return push_frame(p, (struct frame){ .kind = BINARY, .op = op, .prec = prec, .at = at });
}

/* --- operands --- */

static bool expected_operand(struct parser *p)
{
    char shown[LEX_SHOWN];
    struct frame *f = top(p);
    size_t at = p->tok.start;
    lex_show(p->text, p->tok, shown);
    if (p->tok.kind == LEX_BAD) {
        const char *advice = lex_instead(p->text, p->tok);
        return FAIL(p, at, SGA_E_EXPR_SYNTAX, "found %s, which is not in the grammar%s%s", shown,
                    advice ? "; " : "", advice ? advice : "");
    }
    if (p->tok.kind == LEX_END && !p->frames && !p->values)
        return FAIL(p, at, SGA_E_EXPR_SYNTAX, "the expression is empty; write 0 for nothing");
    if (p->tok.kind == LEX_CLOSE && f && f->kind == CALL && !f->args)
        return FAIL(p, f->at, SGA_E_EXPR_ARITY, "the function %s has no argument", expr_op_text(f->op));
    if (p->tok.kind == LEX_CLOSE && f && f->kind == GROUP)
        return FAIL(p, at, SGA_E_EXPR_SYNTAX, "the parentheses are empty");
    return FAIL(p, at, SGA_E_EXPR_SYNTAX, "found %s where a number, a name or ( is expected", shown);
}

static expr_id signal_derivative(struct expr_store *st, int symbol, long order)
{
    expr_id e = st->symbol[symbol].node;
    for (long k = 0; k < order && e; k++)
        e = expr_signal_rate(st, st->node[e].a);
    return e;
}

static bool derivative(struct parser *p, struct lex_token name, int symbol, long order)
{
    char shown[LEX_SHOWN];
    lex_show(p->text, name, shown);
    if (order > MAX_ORDER)
        return FAIL(p, name.start, SGA_E_EXPR_DERIVATIVE, "a derivative of %s has an order past the limit of %d",
                    shown, MAX_ORDER);
    bool signal = p->st->symbol[symbol].kind == EXPR_SIGNAL;
    expr_id e = signal ? signal_derivative(p->st, symbol, order)
              : p->g.derivative ? p->g.derivative(p->g.ctx, symbol, (int)order) : EXPR_UNDEF;
    if (!e && !expr_store_ok(p->st))
        return fail_here(p, name.start);
    if (!e)
        return FAIL(p, name.start, SGA_E_EXPR_DERIVATIVE, "derivative number %ld of %s is not allowed here%s", order,
                    shown, p->g.derivative ? "" : "; only names without quotes are");
    push_value(p, e);
    return true;
}

/* The symbol that a name means, or -1 with err filled. */
static int symbol_of(struct parser *p, struct lex_token tok, bool called)
{
    int symbol = expr_symbol_find(p->st, p->text + tok.start, tok.length);
    if (symbol < 0) {
        parse_unknown_name(p->st, p->text, tok, called, p->err);
        fail_here(p, tok.start);
    }
    return symbol;
}

static bool is_word(const char *text, struct lex_token tok, const char *word)
{
    return tok.length == strlen(word) && memcmp(text + tok.start, word, tok.length) == 0;
}

/* Whether what follows "der(" is a name, perhaps with quotes, and nothing more. */
static bool names_one_variable(const struct parser *p)
{
    struct lex_token t = p->tok;
    if (t.kind != LEX_NAME)
        return false;
    t = lex_next(p->text, t.start + t.length);
    if (t.kind == LEX_QUOTES)
        t = lex_next(p->text, t.start + t.length);
    int symbol = expr_symbol_find(p->st, p->text + p->tok.start, p->tok.length);
    bool fixed = symbol >= 0 && p->st->symbol[symbol].kind != EXPR_VARIABLE && p->st->symbol[symbol].kind != EXPR_VELOCITY;
    return (t.kind == LEX_CLOSE || t.kind == LEX_COMMA) && !fixed && !is_word(p->text, p->tok, "pi");
}

/* der(x) or der(x, 2), or der of an expression; the current token is `der`. der(x') is x''. */
static bool der_call(struct parser *p, bool *operand)
{
    size_t at = p->tok.start;
    *operand = false;
    advance(p);
    if (p->tok.kind != LEX_OPEN)
        return FAIL(p, at, SGA_E_EXPR_SYNTAX, "der needs ( after it: der(x) or der(x, 2)");
    advance(p);
    struct lex_token name = p->tok;
    if (p->g.total && !names_one_variable(p)) {
        *operand = true;
        return push_frame(p, (struct frame){ .kind = DER, .at = at });
    }
    if (name.kind != LEX_NAME)
        return FAIL(p, p->tok.start, SGA_E_EXPR_DERIVATIVE, "der takes the name of a variable");
    int symbol = symbol_of(p, name, false);
    if (symbol < 0)
        return false;
    advance(p);
    long order = 1;
    if (p->tok.kind == LEX_QUOTES) {
        order += p->tok.length > MAX_ORDER ? MAX_ORDER : (long)p->tok.length;
        advance(p);
    }
    if (p->tok.kind == LEX_COMMA) {
        advance(p);
        char *end;
        long times = p->tok.kind == LEX_NUMBER ? strtol(p->text + p->tok.start, &end, 10) : 0;
        if (times < 1 || end != p->text + p->tok.start + p->tok.length)
            return FAIL(p, p->tok.start, SGA_E_EXPR_DERIVATIVE, "the order of a derivative is a positive integer");
        order += (times > MAX_ORDER ? MAX_ORDER + 1 : times) - 1;
        advance(p);
    }
    if (p->tok.kind != LEX_CLOSE) {
        char shown[LEX_SHOWN];
        lex_show(p->text, p->tok, shown);
        return FAIL(p, p->tok.start, SGA_E_EXPR_DERIVATIVE,
                    "found %s inside der, which takes the name of a variable and an order: der(x) or der(x, 2)", shown);
    }
    advance(p);
    return derivative(p, name, symbol, order);
}

static bool name_operand(struct parser *p, bool *operand)
{
    struct lex_token name = p->tok;
    if (is_word(p->text, name, "der"))
        return der_call(p, operand);
    if (is_word(p->text, name, "pi")) {
        advance(p);
        push_value(p, expr_pi(p->st));
        *operand = false;
        return expr_store_ok(p->st) || fail_here(p, name.start);
    }
    enum expr_op op = expr_function(p->text + name.start, name.length);
    advance(p);
    if (op && p->tok.kind != LEX_OPEN)
        return FAIL(p, name.start, SGA_E_EXPR_SYNTAX, "the function %s needs its argument in parentheses",
                    expr_op_text(op));
    if (op) {
        advance(p);
        return push_frame(p, (struct frame){ .kind = CALL, .op = op, .at = name.start });
    }
    int symbol = symbol_of(p, name, p->tok.kind == LEX_OPEN);
    if (symbol < 0)
        return false;
    *operand = false;
    if (p->tok.kind == LEX_QUOTES && p->tok.start == name.start + name.length) {
        long order = p->tok.length > MAX_ORDER ? MAX_ORDER + 1 : (long)p->tok.length;
        advance(p);
        return derivative(p, name, symbol, order);
    }
    bool replaced = symbol < p->g.values && p->g.value[symbol];
    push_value(p, replaced ? p->g.value[symbol] : p->st->symbol[symbol].node);
    return true;
}

/* Reads what may begin an operand; *operand turns false once one is complete. */
static bool take_operand(struct parser *p, bool *operand)
{
    size_t at = p->tok.start;
    expr_id e;
    switch (p->tok.kind) {
    case LEX_NUMBER:
        e = literal_number(p->st, p->text + at, p->tok.length, p->g.max_digits, p->err);
        if (!e)
            return fail_here(p, at);
        push_value(p, e);
        *operand = false;
        advance(p);
        return true;
    case LEX_NAME:
        return name_operand(p, operand);
    case LEX_PLUS:
    case LEX_MINUS:
        e = p->tok.kind == LEX_MINUS;
        advance(p);
        return push_frame(p, (struct frame){ .kind = PREFIX, .op = e ? EXPR_NEG : EXPR_ADD, .prec = PREC_SIGN, .at = at });
    case LEX_OPEN:
        advance(p);
        return push_frame(p, (struct frame){ .kind = GROUP, .at = at });
    default:
        return expected_operand(p);
    }
}

/* --- after an operand --- */

/* All arguments of a call are on the value stack: replace them by its node. */
static bool finish_call(struct parser *p, struct frame f)
{
    int args = f.args + 1;
    bool folds = f.op == EXPR_MIN || f.op == EXPR_MAX;
    int want = expr_op_args(f.op);
    if (folds ? args < 2 : args != want)
        return FAIL(p, f.at, SGA_E_EXPR_ARITY, "the function %s takes %d argument%s%s, not %d", expr_op_text(f.op), want,
                    want == 1 ? "" : "s", folds ? " or more" : "", args);
    expr_id *arg = p->value + p->values - args;
    const char *outside = literal_outside(p->st, f.op, arg[0], want == 2 ? arg[1] : EXPR_UNDEF);
    if (outside)
        return FAIL(p, f.at, SGA_E_EXPR_UNDEFINED, "%s has no real value: %s", expr_op_text(f.op), outside);
    expr_id e = want == 1 ? expr_fun(p->st, f.op, arg[0]) : expr_fun2(p->st, f.op, arg[0], arg[1]);
    for (int i = 2; i < args; i++)
        e = expr_fun2(p->st, f.op, e, arg[i]);
    if (!e)
        return fail_here(p, f.at);
    p->values -= (size_t)args;
    push_value(p, e);
    return true;
}

/* der(e) or der(e, k), its arguments on the value stack. */
static bool finish_der(struct parser *p, struct frame f)
{
    long order = 1;
    if (f.args) {
        expr_id k = p->value[--p->values];
        const fmpq *q = expr_is_const(p->st, k) ? expr_const_value(p->st, k) : NULL;
        if (!q || !fmpz_is_one(fmpq_denref(q)) || fmpz_cmp_si(fmpq_numref(q), 1) < 0 || fmpz_cmp_si(fmpq_numref(q), MAX_ORDER) > 0)
            return FAIL(p, f.at, SGA_E_EXPR_DERIVATIVE, "the order of a derivative is an integer from 1 to %d", MAX_ORDER);
        order = fmpz_get_si(fmpq_numref(q));
    }
    expr_id e = p->value[--p->values];
    for (long k = 0; k < order && e; k++)
        e = p->g.total(p->g.ctx, e);
    if (!e && !expr_store_ok(p->st))
        return fail_here(p, f.at);
    if (!e)
        return FAIL(p, f.at, SGA_E_EXPR_DERIVATIVE, "this derivative needs one of an order past the limit of %d", MAX_ORDER);
    push_value(p, e);
    return true;
}

static bool close_parenthesis(struct parser *p)
{
    if (!finish_down_to(p, PREC_SUM))
        return false;
    struct frame *f = top(p);
    if (!f || f->kind == BINARY)
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX, "this ) closes nothing; one ( is missing or one ) too many");
    struct frame done = *f;
    p->frames--;
    advance(p);
    return done.kind == GROUP || (done.kind == DER ? finish_der(p, done) : finish_call(p, done));
}

static bool comma(struct parser *p)
{
    if (!finish_down_to(p, PREC_SUM))
        return false;
    struct frame *f = top(p);
    if (!f || (f->kind != CALL && f->kind != DER))
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX,
                    "a comma stands outside the arguments of a function; decimals are written with a point");
    if (f->kind == DER && f->args)
        return FAIL(p, p->tok.start, SGA_E_EXPR_ARITY, "der takes an expression and an order: der(x*y) or der(x*y, 2)");
    f->args++;
    advance(p);
    return true;
}

static bool equality(struct parser *p)
{
    if (!p->equation)
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX,
                    "an equation is not expected here; write left - right, which is to vanish");
    if (p->equal_seen)
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX, "an equation has one sign of equality; this is the second");
    if (!finish_down_to(p, PREC_SUM))
        return false;
    if (p->frames)
        return FAIL(p, top(p)->at, SGA_E_EXPR_SYNTAX, "this ( is not closed before the sign of equality");
    p->equal_seen = true;
    return binary(p, EXPR_SUB, PREC_EQUAL);
}

static bool expected_operator(struct parser *p)
{
    char shown[LEX_SHOWN];
    lex_show(p->text, p->tok, shown);
    if (p->tok.kind == LEX_BAD)
        return expected_operand(p);
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
    default:        return expected_operator(p);
    }
}

static bool run(struct parser *p)
{
    bool operand = true;
    while (operand || p->tok.kind != LEX_END)
        if (!(operand ? take_operand(p, &operand) : take_operator(p, &operand)))
            return false;
    if (!finish_down_to(p, PREC_SUM))
        return false;
    struct frame *f = top(p);
    if (f && f->kind != BINARY)
        return FAIL(p, f->at, SGA_E_EXPR_SYNTAX, "this %s is not closed", f->kind == CALL ? "function's (" : "(");
    if (p->equation && !p->equal_seen)
        return FAIL(p, p->tok.start, SGA_E_EXPR_SYNTAX, "an equation needs a sign of equality: left = right");
    return finish_down_to(p, PREC_EQUAL);
}

static expr_id parse(struct expr_store *st, const char *text, const struct expr_grammar *g, bool equation,
                     struct sga_error *err)
{
    struct sga_error own = { 0 };
    struct parser p = { .st = st, .text = text, .err = err ? err : &own, .equation = equation };
    if (!expr_store_ok(st) || p.err->code != SGA_E_OK) {
        sga_fail(p.err, st->error.code, "%s", st->error.detail);
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
    return e;
}

bool expr_reserved(const char *name)
{
    return strcmp(name, "pi") == 0 || strcmp(name, "der") == 0 || expr_function(name, strlen(name)) != EXPR_UNDEF_OP;
}

expr_id expr_parse(struct expr_store *st, const char *text, const struct expr_grammar *g, struct sga_error *err)
{
    return parse(st, text, g, false, err);
}

expr_id expr_parse_equation(struct expr_store *st, const char *text, const struct expr_grammar *g,
                            struct sga_error *err)
{
    return parse(st, text, g, true, err);
}
