/* The request reader: any bytes are read or refused with a code and words; the canonical text
 * of a request is one more spelling of it, and its own canonical text. */
#include <string.h>

#include "buf.h"
#include "error.h"
#include "fuzz.h"
#include "request.h"

const char *const fuzz_words[] = { "{\"system\":", "\"form\":", "\"quasilinear\"", "\"equations\"", "\"linear\"", "\"control\"", "\"hamiltonian\"",
    "\"lagrangian\"", "\"mechanical\"", "\"operator\"", "\"variables\":[\"x\"]", "\"A\":", "\"B\":", "\"alpha\":", "\"restrict\":", "\"entries\":[[0,0,1]]",
    "\"rows\":", "\"cols\":", "\"parameters\":{\"r\":", "null", "\"trajectory\":{\"stop\":1,\"samples\":", "\"initial\":{\"x\":", "\"hold\":[\"x\"]",
    "\"gauge\":{\"rates\":{", "\"conditions\":[", "\"events\":[{\"name\":\"e\",\"expression\":\"x\"}]", "\"sweep\":[{\"initial\":{}}]",
    "\"symmetries\":{\"check\":[", "\"search\":{\"degree\":1}", "\"limits\":{\"seconds\":", "\"accuracy\":{\"rtol\":", "\"strata\":\"solve\"",
    "\"want\":[\"index\"]", "\"x' = y\"", "\"x^2 + y^2 = 1\"", "der(x,2)", "1e999", "1e-400", "99999999999999999999", "\\u0000", "\\ud800", "[", "]", "{", "}",
    ",", "\"", "-0", "0.1", "true", NULL };

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

static void check_refusal(const struct sga_error *err)
{
    FUZZ_REQUIRE(err->code > SGA_E_OK && err->code < SGA_E_COUNT && err->code != SGA_E_INTERNAL && *err->detail,
                 "code %d: %s", (int)err->code, err->detail);
    FUZZ_REQUIRE(*err->pointer == 0 || *err->pointer == '/', "pointer %s", err->pointer);
    int status = sga_code_status(err->code);
    FUZZ_REQUIRE(status == 400 || status == 422, "status %d", status);
}

/* In narrow bounds, so that many inputs are tried; what meets the bounds is neither good nor bad. */
static bool reads(const char *text, size_t size, bool *known)
{
    struct request r;
    struct request_bounds bounds = { .seconds = 0.5, .nodes = 50000 };
    struct sga_error err = { 0 };
    bool ok = request_read_within(&r, text, size, &bounds, &err);
    if (ok)
        request_clear(&r);
    else
        check_refusal(&err);
    *known = !bounds.met && err.code != SGA_E_LIMIT_SECONDS;
    return ok;
}

/* What ends a plain reading is among all that is wrong; nothing is where it reads. */
static void reads_all(const char *text, size_t size, bool ok)
{
    struct request r;
    struct request_bounds bounds = { .seconds = 0.5, .nodes = 50000 };
    struct request_faults faults;
    bool all = request_read_all(&r, text, size, &bounds, &faults);
    if (all && !bounds.met)
        request_clear(&r);
    for (int i = 0; i < faults.count; i++)
        check_refusal(&faults.list[i]);
    FUZZ_REQUIRE(all == ok || bounds.met, "read %d, all of it %d, %d faults", ok, all, faults.count);
    request_faults_clear(&faults);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct sga_buf one = { 0 }, two = { 0 };
    struct sga_error err = { 0 };
    bool known, again;
    bool ok = reads((const char *)data, size, &known);
    if (known)
        reads_all((const char *)data, size, ok);
    if (request_canonical((const char *)data, size, &one, &err)) {
        FUZZ_REQUIRE(request_canonical(one.data, one.len, &two, &err), "the canonical text: %s", err.detail);
        FUZZ_REQUIRE(one.len == two.len && memcmp(one.data, two.data, one.len) == 0, "%s became %s", one.data, two.data);
        bool ok_again = reads(one.data, one.len, &again);
        FUZZ_REQUIRE(ok == ok_again || !known || !again, "%s is read %d, then %d", one.data, ok, ok_again);
    } else {
        check_refusal(&err);
        FUZZ_REQUIRE(!ok, "read, but without a canonical text: %s", err.detail);
    }
    sga_buf_free(&one);
    sga_buf_free(&two);
    return 0;
}
