/* A set found empty has no generations left, though pivots of later ones were met on the way: strata are listed all the same. */
#include <string.h>
#include <flint/flint.h>

#include "check.h"
#include "error.h"
#include "run.h"

static const char *const request =
    "{\"system\": {\"form\": \"quasilinear\", \"variables\": [\"x\", \"y\", \"s\"], \"A\": [[0, 1, 0], [0, 0, 0], [0, 0, 0]],"
    " \"alpha\": [\"y\", \"s - sqrt(x)\", \"s^2 + 1\"]}}";

int main(void)
{
    struct sga_buf out = { 0 };
    struct sga_error err = { 0 };
    sga_init();
    CHECK(sga_run(request, strlen(request), NULL, &out, &err), "%s", err.detail);
    CHECK(out.data && strstr(out.data, "\"verdict\":\"inconsistent\""), "it is inconsistent");
    sga_buf_free(&out);
    flint_cleanup();
    return CHECK_END();
}
