/* What the parser refuses: code, line, column and a word of the message; and mutated texts,
 * which must be read or refused, never crash, and leave the store usable. */
#include <string.h>

#include "buf.h"
#include "check.h"
#include "error.h"
#include "mem.h"
#include "parse.h"

static expr_id refuse(void *ctx, int symbol, int order)
{
    (void)ctx, (void)symbol, (void)order;
    return EXPR_UNDEF;
}

static expr_id accept(void *ctx, int symbol, int order)
{
    (void)symbol, (void)order;
    return expr_int(ctx, 7);
}

static expr_id same(void *ctx, expr_id e)
{
    (void)ctx;
    return e;
}

static void fresh(struct expr_store *st)
{
    static const char *const names[] = { "x", "y", "omega", "phi", "theta_1" };
    expr_store_init(st);
    for (int i = 0; i < 5; i++)
        expr_symbol_add(st, names[i], EXPR_VARIABLE);
}

static const struct {
    const char *text;
    bool equation;
    enum sga_code code;
    int line, column;
    const char *says;
} table[] = {
    { "", 0, SGA_E_EXPR_SYNTAX, 1, 1, "empty" },
    { "  \n ", 0, SGA_E_EXPR_SYNTAX, 2, 2, "empty" },
    { "2x", 0, SGA_E_EXPR_SYNTAX, 1, 2, "joined with *" },
    { "x y", 0, SGA_E_EXPR_SYNTAX, 1, 3, "joined with *" },
    { "2(x)", 0, SGA_E_EXPR_SYNTAX, 1, 2, "joined with *" },
    { "(x)(y)", 0, SGA_E_EXPR_SYNTAX, 1, 4, "joined with *" },
    { "1.2.3", 0, SGA_E_EXPR_SYNTAX, 1, 4, "operator" },
    { "0x10", 0, SGA_E_EXPR_SYNTAX, 1, 2, "x10" },
    { "x +", 0, SGA_E_EXPR_SYNTAX, 1, 4, "the end" },
    { "x + * y", 0, SGA_E_EXPR_SYNTAX, 1, 5, "'*'" },
    { "* x", 0, SGA_E_EXPR_SYNTAX, 1, 1, "'*'" },
    { "x ***y", 0, SGA_E_EXPR_SYNTAX, 1, 5, "'*'" },
    { "(x + y", 0, SGA_E_EXPR_SYNTAX, 1, 1, "not closed" },
    { "sin(x", 0, SGA_E_EXPR_SYNTAX, 1, 1, "not closed" },
    { "x + y)", 0, SGA_E_EXPR_SYNTAX, 1, 6, "closes nothing" },
    { "()", 0, SGA_E_EXPR_SYNTAX, 1, 2, "empty" },
    { "x, y", 0, SGA_E_EXPR_SYNTAX, 1, 2, "comma" },
    { "(x, y)", 0, SGA_E_EXPR_SYNTAX, 1, 3, "comma" },
    { "sin x", 0, SGA_E_EXPR_SYNTAX, 1, 1, "parentheses" },
    { "x = y", 0, SGA_E_EXPR_SYNTAX, 1, 3, "not expected" },
    { "x", 1, SGA_E_EXPR_SYNTAX, 1, 2, "left = right" },
    { "x = y = 1", 1, SGA_E_EXPR_SYNTAX, 1, 7, "second" },
    { "x =", 1, SGA_E_EXPR_SYNTAX, 1, 4, "the end" },
    { "= x", 1, SGA_E_EXPR_SYNTAX, 1, 1, "'='" },
    { "(x = y)", 1, SGA_E_EXPR_SYNTAX, 1, 1, "not closed" },
    { "x = y)", 1, SGA_E_EXPR_SYNTAX, 1, 6, "closes nothing" },
    { "omga", 0, SGA_E_EXPR_NAME, 1, 1, "'omega'" },
    { "x +\n 3*theta1", 0, SGA_E_EXPR_NAME, 2, 4, "'theta_1'" },
    { "sn(x)", 0, SGA_E_EXPR_NAME, 1, 1, "'sin'" },
    { "Sin(x)", 0, SGA_E_EXPR_NAME, 1, 1, "'sin'" },
    { "ln(x)", 0, SGA_E_EXPR_NAME, 1, 1, "log" },
    { "Pi", 0, SGA_E_EXPR_NAME, 1, 1, "'pi'" },
    { "qqqqqqq", 0, SGA_E_EXPR_NAME, 1, 1, "no variable" },
    { "y(x)", 0, SGA_E_EXPR_SYNTAX, 1, 2, "joined with *" },
    { "NaN", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "not a number" },
    { "1 + nan", 0, SGA_E_EXPR_UNDEFINED, 1, 5, "not a number" },
    { "-Infinity", 0, SGA_E_EXPR_UNDEFINED, 1, 2, "not a number" },
    { "inf", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "not a number" },
    { "1/0", 0, SGA_E_EXPR_UNDEFINED, 1, 2, "division" },
    { "0/0", 0, SGA_E_EXPR_UNDEFINED, 1, 2, "division" },
    { "x/(1 - 1)", 0, SGA_E_EXPR_UNDEFINED, 1, 2, "division" },
    { "x + 0^-1", 0, SGA_E_EXPR_UNDEFINED, 1, 6, "power of zero" },
    { "0^x", 0, SGA_E_EXPR_UNDEFINED, 1, 2, "power of 0" },
    { "(-8)^(1/3)", 0, SGA_E_EXPR_UNDEFINED, 1, 5, "cbrt" },
    { "(-8)^0.5", 0, SGA_E_EXPR_UNDEFINED, 1, 5, "negative" },
    { "sqrt(-2)", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "negative" },
    { "log(0)", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "log" },
    { "x + asin(2)", 0, SGA_E_EXPR_UNDEFINED, 1, 5, "asin" },
    { "acosh(1/2)", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "acosh" },
    { "atanh(1)", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "atanh" },
    { "atan2(0, 0)", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "atan2" },
    /* constants once they are sorted, as their print would be */
    { "1/(1 - x*(x/x^2))", 0, SGA_E_EXPR_UNDEFINED, 1, 2, "is 0 wherever" },
    { "x^(1/(1 - x*(x/x^2))^3)", 0, SGA_E_EXPR_UNDEFINED, 1, 5, "is 0 wherever" },
    { "y + x/(x - (x - y) - y)", 0, SGA_E_EXPR_UNDEFINED, 1, 6, "is 0 wherever" },
    { "(x - (x - y) - y)^-2", 0, SGA_E_EXPR_UNDEFINED, 1, 18, "power of zero" },
    { "(x - (x - y) - y)^y", 0, SGA_E_EXPR_UNDEFINED, 1, 18, "power of 0" },
    { "log(x - (x - y) - y)", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "log" },
    { "log10(x - (x - y) - y)", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "log10" },
    { "sqrt(x - (x - y) - y - 1)", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "negative" },
    { "asin(1 + x*(x/x^2))", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "asin" },
    { "atan2(x - (x - y) - y, 0)", 0, SGA_E_EXPR_UNDEFINED, 1, 1, "atan2" },
    { "1/(sin(x*(x/x^2)) - sin(1))", 0, SGA_E_EXPR_UNDEFINED, 1, 2, "is 0 wherever" },
    { "1/(cos(x - (x - y)) - cos(y) + sqrt(4) - (x + 2) + x)", 0, SGA_E_EXPR_UNDEFINED, 1, 2, "is 0 wherever" },
    { "sin(x, y)", 0, SGA_E_EXPR_ARITY, 1, 1, "1 argument" },
    { "atan2(x)", 0, SGA_E_EXPR_ARITY, 1, 1, "2 arguments" },
    { "min(x)", 0, SGA_E_EXPR_ARITY, 1, 1, "2 arguments or more" },
    { "sin()", 0, SGA_E_EXPR_ARITY, 1, 1, "no argument" },
    { "sin(x,)", 0, SGA_E_EXPR_SYNTAX, 1, 7, "')'" },
    { "x'", 0, SGA_E_EXPR_DERIVATIVE, 1, 1, "not allowed" },
    { "y + der(x, 2)", 0, SGA_E_EXPR_DERIVATIVE, 1, 9, "not allowed" },
    { "der(x + y)", 0, SGA_E_EXPR_DERIVATIVE, 1, 7, "inside der" },
    { "der(2)", 0, SGA_E_EXPR_DERIVATIVE, 1, 5, "variable" },
    { "der(x, 0)", 0, SGA_E_EXPR_DERIVATIVE, 1, 8, "positive" },
    { "der(x, 1.5)", 0, SGA_E_EXPR_DERIVATIVE, 1, 8, "positive" },
    { "der(x, 99999999999999999999)", 0, SGA_E_EXPR_DERIVATIVE, 1, 5, "limit of 64" },
    { "der x", 0, SGA_E_EXPR_SYNTAX, 1, 1, "der(x)" },
    { "x '", 0, SGA_E_EXPR_SYNTAX, 1, 3, "quote" },
    { "2'", 0, SGA_E_EXPR_SYNTAX, 1, 2, "quote" },
    { "\u03B1 + x", 0, SGA_E_EXPR_SYNTAX, 1, 1, "grammar" },
    { "x\u2212y", 0, SGA_E_EXPR_SYNTAX, 1, 2, "write -" },
    { "x*2\u00B7y", 0, SGA_E_EXPR_SYNTAX, 1, 4, "write *" },
    { "x + \xFFy", 0, SGA_E_EXPR_SYNTAX, 1, 5, "0xFF" },
    { "x $ y", 0, SGA_E_EXPR_SYNTAX, 1, 3, "'$'" },
    { "x^10001", 0, SGA_E_LIMIT_EXPONENT, 1, 2, "10000" },
    { "x^-10001", 0, SGA_E_LIMIT_EXPONENT, 1, 2, "10000" },
    { "(x^200)^200", 0, SGA_E_LIMIT_EXPONENT, 1, 8, "40000" },
    { "1/(sign(-x)^45)^449", 0, SGA_E_LIMIT_EXPONENT, 1, 16, "20205" },
    { "2^2^40", 0, SGA_E_LIMIT_EXPONENT, 1, 2, "10000" },
    { "9^9^9", 0, SGA_E_LIMIT_EXPONENT, 1, 2, "10000" },
    { "(9^9999)^9999", 0, SGA_E_LIMIT_BITS, 1, 9, "bits" },
    { "x^(100001/2)", 0, SGA_E_LIMIT_EXPONENT, 1, 2, "10000" },
    { "1e5001", 0, SGA_E_LIMIT_BITS, 1, 1, "5000" },
    { "1e-99999999999999999999", 0, SGA_E_LIMIT_BITS, 1, 1, "5000" },
};

