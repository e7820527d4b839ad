/* Unknown names: say what was probably meant. */
#include "parse_names.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "lex.h"
#include "suggest.h"

/* Spellings of other languages and books. */
static const struct {
    const char *name, *advice;
} foreign[] = {
    { "ln", "write log(x)" }, { "arcsin", "write asin(x)" }, { "arccos", "write acos(x)" },
    { "arctan", "write atan(x)" }, { "arctan2", "write atan2(y, x)" }, { "arcsinh", "write asinh(x)" },
    { "arccosh", "write acosh(x)" }, { "arctanh", "write atanh(x)" }, { "arsinh", "write asinh(x)" },
    { "arcosh", "write acosh(x)" }, { "artanh", "write atanh(x)" }, { "tg", "write tan(x)" },
    { "cot", "write 1/tan(x)" }, { "sec", "write 1/cos(x)" }, { "csc", "write 1/sin(x)" },
    { "log10", "write log(x)/log(10)" }, { "log2", "write log(x)/log(2)" }, { "pow", "write x^y" },
    { "fabs", "write abs(x)" }, { "sgn", "write sign(x)" }, { "diff", "write der(x) or x'" },
    { "e", "write exp(1), or exp(x) for a power of e" },
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

static const char *nearest(const struct expr_store *st, const char *name, size_t n, bool called)
{
    struct suggest s;
    suggest_begin(&s, name, n);
    if (!called)
        for (int i = 0; i < st->symbols; i++)
            suggest_offer(&s, st->symbol[i].name);
    for (int op = EXPR_SIN; op <= EXPR_MAX; op++)
        suggest_offer(&s, expr_op_text((enum expr_op)op));
    suggest_offer(&s, called ? "der" : "pi");
    return s.best;
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
