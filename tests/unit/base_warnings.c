/* The list of warnings: each once, in the table's order whatever came first; limits say their name and value. */
#include "check.h"

#include <string.h>

#include "budget.h"
#include "buf.h"
#include "error.h"
#include "warnings.h"

static char *text_of(struct sga_warnings *w)
{
    struct sga_buf out = { 0 };
    struct sga_json json;
    sga_json_begin(&json, &out);
    sga_warnings_write(w, &json);
    return sga_buf_take(&out);
}

static void fill(struct sga_budget *b, bool backwards)
{
    for (int i = 0; i < 4; i++)
        switch (backwards ? 3 - i : i) {
        case 0: sga_warn(b, SGA_W_UNUSED, "/system", "the variable %s", "b"); break;
        case 1: sga_warn(b, SGA_W_START_MOVED, "/trajectory/initial", "x"); break;
        case 2: sga_warn(b, SGA_W_UNUSED, "/system", "the variable %s", "a"); break;
        default: sga_warn(b, SGA_W_UNUSED, "", "the variable %s", "b"); break;
        }
    sga_warn(b, SGA_W_UNUSED, "/system", "the variable a");
}

/* Refusals name what was met, as far as there is room. */
static void explain(void)
{
    struct sga_warnings w = { 0 };
    struct sga_budget b = { .warnings = &w };
    struct sga_error err = { .code = SGA_E_UNDECIDED, .detail = "no" };
    sga_limits_explain(&w, &err);
    CHECK(strcmp(err.detail, "no") == 0, "%s", err.detail);
    sga_limit_open(&(struct sga_budget){ 0 }, SGA_LIMIT_GRAM_SIZE);
    sga_limit_open(&b, SGA_LIMIT_GRAM_SIZE);
    sga_limit_met(&b, SGA_LIMIT_ROUTES);
    sga_limit_met(&b, SGA_LIMIT_ZEROS_LISTED);
    CHECK(w.count == 2, "what stays undecided is no warning: %d", w.count);
    sga_limits_explain(&w, &err);
    CHECK(strstr(err.detail, "no. Limits were met: ") == err.detail && strstr(err.detail, "limit ROUTES: 16") && strstr(err.detail, "limit GRAM_SIZE: 36")
          && !strstr(err.detail, "ZEROS_LISTED"), "%s", err.detail);
    for (int k = 0; k < SGA_LIMITS; k++)
        sga_limit_open(&b, (enum sga_limit)k);
    for (int k = 0; k < 3; k++)
        sga_limits_explain(&w, &err);
    CHECK(strlen(err.detail) < sizeof err.detail, "%zu", strlen(err.detail));
    sga_warnings_clear(&w);
}

int main(void)
{
    explain();
    struct sga_warnings one = { 0 }, other = { 0 };
    struct sga_budget b = { .warnings = &one };
    sga_warn(NULL, SGA_W_UNUSED, "", "nobody asks");
    sga_limit_met(&(struct sga_budget){ 0 }, SGA_LIMIT_ROUTES);
    char *empty = text_of(&one);
    CHECK(strcmp(empty, "[]") == 0, "%s", empty);
    fill(&b, false);
    CHECK(one.count == 4, "%d", one.count);
    b.warnings = &other;
    fill(&b, true);
    char *a = text_of(&one), *c = text_of(&other);
    CHECK(strcmp(a, c) == 0, "%s %s", a, c);
    CHECK(strncmp(a, "[{\"code\":\"start_moved\",\"pointer\":\"/trajectory/initial\",\"detail\":\"x\"},{\"code\":\"unused_name\",\"pointer\":\"\"", 90) == 0, "%s", a);
    for (int k = 0; k < SGA_LIMITS; k++) {
        sga_warnings_clear(&one);
        b.warnings = &one;
        sga_limit_met(&b, (enum sga_limit)k);
        sga_limit_met(&b, (enum sga_limit)k);
        CHECK(one.count == 1 && strstr(one.list[0].detail, sga_limit_name((enum sga_limit)k)), "limit %d", k);
    }
    free(empty);
    free(a);
    free(c);
    sga_warnings_clear(&one);
    sga_warnings_clear(&other);
    return CHECK_END();
}