static void refusals(void)
{
    struct expr_grammar g = { .derivative = refuse };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct expr_store st;
        struct sga_error err = { 0 };
        fresh(&st);
        expr_id e = (table[i].equation ? expr_parse_equation : expr_parse)(&st, table[i].text, &g, &err);
        CHECK(!e && err.code == table[i].code && err.line == table[i].line && err.column == table[i].column
                  && strstr(err.detail, table[i].says),
              "\"%s\": %s %d:%d %s", table[i].text, sga_code_text(err.code), err.line, err.column, err.detail);
        CHECK(expr_store_ok(&st), "the store stays usable after %s", table[i].text);
        expr_store_clear(&st);
    }
}

static char *repeated(const char *s, int n, const char *tail)
{
    struct sga_buf b = { 0 };
    for (int i = 0; i < n; i++)
        sga_buf_puts(&b, s);
    sga_buf_puts(&b, tail);
    return sga_buf_take(&b);
}

static void limit(char *text, const struct expr_grammar *g, enum sga_code code, const char *says)
{
    struct expr_store st;
    struct sga_error err = { 0 };
    fresh(&st);
    expr_id e = expr_parse(&st, text, g, &err);
    CHECK(err.code == code && (code == SGA_E_OK) == (e != 0) && strstr(err.detail, says), "%.20s...: %s %s", text,
          sga_code_text(err.code), err.detail);
    expr_store_clear(&st);
    free(text);
}

