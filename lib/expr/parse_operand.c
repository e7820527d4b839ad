/* Operands of expressions: numbers, names, derivatives, and calls once all of their arguments are known. */
#include "parser.h"

#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "literal.h"
#include "parse_names.h"
#include "signal.h"

bool parser_expected_operand(struct parser *p)
{
    char shown[LEX_SHOWN];
    struct frame *f = parser_top(p);
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
        return FAIL(p, f->at, SGA_E_EXPR_ARITY, "the function %s has no argument", f->lowered ? f->lowered->name : expr_op_text(f->op));
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
    if (order > PARSER_MAX_ORDER)
        return FAIL(p, name.start, SGA_E_EXPR_DERIVATIVE, "a derivative of %s has an order past the limit of %d",
                    shown, PARSER_MAX_ORDER);
    bool signal = p->st->symbol[symbol].kind == EXPR_SIGNAL;
    expr_id e = signal ? signal_derivative(p->st, symbol, order)
              : p->g.derivative ? p->g.derivative(p->g.ctx, symbol, (int)order) : EXPR_UNDEF;
    if (!e && !expr_store_ok(p->st))
        return parser_fail_here(p, name.start);
    if (!e)
        return FAIL(p, name.start, SGA_E_EXPR_DERIVATIVE, "derivative number %ld of %s is not allowed here%s", order,
                    shown, p->g.derivative ? "" : "; only names without quotes are");
    parser_push_value(p, e);
    return true;
}

