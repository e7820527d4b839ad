/* The expression parser: any bytes are read or refused with a place, and what is printed of it
 * can be read. (That it means the same is tested by values in the unit tests.) */
#include <stdbool.h>
#include <string.h>

#include "buf.h"
#include "error.h"
#include "fuzz.h"
#include "parse.h"
#include "print.h"

const char *const fuzz_words[] = { "x", "y", "omega", "t", "sin(", "cos(", "atan2(", "min(", "max(", "abs(", "sqrt(", "exp(", "log(", "der(",
    "sign(", "cbrt(", "x'", "^", "**", "^-", "^(1/2)", "/0", "1/3", "1e5000", "0.1", "99999999999999999999", "(", ")", ",", "=", "==", "~", " ",
    "pi", "-", "+", "*", NULL };

/* What requests allow: a symbol's derivative, and the total derivative of an expression. */
static expr_id derivative(void *ctx, int symbol, int order)
{
    struct expr_store *st = ctx;
    return order > 3 ? EXPR_UNDEF : st->symbol[symbol < 2 ? symbol + 1 : symbol].node;
}

static expr_id total(void *ctx, expr_id e)
{
    return expr_mul(ctx, e, ((struct expr_store *)ctx)->symbol[0].node);
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    return 0;
}

void fuzz_end(void)
{
    flint_cleanup();
}

static void check_refusal(const struct sga_error *err, const char *text)
{
    int lines = 1;
    for (const char *c = text; *c; c++)
        lines += *c == '\n';
    FUZZ_REQUIRE(err->code > SGA_E_OK && err->code < SGA_E_COUNT && *err->detail, "code %d", (int)err->code);
    FUZZ_REQUIRE(err->code != SGA_E_INTERNAL, "%s", err->detail);
    FUZZ_REQUIRE(err->line >= 1 && err->line <= lines && err->column >= 1, "place %d:%d", err->line, err->column);
}

static void check_print(struct expr_store *st, const struct expr_grammar *g, expr_id e)
{
    struct sga_buf one = { 0 };
    struct sga_error err = { 0 };
    if (expr_print(st, e, 1 << 16, &one)) {
        expr_id back = expr_parse(st, one.data, g, &err);
        bool limit = err.code == SGA_E_EXPR_DEPTH || err.code == SGA_E_EXPR_SIZE || err.code == SGA_E_LIMIT_NODES
            || err.code == SGA_E_LIMIT_BITS || err.code == SGA_E_LIMIT_SECONDS;
        FUZZ_REQUIRE(back != EXPR_UNDEF || limit, "%s: %s", one.data, err.detail);
    }
    sga_buf_free(&one);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const names[] = { "x", "y", "omega" };
    char *text = malloc(size + 1);
    struct expr_store st;
    struct sga_error err = { 0 };
    expr_store_init(&st);
    for (int i = 0; i < 3; i++)
        expr_symbol_add(&st, names[i], EXPR_VARIABLE);
    expr_symbol_add(&st, "t", EXPR_TIME);
    st.max_nodes = 100000;
    st.max_bits = 1 << 17;
    st.max_work_bits = 1 << 24;
    struct expr_grammar g = { .derivative = derivative, .total = total, .ctx = &st };
    memcpy(text, data, size);
    text[size] = 0;
    bool equation = size > 0 && data[size - 1] % 2 == 0;
    expr_id e = equation ? expr_parse_equation(&st, text, &g, &err) : expr_parse(&st, text, &g, &err);
    if (e == EXPR_UNDEF)
        check_refusal(&err, text);
    else
        check_print(&st, &g, e);
    err = (struct sga_error){ 0 };
    FUZZ_REQUIRE(expr_parse(&st, "x + 1", &g, &err) != EXPR_UNDEF || err.code == SGA_E_LIMIT_BITS || err.code == SGA_E_LIMIT_NODES,
                 "the store is not usable: %s", err.detail);
    expr_store_clear(&st);
    free(text);
    return 0;
}