static void limits(void)
{
    struct expr_grammar small = { .max_length = 10, .max_depth = 5, .max_exponent = 3, .max_digits = 4 };
    limit(repeated("(", 1000000, ""), NULL, SGA_E_EXPR_DEPTH, "1000");
    limit(repeated("-", 100000, "x"), NULL, SGA_E_EXPR_DEPTH, "1000");
    limit(repeated("x^", 100000, "x"), NULL, SGA_E_EXPR_DEPTH, "1000");
    limit(repeated("sin(", 5000, "x"), NULL, SGA_E_EXPR_DEPTH, "1000");
    limit(repeated("x+", 2000000, "x"), NULL, SGA_E_EXPR_SIZE, "1048576");
    limit(repeated("x*y+", 200000, "x"), NULL, SGA_E_OK, "");
    limit(repeated("1", 5001, ""), NULL, SGA_E_LIMIT_BITS, "5000");
    limit(repeated("1", 5000, ""), NULL, SGA_E_OK, "");
    limit(repeated("x+", 5, "x"), &small, SGA_E_EXPR_SIZE, "10");
    limit(repeated("(", 5, "x)))))"), &(struct expr_grammar){ .max_depth = 4 }, SGA_E_EXPR_DEPTH, "4");
    limit(repeated("x^4", 1, ""), &small, SGA_E_LIMIT_EXPONENT, "3");
    limit(repeated("12345", 1, ""), &small, SGA_E_LIMIT_BITS, "4");
    struct sga_buf wide = { 0 };
    sga_buf_puts(&wide, "min(x");
    for (int i = 0; i < 20000; i++)
        sga_buf_puts(&wide, ",y*x");
    sga_buf_puts(&wide, ")");
    limit(sga_buf_take(&wide), NULL, SGA_E_OK, "");
}