/* The symbol that a name means, or -1 with err filled. */
static int symbol_of(struct parser *p, struct lex_token tok, bool called)
{
    int symbol = expr_symbol_find(p->st, p->text + tok.start, tok.length);
    if (symbol < 0) {
        parse_unknown_name(p->st, p->text, tok, called, p->err);
        parser_fail_here(p, tok.start);
    } else {
        p->st->symbol[symbol].mentioned = true;
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
    parser_advance(p);
    if (p->tok.kind != LEX_OPEN)
        return FAIL(p, at, SGA_E_EXPR_SYNTAX, "der needs ( after it: der(x) or der(x, 2)");
    parser_advance(p);
    struct lex_token name = p->tok;
    if (p->g.total && !names_one_variable(p)) {
        *operand = true;
        return parser_push_frame(p, (struct frame){ .kind = DER, .at = at });
    }
    if (name.kind != LEX_NAME)
        return FAIL(p, p->tok.start, SGA_E_EXPR_DERIVATIVE, "der takes the name of a variable");
    int symbol = symbol_of(p, name, false);
    if (symbol < 0)
        return false;
    parser_advance(p);
    long order = 1;
    if (p->tok.kind == LEX_QUOTES) {
        order += p->tok.length > PARSER_MAX_ORDER ? PARSER_MAX_ORDER : (long)p->tok.length;
        parser_advance(p);
    }
    if (p->tok.kind == LEX_COMMA) {
        parser_advance(p);
        char *end;
        long times = p->tok.kind == LEX_NUMBER ? strtol(p->text + p->tok.start, &end, 10) : 0;
        if (times < 1 || end != p->text + p->tok.start + p->tok.length)
            return FAIL(p, p->tok.start, SGA_E_EXPR_DERIVATIVE, "the order of a derivative is a positive integer");
        order += (times > PARSER_MAX_ORDER ? PARSER_MAX_ORDER + 1 : times) - 1;
        parser_advance(p);
    }
    if (p->tok.kind != LEX_CLOSE) {
        char shown[LEX_SHOWN];
        lex_show(p->text, p->tok, shown);
        return FAIL(p, p->tok.start, SGA_E_EXPR_DERIVATIVE,
                    "found %s inside der, which takes the name of a variable and an order: der(x) or der(x, 2)", shown);
    }
    parser_advance(p);
    return derivative(p, name, symbol, order);
}

static bool name_operand(struct parser *p, bool *operand)
{
    struct lex_token name = p->tok;
    if (is_word(p->text, name, "der"))
        return der_call(p, operand);
    if (is_word(p->text, name, "pi")) {
        parser_advance(p);
        parser_push_value(p, expr_pi(p->st));
        *operand = false;
        return expr_store_ok(p->st) || parser_fail_here(p, name.start);
    }
    bool stands = expr_symbol_find(p->st, p->text + name.start, name.length) >= 0;
    if (is_word(p->text, name, "not") && !stands && parser_in_condition(p)) {
        parser_advance(p);
        return parser_push_frame(p, (struct frame){ .kind = PREFIX, .logic = LOGIC_NOT, .prec = PREC_NOT, .at = name.start });
    }
    enum expr_op op = stands ? EXPR_UNDEF_OP : expr_function(p->text + name.start, name.length);   /* no name is a function's */
    const struct lowered *lowered = stands ? NULL : lowered_function(p->text + name.start, name.length);
    parser_advance(p);
    if (lowered && p->tok.kind == LEX_OPEN) {
        parser_advance(p);
        return parser_push_frame(p, (struct frame){ .kind = CALL, .lowered = lowered, .at = name.start });
    }
    if (op && p->tok.kind != LEX_OPEN)
        return FAIL(p, name.start, SGA_E_EXPR_SYNTAX, "the function %s needs its argument in parentheses",
                    expr_op_text(op));
    if (op) {
        parser_advance(p);
        return parser_push_frame(p, (struct frame){ .kind = CALL, .op = op, .at = name.start });
    }
    int symbol = symbol_of(p, name, p->tok.kind == LEX_OPEN);
    if (symbol < 0)
        return false;
    *operand = false;
    if (p->tok.kind == LEX_QUOTES && p->tok.start == name.start + name.length) {
        long order = p->tok.length > PARSER_MAX_ORDER ? PARSER_MAX_ORDER + 1 : (long)p->tok.length;
        parser_advance(p);
        return derivative(p, name, symbol, order);
    }
    bool replaced = symbol < p->g.values && p->g.value[symbol];
    parser_push_value(p, replaced ? p->g.value[symbol] : p->st->symbol[symbol].node);
    return true;
}

bool parser_take_operand(struct parser *p, bool *operand)
{
    size_t at = p->tok.start;
    expr_id e;
    switch (p->tok.kind) {
    case LEX_NUMBER:
        e = literal_number(p->st, p->text + at, p->tok.length, p->g.max_digits, p->err);
        if (!e)
            return parser_fail_here(p, at);
        parser_push_value(p, e);
        *operand = false;
        parser_advance(p);
        return true;
    case LEX_NAME:
        return name_operand(p, operand);
    case LEX_PLUS:
    case LEX_MINUS:
        e = p->tok.kind == LEX_MINUS;
        parser_advance(p);
        return parser_push_frame(p, (struct frame){ .kind = PREFIX, .op = e ? EXPR_NEG : EXPR_ADD, .prec = PREC_SIGN, .at = at });
    case LEX_OPEN:
        parser_advance(p);
        return parser_push_frame(p, (struct frame){ .kind = GROUP, .at = at });
    default:
        return parser_expected_operand(p);
    }
}

/* The branches of if, and what others are given, are numbers. */
static bool numbers(struct parser *p, struct frame f, int args)
{
    bool condition = f.lowered && f.lowered->kind == LOWERED_IF;
    for (int i = condition; i < args; i++)
        if (p->truth[p->values - (size_t)args + (size_t)i])
            return FAIL(p, f.at, SGA_E_EXPR_SYNTAX, "a condition is no number; if(condition, 1, 0) is one");
    return true;
}

static bool finish_lowered(struct parser *p, struct frame f, int args)
{
    if (args < f.lowered->least || (f.lowered->most && args > f.lowered->most))
        return FAIL(p, f.at, SGA_E_EXPR_ARITY, "the function %s takes %d argument%s%s, not %d", f.lowered->name, f.lowered->least, f.lowered->least == 1 ? "" : "s",
                    f.lowered->most ? "" : " or more", args);
    const expr_id *arg = p->value + p->values - args;
    bool log = f.lowered->kind == LOWERED_LOG10 || f.lowered->kind == LOWERED_LOG2;
    const char *outside = log ? literal_outside(p->st, EXPR_LOG, parser_settled(p, arg[0]), EXPR_UNDEF) : NULL;
    if (outside)
        return FAIL(p, f.at, SGA_E_EXPR_UNDEFINED, "%s has no real value: %s", f.lowered->name, outside);
    expr_id e = lowered_call(p->st, f.lowered->kind, arg, args);
    if (!e)
        return parser_fail_here(p, f.at);
    p->values -= (size_t)args;
    parser_push_value(p, e);
    return true;
}

bool parser_finish_call(struct parser *p, struct frame f)
{
    int args = f.args + 1;
    if (!numbers(p, f, args))
        return false;
    if (f.lowered)
        return finish_lowered(p, f, args);
    bool folds = f.op == EXPR_MIN || f.op == EXPR_MAX;
    int want = expr_op_args(f.op);
    if (folds ? args < 2 : args != want)
        return FAIL(p, f.at, SGA_E_EXPR_ARITY, "the function %s takes %d argument%s%s, not %d", expr_op_text(f.op), want,
                    want == 1 ? "" : "s", folds ? " or more" : "", args);
    expr_id *arg = p->value + p->values - args;
    bool total = expr_op_traits(f.op) & EXPR_IS_TOTAL;
    const char *outside = total ? NULL : literal_outside(p->st, f.op, parser_settled(p, arg[0]), want == 2 ? parser_settled(p, arg[1]) : EXPR_UNDEF);
    if (outside)
        return FAIL(p, f.at, SGA_E_EXPR_UNDEFINED, "%s has no real value: %s", expr_op_text(f.op), outside);
    expr_id e = want == 1 ? expr_fun(p->st, f.op, arg[0]) : expr_fun2(p->st, f.op, arg[0], arg[1]);
    for (int i = 2; i < args; i++)
        e = expr_fun2(p->st, f.op, e, arg[i]);
    if (!e)
        return parser_fail_here(p, f.at);
    p->values -= (size_t)args;
    parser_push_value(p, e);
    return true;
}

/* der(e) or der(e, k), its arguments on the value stack. */
bool parser_finish_der(struct parser *p, struct frame f)
{
    long order = 1;
    if (f.args) {
        expr_id k = p->value[--p->values];
        const fmpq *q = expr_is_const(p->st, k) ? expr_const_value(p->st, k) : NULL;
        if (!q || !fmpz_is_one(fmpq_denref(q)) || fmpz_cmp_si(fmpq_numref(q), 1) < 0 || fmpz_cmp_si(fmpq_numref(q), PARSER_MAX_ORDER) > 0)
            return FAIL(p, f.at, SGA_E_EXPR_DERIVATIVE, "the order of a derivative is an integer from 1 to %d", PARSER_MAX_ORDER);
        order = fmpz_get_si(fmpq_numref(q));
    }
    expr_id e = p->value[--p->values];
    for (long k = 0; k < order && e; k++)
        e = p->g.total(p->g.ctx, e);
    if (!e && !expr_store_ok(p->st))
        return parser_fail_here(p, f.at);
    if (!e)
        return FAIL(p, f.at, SGA_E_EXPR_DERIVATIVE, "this derivative needs one of an order past the limit of %d", PARSER_MAX_ORDER);
    parser_push_value(p, e);
    return true;
}
