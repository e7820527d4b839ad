/* What may not be negative where expressions have values: which functions are found, and that they are negative exactly where the expression has none. */
#include <math.h>
#include <stdlib.h>

#include "check_read.h"
#include "domain_ends.h"
#include "error.h"
#include "tape.h"

static struct expr_store st;

/* In one variable; how many ends it has. */
static const struct { const char *text; int ends; } cases[] = {
    { "sqrt(x - 1)", 1 },          { "log(x*(x - 1/2))", 1 },      { "acos(2*x)", 2 },     { "asin(x^2)", 1 },
    { "acosh(x + 2)", 1 },         { "atanh(x/3)", 2 },            { "(x - 1/4)^(3/2)", 1 }, { "sqrt(x^2 + 1)", 0 },
    { "sin(x) + exp(x)/2", 0 },    { "sqrt(x) + log(x)", 1 },      { "sqrt(1 - sqrt(x))", 2 }, { "cbrt(x) + atan(x)", 0 },
    { "sqrt(2)*x", 0 },            { "acos(1 - x)", 2 },
};

static void found(const char *text, int ends)
{
    expr_id root = check_read(&st, text);
    struct field_list l = { 0 };
    struct sga_error err = { 0 };
    domain_ends(&st, &root, 1, &l);
    CHECK(l.count == ends, "%s: %d", text, l.count);
    expr_id *all = malloc(((size_t)l.count + 1) * sizeof *all);
    for (int k = 0; k < l.count; k++)
        all[k] = l.e[k];
    all[l.count] = root;
    int symbol = expr_symbol_find(&st, "x", 1);
    struct num_tape *tape = num_tape_new(&st, all, l.count + 1, &symbol, 1, &err);
    double *out = malloc(((size_t)l.count + 1) * sizeof *out);
    for (double x = -4.0137; x < 4; x += 0.0731) {
        num_tape_eval(tape, &x, out);
        bool inside = true;
        for (int k = 0; k < l.count; k++)
            inside &= !(out[k] < 0);
        CHECK(isnan(out[l.count]) == !inside, "%s at %g", text, x);
    }
    num_tape_free(tape);
    free(all);
    free(out);
    free(l.e);
}

int main(void)
{
    expr_store_init(&st);
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        found(cases[k].text, cases[k].ends);
    expr_store_clear(&st);
    return CHECK_END();
}