static unsigned next(unsigned long *seed, unsigned n)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(*seed >> 33) % n;
}

/* Texts of the table and some good ones, spliced and scrambled. */
static void mutations(void)
{
    static const char *const good[] = { "sin(x)^2 + cos(y)*-3.5e-2", "atan2(y, x)/(omega - phi)^(1/3)", "der(x, 2) = min(x, y, 3)",
                                        "x'' + 2**-3*theta_1'", "((x))*log(4)^-2", "\u03B1\u2212(2" };
    static const char bits[] = "()+-*/^,'=~.e0123456789xypi sincosder\n\xC3\xA9\xFF$";
    unsigned long seed = check_seed(77);
    int read = 0, refused = 0, located = 0, usable = 0, n = check_scale(20000);
    for (int i = 0; i < n; i++) {
        char text[128];
        const char *from = good[next(&seed, 6)];
        size_t length = strlen(from);
        memcpy(text, from, length + 1);
        for (unsigned k = next(&seed, 5); k; k--) {
            size_t at = next(&seed, (unsigned)length + 1);
            char c = bits[next(&seed, sizeof bits - 1)];
            unsigned how = next(&seed, 3);
            if (how == 0 && length < 100) {
                memmove(text + at + 1, text + at, length - at + 1);
                text[at] = c;
                length++;
            } else if (how == 1 && at < length) {
                memmove(text + at, text + at + 1, length - at);
                length--;
            } else if (at < length) {
                text[at] = c;
            }
        }
        struct expr_store st;
        struct sga_error err = { 0 };
        struct expr_grammar g = { .derivative = accept, .total = next(&seed, 2) ? same : NULL, .ctx = &st,
                                  .max_exponent = 50, .max_depth = 40 };
        fresh(&st);
        expr_id e = (next(&seed, 2) ? expr_parse_equation : expr_parse)(&st, text, &g, &err);
        read += e != 0;
        refused += e == 0;
        located += e ? err.code == SGA_E_OK : err.code != SGA_E_OK && err.line > 0 && err.column > 0 && err.detail[0];
        usable += expr_store_ok(&st);
        expr_store_clear(&st);
    }
    CHECK(located == n, "%d of %d have a place or a value", located, n);
    CHECK(usable == n, "stores stay usable");
    CHECK(read > n / 50 && refused > n / 2, "both happen: %d read, %d refused", read, refused);
}

int main(void)
{
    refusals();
    limits();
    mutations();
    return CHECK_END();
}
