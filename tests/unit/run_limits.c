/* Cancelled at any of the times at which it is asked, a job ends soon and says that it was cancelled: what was stopped in
 * the middle of a loop is neither an answer nor a refusal for another reason. The seconds are asked for at the same places.
 * Asks are counted, times are not measured. */
#include <string.h>

#include "check.h"
#include "error.h"
#include "run.h"

struct asked { long count, limit; };

static bool cancelled(void *ctx)
{
    struct asked *a = ctx;
    return ++a->count > a->limit;
}

/* The asks of a whole run, or until it was cancelled and after. */
static long run(const char *request, long limit, enum sga_code *code)
{
    struct asked a = { 0, limit };
    struct sga_run_options options = { .cancelled = cancelled, .ctx = &a };
    struct sga_buf out = { 0 };
    struct sga_error err = { 0 };
    bool ok = sga_run(request, strlen(request), &options, &out, &err);
    *code = ok ? SGA_E_OK : err.code;
    CHECK(ok || err.code == SGA_E_CANCELLED, "limit %ld: %d %s", limit, err.code, err.detail);
    sga_buf_free(&out);
    return a.count;
}

/* `least`: asks of a whole run; `most`: those that come after the first one that says no. */
static void at_all_times(const char *name, struct sga_buf *request, long least, long most)
{
    enum sga_code code;
    long all = run(request->data, 1000000000, &code);
    CHECK(code == SGA_E_OK && all >= least, "%s: code %d, %ld asks", name, code, all);
    for (long k = 0; k < all; k += 1 + k / 3) {
        long count = run(request->data, k, &code);
        CHECK(code == SGA_E_CANCELLED || count <= k, "%s: code %d after %ld of %ld asks", name, code, k, all);
        CHECK(count - k <= most, "%s: %ld asks after %ld of %ld", name, count - k, k, all);
    }
    sga_buf_free(request);
}

static void names(struct sga_buf *b, int n)
{
    for (int i = 0; i < n; i++)
        sga_buf_printf(b, "%s\"x%d\"", i ? ", " : "", i);
}

/* n variables in a ring. */
static void ring(struct sga_buf *b, int n, const char *rest)
{
    sga_buf_puts(b, "{\"system\": {\"form\": \"equations\", \"variables\": [");
    names(b, n);
    sga_buf_puts(b, "], \"equations\": [");
    for (int i = 0; i < n; i++)
        sga_buf_printf(b, "%s\"x%d' = -x%d^3 + sin(x%d)/3 + x%d*x%d/10\"", i ? ", " : "", i, i, (i + 1) % n, (i + 3) % n, (i + 7) % n);
    sga_buf_puts(b, "]}, \"want\": [\"trajectory\"], \"trajectory\": {\"stop\": 1, \"samples\": 3, \"initial\": {");
    for (int i = 0; i < n; i++)
        sga_buf_printf(b, "%s\"x%d\": \"%d/10\"", i ? ", " : "", i, i * 7 % 11 - 5);
    sga_buf_printf(b, "}}, %s}", rest);
}

static void in_balls(void)
{
    struct sga_buf b = { 0 };
    ring(&b, 24, "\"accuracy\": {\"arithmetic\": \"ball\", \"rtol\": 1e-12}");
    at_all_times("one step of balls", &b, 1000, 100);
}

static void implicit(void)
{
    struct sga_buf b = { 0 };
    ring(&b, 48, "\"accuracy\": {\"arithmetic\": \"double\", \"method\": \"radau\", \"rtol\": 1e-6}");
    at_all_times("implicit steps", &b, 230, 60);
}

/* Half of the variables follow from the others, by equations of many terms; the start is far off. */
static void starts(void)
{
    enum { N = 60, C = 30 };
    struct sga_buf b = { 0 };
    sga_buf_puts(&b, "{\"system\": {\"form\": \"equations\", \"variables\": [");
    names(&b, N);
    sga_buf_puts(&b, "], \"equations\": [");
    for (int i = 0; i < N - C; i++)
        sga_buf_printf(&b, "\"x%d' = -x%d\", ", i, i);
    for (int k = 0; k < C; k++)
        sga_buf_printf(&b, "%s\"0 = x%d^3 + 3*x%d + sin(x%d) + x%d*x%d - %d\"", k ? ", " : "", N - C + k, N - C + k, k, k, (k + 5) % (N - C), k % 7);
    sga_buf_puts(&b, "]}, \"want\": [\"consistent_initial\"], \"trajectory\": {\"start\": 0, \"initial\": {");
    for (int i = 0; i < N; i++)
        sga_buf_printf(&b, "%s\"x%d\": %d", i ? ", " : "", i, i % 5 + 1);
    sga_buf_puts(&b, "}}}");
    at_all_times("a consistent start", &b, 1300, 120);
}

static void pieces(void)
{
    struct sga_buf b = { 0 };
    sga_buf_puts(&b, "{\"system\": {\"form\": \"equations\", \"variables\": [\"x\"], \"equations\": [\"x' = 0");
    for (int k = 1; k < 8; k++)
        sga_buf_printf(&b, " + exp(-10^6*(t - %d/8)^2)*sin(%d*t)", k, 100 + k);
    sga_buf_puts(&b, "\"]}, \"want\": [\"trajectory\"], \"trajectory\": {\"stop\": 1, \"samples\": 3, \"initial\": {\"x\": 0}}}");
    at_all_times("pieces of an input", &b, 1000, 60);
}

static void events(void)
{
    struct sga_buf b = { 0 };
    sga_buf_puts(&b, "{\"system\": {\"form\": \"equations\", \"variables\": [\"x\"], \"equations\": [\"x' = cos(t)\"]}, \"want\": [\"trajectory\"], "
                 "\"accuracy\": {\"arithmetic\": \"double-double\", \"rtol\": 1e-20}, \"trajectory\": {\"stop\": 2, \"samples\": 3, "
                 "\"initial\": {\"x\": 0}, \"events\": [{\"name\": \"e\", \"expression\": \"sin(200*t)\"}]}}");
    at_all_times("events in double-double", &b, 250, 60);
}

int main(void)
{
    sga_init();
    in_balls();
    implicit();
    starts();
    pieces();
    events();
    return CHECK_END();
}
