/* Unknown names: say what was probably meant. */
#include "parse_names.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "error.h"
#include "lex.h"
#include "lowered.h"
#include "names_family.h"
#include "suggest.h"

/* Spellings of other languages and books. */
static const struct {
    const char *name, *advice;
} foreign[] = {
    { "sum", "a sum is written sum(i = 1:3, x[i])" },
    { "ln", "write log(x)" }, { "arcsin", "write asin(x)" }, { "arccos", "write acos(x)" },
    { "arctan", "write atan(x)" }, { "arctan2", "write atan2(y, x)" }, { "arcsinh", "write asinh(x)" },
    { "arccosh", "write acosh(x)" }, { "arctanh", "write atanh(x)" }, { "arsinh", "write asinh(x)" },
    { "arcosh", "write acosh(x)" }, { "artanh", "write atanh(x)" }, { "tg", "write tan(x)" },
    { "cot", "write 1/tan(x)" }, { "sec", "write 1/cos(x)" }, { "csc", "write 1/sin(x)" },
    { "pow", "write x^y" }, { "ifelse", "write if(condition, a, b)" }, { "where", "write if(condition, a, b)" }, { "piecewise", "write if(condition, a, b)" },
    { "fabs", "write abs(x)" }, { "sgn", "write sign(x)" }, { "diff", "write der(x) or x'" },
    { "e", "write exp(1), or exp(x) for a power of e" }, { "dt", "write der(x) or x' for dx/dt" }, { "dif", "write der(x) or x'" },
    { "ddt", "write der(x) or x'" }, { "deriv", "write der(x) or x'" }, { "derivative", "write der(x) or x'" },
    { "heaviside", "write step(x)" },
};

/* Equal but for the case of ASCII letters. */
static bool spelled(const char *s, size_t n, const char *word)
{
    if (strlen(word) != n)
        return false;
    for (size_t i = 0; i < n; i++)
        if (tolower((unsigned char)s[i]) != word[i])
            return false;
    return true;
}

/* A symbol of three letters or more that begins the name, or that the name begins: lam for lambda. */
static const char *shortened(const struct expr_store *st, const char *name, size_t n)
{
    for (int i = 0; i < st->symbols; i++) {
        size_t m = strlen(st->symbol[i].name), less = m < n ? m : n;
        if (less >= 3 && memcmp(st->symbol[i].name, name, less) == 0)
            return st->symbol[i].name;
    }
    return NULL;
}

static const char *nearest(const struct expr_store *st, const char *name, size_t n, bool called)
{
    struct suggest s;
    suggest_begin(&s, name, n);
    if (!called)
        for (int i = 0; i < st->symbols; i++)
            suggest_offer(&s, st->symbol[i].name);
    for (int op = EXPR_SIN; op <= EXPR_MAX; op++)
        suggest_offer(&s, expr_op_text((enum expr_op)op));
    for (int i = 0; called && i < LOWERED_COUNT; i++)
        suggest_offer(&s, lowered_table[i].name);
    suggest_offer(&s, called ? "der" : "pi");
    return s.best || called ? s.best : shortened(st, name, n);
}

/* A name of the store that is no function: a variable, a coordinate. */
static bool stands(const struct expr_store *st, const char *name, size_t n)
{
    return n > 0 && expr_symbol_find(st, name, n) >= 0;
}

static void say_derivative(char *out, size_t size, const char *name, size_t n, bool second)
{
    int shown = n > 40 ? 40 : (int)n;
    snprintf(out, size, second ? "; write %.*s'' or der(%.*s, 2)" : "; write %.*s' or der(%.*s)", shown, name, shown, name);
}

/* Derivatives as other languages and books write them: dx/dt, Dx, xdot, x_dot, xddot of a name x that stands. */
static void foreign_derivative(const struct expr_store *st, const char *text, struct lex_token tok, char *out, size_t size)
{
    static const struct { const char *end; bool second; } ends[] = { { "_ddot", true }, { "ddot", true }, { "_dot", false }, { "dot", false } };
    const char *name = text + tok.start;
    size_t n = tok.length;
    for (size_t i = 0; i < sizeof ends / sizeof *ends && !out[0]; i++) {
        size_t m = strlen(ends[i].end);
        if (n > m && memcmp(name + n - m, ends[i].end, m) == 0 && stands(st, name, n - m))
            say_derivative(out, size, name, n - m, ends[i].second);
    }
    if (!out[0] && (name[0] == 'd' || name[0] == 'D') && stands(st, name + 1, n - 1))
        say_derivative(out, size, name + 1, n - 1, false);
}

/* The independent variable by another of its names. */
static void foreign_time(const struct expr_store *st, const char *name, size_t n, char *out, size_t size)
{
    if (!spelled(name, n, "time") && !spelled(name, n, "t"))
        return;
    for (int i = 0; i < st->symbols; i++)
        if (st->symbol[i].kind == EXPR_TIME)
            snprintf(out, size, "; the independent variable is %.40s here: write that, or give it another name in system.time", st->symbol[i].name);
}

void parse_unknown_name(const struct expr_store *st, const char *text, struct lex_token tok, bool called,
                        struct sga_error *err)
{
    const char *name = text + tok.start;
    char shown[LEX_SHOWN], more[192] = "";
    lex_show(text, tok, shown);
    if (spelled(name, tok.length, "nan") || spelled(name, tok.length, "inf")
        || spelled(name, tok.length, "infinity")) {
        sga_fail(err, SGA_E_EXPR_UNDEFINED, "%s is not a number here; every number is finite", shown);
        return;
    }
    if (called && tok.length == 1 && name[0] == 'D')
        snprintf(more, sizeof more, "; write der(x) or x' for the derivative of x");
    if (!called)
        foreign_derivative(st, text, tok, more, sizeof more);
    if (!called && !more[0])
        foreign_time(st, name, tok.length, more, sizeof more);
    char family[NAMES_FAMILY];
    size_t base = strcspn(name, "[");
    if (base < tok.length && expr_function(name, base))
        snprintf(more, sizeof more, "; the argument of a function stands in ( )");
    if (!called && !more[0] && names_family(st, name, tok.length, family))
        snprintf(more, sizeof more, "; %.180s", family);
    for (size_t i = 0; i < sizeof foreign / sizeof *foreign && !more[0]; i++)
        if (spelled(name, tok.length, foreign[i].name))
            snprintf(more, sizeof more, "; %s", foreign[i].advice);
    const char *near = more[0] ? NULL : nearest(st, name, tok.length, called);
    if (near)
        snprintf(more, sizeof more, "; did you mean '%.100s'?", near);
    else if (!more[0])
        snprintf(more, sizeof more, "%s", called ? "; a product needs * before the parenthesis"
                                                 : "; it is no variable, parameter or function");
    sga_fail(err, SGA_E_EXPR_NAME, "unknown %s %s%s", called ? "function" : "name", shown, more);
}
