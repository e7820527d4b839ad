/* One restriction that stands for two functions (q1^2 + p1^2 = 0): what they determine comes from the one that was given, whose index the
 * answer names, and from no other. */
#include <string.h>
#include <flint/flint.h>

#include "check.h"
#include "error.h"
#include "run.h"

static const char *const request =
    "{\"system\": {\"form\": \"hamiltonian\", \"variables\": [\"q1\", \"q2\", \"p1\", \"p2\"], \"hamiltonian\": \"(p1^2 + p2^2)/2 + q1*p2\","
    " \"restrict\": [\"q1^2 + p1^2\"]}, \"want\": [\"constraints\", \"index\", \"structure\", \"vector_field\"]}";

int main(void)
{
    static const char *const said[] = {
        "{\"derivative_of\":\"q1\",\"equations\":[{\"restriction\":0,\"differentiated\":1}]}",
        "{\"derivative_of\":\"p1\",\"equations\":[{\"restriction\":0,\"differentiated\":1}]}", "\"verdict\":\"unique\"" };
    struct sga_buf out = { 0 };
    struct sga_error err = { 0 };
    sga_init();
    CHECK(sga_run(request, strlen(request), NULL, &out, &err), "%s", err.detail);
    for (size_t i = 0; i < sizeof said / sizeof *said; i++)
        CHECK(out.data && strstr(out.data, said[i]), "%s", said[i]);
    CHECK(out.data && !strstr(out.data, "\"restriction\":1"), "there is no second restriction");
    sga_buf_free(&out);
    flint_cleanup();
    return CHECK_END();
}
